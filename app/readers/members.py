"""The files in a zip from strangers, within bounds: read where they lie, nothing is unpacked to a disk."""

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO, Final
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile

from app.errors import RecordingFormatError
from app.readers.unpacked import MOST_BYTES
from estimators.sentences import say

ZIP_MARK: Final = b"PK\x03\x04"
MOST_MEMBERS: Final = 200
_MOST_RATIO: Final = 200
_SMALL_BYTES: Final = 1 << 20
"""Below this nothing is too much, however well it packs."""
_MOST_DIRECTORY_BYTES: Final = 1 << 20
_DEEPEST: Final = 3
"""Of a name's parts: the folder that was packed, and one level in it."""
_END: Final = struct.Struct("<4s4H2LH")
_END_MARK, _END_MARK_64 = b"PK\x05\x06", b"PK\x06\x07"
_LONGEST_COMMENT: Final = 1 << 16
_ENCRYPTED: Final = 0x1


@dataclass(frozen=True)
class Member:
    """A file in a zip, opened as a path is; its name is never a path on this machine."""

    archive: Path
    name: str

    @property
    def stem(self) -> str:
        """Folder and name without the ending."""
        return str(PurePosixPath(self.name).with_suffix(""))

    @property
    def ending(self) -> str:
        """In small letters, with the point."""
        return PurePosixPath(self.name).suffix.lower()

    def open(self, mode: str = "rb") -> IO[bytes]:
        """Open it for reading; no more comes out than was checked."""
        return ZipFile(self.archive).open(self.name)


def members_of(archive: Path, most_bytes: int = MOST_BYTES) -> list[Member]:
    """Return the files in a zip, without those that computers add to it.

    Parameters
    ----------
    most_bytes : int
        Of all of them unpacked.

    Raises
    ------
    RecordingFormatError
        It is damaged, locked, too deep, holds another zip, or unpacks to too much.
    """
    _check_directory(archive)
    with reading(), ZipFile(archive) as file:
        listed = [one for one in file.infolist() if not (one.is_dir() or _is_of_computers(one.filename))]
    if len(listed) > MOST_MEMBERS:
        raise RecordingFormatError(say("zip.many", count=len(listed), most=MOST_MEMBERS))
    if any(one.flag_bits & _ENCRYPTED for one in listed):
        raise RecordingFormatError(say("zip.locked"))
    if any(one.compress_type not in (ZIP_STORED, ZIP_DEFLATED) for one in listed):
        raise RecordingFormatError(say("zip.damaged"))
    paths = [PurePosixPath(one.filename) for one in listed]
    if any(len(path.parts) > _DEEPEST or path.suffix.lower() == ".zip" for path in paths):
        raise RecordingFormatError(say("zip.nested"))
    unpacked = sum(one.file_size for one in listed)
    packed = archive.stat().st_size
    if unpacked > most_bytes or unpacked > max(_SMALL_BYTES, _MOST_RATIO * packed):
        raise RecordingFormatError(
            say("file.unpacks_to_too_much", packed_bytes=packed, limit_bytes=most_bytes),
            packed_bytes=packed,
            unpacked_bytes=unpacked,
            limit_bytes=most_bytes,
        )
    return [Member(archive, one.filename) for one in sorted(listed, key=lambda one: one.filename)]


@contextmanager
def reading() -> Iterator[None]:
    """Say in words that a zip is damaged.

    Raises
    ------
    RecordingFormatError
        It is.
    """
    try:
        yield
    except (BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise RecordingFormatError(say("zip.damaged")) from error


def _is_of_computers(name: str) -> bool:
    return any(part.startswith((".", "__MACOSX")) for part in PurePosixPath(name).parts)


def _check_directory(archive: Path) -> None:
    """Refuse a list of members that is too long to be read at all; a zip of over 4 GB is none of ours."""
    size = archive.stat().st_size
    with archive.open("rb") as file:
        file.seek(max(0, size - _END.size - _LONGEST_COMMENT - 20))
        tail = file.read()
    at = tail.rfind(_END_MARK)
    if at < 0 or len(tail) - at < _END.size:
        raise RecordingFormatError(say("zip.damaged"))
    *_, count, length, _, comment = _END.unpack_from(tail, at)
    if at + _END.size + comment != len(tail) or tail[max(0, at - 20) : at].startswith(_END_MARK_64):
        raise RecordingFormatError(say("zip.damaged"))
    if length > _MOST_DIRECTORY_BYTES:
        raise RecordingFormatError(say("zip.many", count=count, most=MOST_MEMBERS))
