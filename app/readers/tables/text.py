"""Text files from anywhere as UTF-8: byte order marks, UTF-16, Latin-1, and lines that end as they like."""

import codecs
import io
from pathlib import Path
from typing import Any, BinaryIO, Final

from app.errors import RecordingFormatError
from app.readers.foreign import what_it_is
from estimators.sentences import say

HEAD_BYTES: Final = 256 * 1024
"""How much of a file is looked at to find out what it is."""
LATER_BYTES: Final = 32 * 1024
MOST_LATER: Final = 12
"""Pieces spread over the rest of a file, the last one its end: what begins later, as a second device, is in them."""
_PIECE_BYTES: Final = 1 << 18
_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_CONTROLS: Final = bytes(set(range(32)) - {9, 10, 11, 12, 13, 26})
"""No text holds them; a table that ends with Ctrl-Z does."""


def start_of(path: Path) -> bytes:
    """Return the first `HEAD_BYTES` of a file."""
    with path.open("rb") as file:
        return file.read(HEAD_BYTES)


def later_of(path: Path) -> tuple[bytes, ...]:
    """Return pieces of `LATER_BYTES` spread over a file behind its first `HEAD_BYTES`; none if it ends there."""
    size = path.stat().st_size
    count = min(MOST_LATER, -(-(size - HEAD_BYTES) // LATER_BYTES))
    if count <= 0:
        return ()
    last = max(HEAD_BYTES, size - LATER_BYTES)
    places = [HEAD_BYTES + (last - HEAD_BYTES) * (k + 1) // count for k in range(count)]
    with path.open("rb") as file:
        # A character of UTF-16 begins at an even place.
        return tuple(file.read(LATER_BYTES) for place in places if file.seek(place // 2 * 2) >= 0)


def encoding_of(start: bytes) -> str:
    """Return how the beginning of a file is encoded.

    Returns
    -------
    str
        A codec's name. Bytes that are no UTF-8 are taken for Latin-1, in which degree signs and micro of older programs
        are written.

    Raises
    ------
    RecordingFormatError
        It is no text.
    """
    for mark, name in _MARKS:
        if start.startswith(mark):
            return name
    # Without a mark: of Latin letters and digits in UTF-16 every other byte is zero.
    even, odd = start[:4000:2].count(0), start[1:4000:2].count(0)
    least = 0.4 * min(len(start), 4000) / 2
    if max(even, odd) > least and min(even, odd) == 0:
        return "utf-16-le" if odd else "utf-16-be"
    if len(start.translate(None, _CONTROLS)) < len(start):
        raise RecordingFormatError(what_it_is(start) or say("table.not_text"))
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        # The last character may be cut.
        decoder.decode(start)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def text_of(start: bytes) -> str:
    """Return the beginning of a file as text whose lines end with a line feed; see `encoding_of`."""
    decoder = codecs.getincrementaldecoder(encoding_of(start))(errors="replace")
    return decoder.decode(start).replace("\r\n", "\n").replace("\r", "\n").replace("\x1a", "")


def lines_of(later: bytes, start: bytes) -> tuple[str, ...]:
    """Return the whole lines of a piece of a file that begins with `start`; see `later_of`."""
    encoding = encoding_of(start)
    mark = start[:2] if encoding == "utf-16" else b""
    text = (mark + later).decode(encoding, errors="replace")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").replace("\x1a", "").split("\n")
    return tuple(line for line in lines[1:-1] if line.strip())


def opened(path: Path, encoding: str) -> BinaryIO:
    """Open a text file as UTF-8 bytes without a mark, lines ending with a line feed.

    Parameters
    ----------
    encoding : str
        See `encoding_of`.
    """
    return io.BufferedReader(_Recoded(path.open("rb"), encoding), _PIECE_BYTES)


class _Recoded(io.RawIOBase):
    """A text file in one spelling, read piece by piece."""

    def __init__(self, file: BinaryIO, encoding: str) -> None:
        self._file, self._left, self._ended = file, b"", False
        self._decoder = io.IncrementalNewlineDecoder(
            codecs.getincrementaldecoder(encoding)(errors="replace"), translate=True
        )
        # Nothing to do for most files: their bytes are not looked at.
        self._is_plain = encoding == "utf-8"

    def readable(self) -> bool:
        """Return that it is."""
        return True

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()

    def readinto(self, target: Any) -> int:
        """Fill the buffer."""
        while not self._left:
            if self._ended:
                return 0
            piece = self._file.read(_PIECE_BYTES)
            self._ended = not piece
            if self._is_plain and b"\r" not in piece and b"\x1a" not in piece:
                self._left = piece
            else:
                self._is_plain = False
                text: str = self._decoder.decode(piece, final=self._ended)
                self._left = text.replace("\x1a", "").encode()
        taken, self._left = self._left[: len(target)], self._left[len(target) :]
        target[: len(taken)] = taken
        return len(taken)
