"""The contract of a reader: a class in a module of `app.readers.formats`, named as the format."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, ClassVar, Final

from app.errors import RecordingFormatError
from app.readers.tables.text import encoding_of, start_of

if TYPE_CHECKING:
    from app.readers.tables.schemas import CsvMapping
    from estimators.recording import Recording
    from estimators.sentences import Sentence

TEXT: Final = frozenset({".csv", ".txt", ".tsv", ".dat", ".asc"})
"""Endings of tables."""


@dataclass(frozen=True)
class Source:
    """A file to be recognised or read.

    Attributes
    ----------
    path : Path
        Where it is; of a preview, of which only the beginning came, only its name counts.
    called : str
        What it was called before it was uploaded: says the side of a foot. Empty: the path's name.
    mapping : CsvMapping, optional
        Which column of a table is what, in which unit.
    """

    path: Path
    called: str = ""
    mapping: "CsvMapping | None" = None

    @property
    def name(self) -> str:
        """Its name with the ending."""
        return self.called or self.path.name

    @property
    def stem(self) -> str:
        """Its name without the ending."""
        return PurePath(self.name).stem

    @property
    def ending(self) -> str:
        """In small letters, with the point."""
        return PurePath(self.name).suffix.lower()

    @cached_property
    def start(self) -> bytes:
        """The first `HEAD_BYTES`."""
        return start_of(self.path)

    @cached_property
    def is_text(self) -> bool:
        """Whether it can be read as text."""
        try:
            encoding_of(self.start)
        except RecordingFormatError:
            return False
        return True

    @cached_property
    def variables(self) -> frozenset[str]:
        """Names in a MATLAB file; empty for another ending.

        Raises
        ------
        RecordingFormatError
            It cannot be read.
        """
        from app.readers.mat import variables_of

        return variables_of(self.path) if self.ending == ".mat" else frozenset()

    @cached_property
    def first_lines(self) -> tuple[str, str]:
        """The first two lines of a table in UTF-8; empty for anything else."""
        if self.ending not in TEXT or not self.is_text or not encoding_of(self.start).startswith("utf-8"):
            return "", ""
        text = self.start[:8192].decode("utf-8", errors="replace").lstrip("\ufeff")
        first, _, rest = text.partition("\n")
        return first, rest.partition("\n")[0]


class Reader(ABC):
    """Recognises and reads one file format; without state, one instance a process.

    Attributes
    ----------
    title, description : str
        For people who choose: a few words, and a sentence.
    pipeline : str
        The only kind of session that such a file can be; empty where it depends on the file.
    asks_pipeline : bool
        Whether a person says what kind it is.
    needs_mapping : bool
        Whether somebody must say which column is what.
    placements : tuple of str
        What it usually holds, registered until it is read.
    holds_packets : bool
        Packets as a gateway sent them, on the ticks of their session: stored as they are.
    is_last : bool
        Asked after the others: it takes what nobody else knows.
    """

    title: ClassVar[str]
    description: ClassVar[str]
    endings: ClassVar[frozenset[str]]
    pipeline: ClassVar[str] = ""
    asks_pipeline: ClassVar[bool] = False
    needs_mapping: ClassVar[bool] = False
    placements: ClassVar[tuple[str, ...]] = ()
    holds_packets: ClassVar[bool] = False
    is_last: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """The format's name: that of its module."""
        return type(self).__module__.rpartition(".")[2]

    @abstractmethod
    def recognises(self, source: Source) -> bool:
        """Return whether a file seems to be of this format, by its name and beginning."""

    def against(self, source: Source) -> "Sentence | None":
        """Return what a file that it recognised is instead, as far as its beginning shows it."""
        return None

    @abstractmethod
    def read(self, source: Source) -> "Recording":
        """Read a file in SI units, on its own stamps; what was assumed or left out stands in its notes.

        Raises
        ------
        RecordingFormatError
            It is not of this format; the message says what is wrong and what to do.
        """

    def announces(self, source: Source) -> tuple[tuple[str, ...], float]:
        """Return sensors and rate in Hz as far as they are known without reading the whole file."""
        return self.placements, 100.0
