"""Reading of a file that holds a whole recording."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from pydantic import ValidationError

from app import readers
from app.errors import InvalidInput
from app.readers.tables.schemas import CsvMapping
from estimators.recording import Recording

Hemisphere = Literal["north", "south", "unknown"]


@dataclass(frozen=True)
class Read:
    """A recording as it was read.

    Attributes
    ----------
    recording : Recording
        Signals in SI units, sensor axes, each sensor on its own times.
    format : str
        Of the file, a key of `app.readers.readers()`.
    kind : str
        Of session that its sensors are worn for: `arm`, `gait`, `orientation`.
    hemisphere : {"north", "south", "unknown"}
        Where it was taken to be recorded; decides the sign of the field.
    notes : tuple of str
        What was assumed, and what the file says against it.
    """

    recording: Recording
    format: str
    kind: str
    hemisphere: Hemisphere
    notes: tuple[str, ...]


def read(
    file: str | Path,
    *,
    mapping: Mapping[str, Any] | None = None,
    rate_hz: float | None = None,
    hemisphere: Hemisphere = "north",
    force: bool = False,
) -> Read:
    """Read a recording: a table, or a file of one of the known formats.

    Parameters
    ----------
    file : path
        Endings and content say of which format it is.
    mapping : mapping, optional
        Which columns of a table hold what, with the fields of docs/mapping.md; guessed from their names without.
    rate_hz : float, optional
        Of the samples, Hz, where no column of a table holds the time.
    hemisphere : {"north", "south", "unknown"}
        Where it was recorded.
    force : bool
        Read values that cannot be right as they are; `notes` then says which.

    Raises
    ------
    app.errors.InvalidInput
        A table does not say everything; the message names what is missing.
    app.errors.RecordingFormatError
        The file is no recording, or its values cannot be right.
    """
    path = Path(file)
    if not path.is_file():
        raise InvalidInput(f"there is no file {path}")
    notes: list[str] = []
    if hemisphere not in get_args(Hemisphere):
        raise InvalidInput(f"no hemisphere {hemisphere!r}; choose one of {', '.join(get_args(Hemisphere))}")
    try:
        columns = CsvMapping.model_validate(dict(mapping)) if mapping is not None else None
    except ValidationError as error:
        raise InvalidInput(f"this is no mapping: {error}") from None
    format = readers.guess(path) if columns is None else readers.format_of(path, columns)
    if columns is None and readers.TEXT & readers.reader_of(format).endings:
        found = readers.preview_text(path.name, readers.start_of(path), None, rate_hz, readers.later_of(path))
        format = found.format
        if found.guess is not None:
            columns = _guessed(found, hemisphere, notes)
    with readers.accepting(force) as doubts:
        recording = readers.read(path, format, columns)
    notes += [str(one) for one in (*doubts, *recording.notes)]
    kind = readers.pipeline_for(list(recording.placements))
    return Read(recording, format, kind, hemisphere, tuple(notes))


def _guessed(found: readers.Preview, hemisphere: Hemisphere, notes: list[str]) -> CsvMapping:
    """Return the guessed mapping; adds to `notes` what each sensor is taken for and what that assumes."""
    from app.readers.tables.look import look_at

    assert found.head is not None
    assert found.guess is not None
    if found.guess.missing:
        raise InvalidInput(
            f"{' '.join(found.guess.missing)} Give rate_hz where the time is missing, otherwise mapping; "
            "`telemotion mapping FILE` writes one to complete.",
            missing=[one.code for one in found.guess.missing],
        )
    look = look_at(found.head, found.guess, hemisphere=hemisphere)
    notes += [str(one.sentence) for one in look.sensors]
    notes += [str(line) for line in look.assumed]
    return CsvMapping.model_validate(found.guess.mapping)
