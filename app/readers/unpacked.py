"""Limits on what compressed files unpack to, before any of it is stored: a few kilobytes can hold gigabytes."""

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final

from app.errors import RecordingFormatError
from estimators.sentences import say

if TYPE_CHECKING:
    import h5py

MOST_BYTES: Final = 1 << 30
"""Of one file unpacked: four hours of 17 nine-axis sensors at 100 Hz are 1.0 GiB of float32."""
_PIECE_BYTES: Final = 1 << 18
_MAT_HEADER_BYTES: Final = 128
_MI_COMPRESSED: Final = 15
_BYTE_ORDERS: Final = {b"IM": "<", b"MI": ">"}


def check_mat(path: Path, most_bytes: int = MOST_BYTES) -> None:
    """Refuse a `.mat` file of version 5 or 7 whose variables unpack to too much.

    Sizes that the file states are not believed: each variable is unpacked piece by piece, and nothing is held.

    Parameters
    ----------
    path : Path
        A file of version 4 passes: it has nothing compressed.

    Raises
    ------
    RecordingFormatError
        With both sizes; or for a mark of the byte order that the format does not know: others read such a file all
        the same, and what cannot be measured is not read.
    """
    total = 0
    with path.open("rb") as file:
        header = file.read(_MAT_HEADER_BYTES)
        if 0 in header[:4]:
            return
        order = _BYTE_ORDERS.get(header[126:128])
        if order is None:
            raise RecordingFormatError(say("mat.unreadable"))
        for piece in _unpacked(file, order):
            total += piece
            if total > most_bytes:
                raise _too_much(path, total, most_bytes)


def _unpacked(file: BinaryIO, order: str) -> Iterator[int]:
    """Yield how many bytes the compressed variables behind the header give, piece by piece."""
    tag = struct.Struct(f"{order}II")
    while len(head := file.read(tag.size)) == tag.size:
        kind, length = tag.unpack(head)
        if kind != _MI_COMPRESSED:
            file.seek(length, 1)
            continue
        unpacker = zlib.decompressobj()
        while length > 0 and not unpacker.eof:
            packed = file.read(min(length, _PIECE_BYTES))
            if not packed:
                return
            length -= len(packed)
            try:
                while packed and not unpacker.eof:
                    yield len(unpacker.decompress(packed, _PIECE_BYTES))
                    packed = unpacker.unconsumed_tail
            except zlib.error:
                # The reader says what is wrong with it.
                return
        file.seek(max(length, 0), 1)


def check_hdf5(file: "h5py.File", names: list[str], most_bytes: int = MOST_BYTES) -> None:
    """Refuse an HDF5 file whose data sets are too large to unpack, or are not in the file at all.

    Parameters
    ----------
    names : list of str
        Data sets that will be read.

    Raises
    ------
    RecordingFormatError
        With both sizes; or for a link to another file: an upload must not read what else lies on this machine.
    """
    import h5py

    total = 0
    for name in names:
        if name not in file:
            continue
        found = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
        if not isinstance(found, h5py.Dataset) or found.external or found.is_virtual:
            raise RecordingFormatError(say("file.linked_data", name=name))
        # A chunk is unpacked as a whole even when the data set needs a part of it.
        chunk = found.dtype.itemsize
        for length in found.chunks or ():
            chunk *= length
        total += max(found.nbytes, chunk)
    if total > most_bytes:
        raise _too_much(Path(file.filename), total, most_bytes)


def _too_much(path: Path, unpacked_bytes: int, most_bytes: int) -> RecordingFormatError:
    packed = path.stat().st_size
    return RecordingFormatError(
        say("file.unpacks_to_too_much", packed_bytes=packed, limit_bytes=most_bytes),
        packed_bytes=packed,
        unpacked_bytes=unpacked_bytes,
        limit_bytes=most_bytes,
    )
