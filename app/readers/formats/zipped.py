"""One recording in several tables of one clock, as a zip: phones, and makers who write a file a sensor."""

from typing import TYPE_CHECKING

from app.errors import RecordingFormatError
from app.readers.contract import Reader, Source
from app.readers.members import ZIP_MARK
from app.readers.tables.guess import SINGLE
from estimators.sentences import CATALOGUE

if TYPE_CHECKING:
    from estimators.recording import Recording


class ZippedReader(Reader):
    """Several tables in a zip: read by a mapping, or as names and numbers say it."""

    title = "Several tables of one recording (zip)"
    description = "Tables of a phone, or one for each sensor, that share a clock"
    endings = frozenset({".zip"})
    asks_pipeline = True

    def recognises(self, source: Source) -> bool:
        """By its first bytes; what is a zip and called otherwise was recognised before."""
        return source.start.startswith(ZIP_MARK)

    def read(self, source: Source) -> "Recording":
        """Read it by its mapping, or by the guessed one; then what was assumed is in its notes."""
        from dataclasses import replace

        from app.readers.tables.columns import read_csv
        from app.readers.tables.look.assumptions import assumed
        from app.readers.tables.schemas import CsvMapping, GuessedMapping
        from app.readers.tables.several import Tables

        tables = Tables(source.path)
        if source.mapping is not None:
            return read_csv(source.path, source.mapping, tables)
        guess = tables.guess(source.stem)
        if guess.missing:
            raise RecordingFormatError(CATALOGUE.together(guess.missing))
        found = read_csv(source.path, CsvMapping.model_validate(guess.mapping), tables)
        # Nobody may have looked at the guess: what a look at it assumes is said with the recording.
        looked = assumed(tables.head, guess, GuessedMapping.model_validate(guess.mapping), None)
        return replace(found, notes=tuple(dict.fromkeys((*looked, *found.notes))))

    def announces(self, source: Source) -> tuple[tuple[str, ...], float]:
        """Return what a mapping names; without one a single sensor, until it is read."""
        signals = [] if source.mapping is None else source.mapping.signals
        names = [one.placement or one.sensor or SINGLE for one in signals]
        return tuple(dict.fromkeys(names or [SINGLE])), 100.0
