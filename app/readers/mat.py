"""MATLAB files of versions 4 to 7, from strangers."""

from pathlib import Path
from typing import Any

from app.errors import RecordingFormatError
from app.readers.unpacked import check_mat
from estimators.sentences import say


def load_mat(path: Path, names: list[str], *, simplify: bool = False) -> dict[str, Any]:
    """Return the named variables that the file holds.

    Raises
    ------
    RecordingFormatError
        The file cannot be read, or unpacks to too much.
    """
    import scipy

    check_mat(path)
    try:
        content: dict[str, Any] = scipy.io.loadmat(path, variable_names=names, simplify_cells=simplify)
    except NotImplementedError as error:
        raise RecordingFormatError(say("mat.version")) from error
    except MemoryError:
        raise
    except Exception as error:
        # The reader follows whatever the bytes say and fails with whatever error that leads to.
        raise RecordingFormatError(say("mat.unreadable")) from error
    return content


def variables_of(path: Path) -> frozenset[str]:
    """Return the names in a file.

    Raises
    ------
    RecordingFormatError
        It cannot be read, or unpacks to too much: a name can be as long as a variable.
    """
    import scipy

    check_mat(path)
    try:
        return frozenset(name for name, _, _ in scipy.io.whosmat(path))
    except Exception as error:
        raise RecordingFormatError(say("mat.unreadable")) from error
