"""Several files of one recording on the command line: one zip, as the service takes it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZIP_STORED, ZipFile

from app.errors import InvalidInput


@contextmanager
def as_one(paths: Sequence[Path]) -> Iterator[Path]:
    """Give a recording as one file: itself, or a zip of its tables in a folder that goes again.

    Raises
    ------
    InvalidInput
        Two of them are one file.
    """
    if len(paths) == 1:
        yield paths[0]
        return
    if len({path.resolve() for path in paths}) < len(paths):
        raise InvalidInput("one file is given twice")
    is_apart = len({path.name for path in paths}) == len(paths)
    with TemporaryDirectory(prefix="telemotion-") as folder:
        packed = Path(folder) / "recording.zip"
        with ZipFile(packed, "w", ZIP_STORED) as archive:
            for path in paths:
                archive.write(path, path.name if is_apart else f"{path.resolve().parent.name}/{path.name}")
        yield packed
