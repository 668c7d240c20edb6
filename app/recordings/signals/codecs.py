"""Lossless codecs of signal chunks: shuffle the bytes by channel, compress with Zstandard, check with CRC-32.

A chunk is a table of N ticks by C channels. Neighbouring ticks of one channel are alike, so the table is
stored channel by channel with the low bytes of a channel apart from its high bytes; counts are stored as
differences first, folded so that small negative and small positive differences both have an empty high
byte (`zigzag`). Every function here restores its input bit for bit, NaN payloads included.

What live sessions write goes through compiled code instead: `chunks.COUNTS_CODEC` and `signals.frame_codec`.
"""

import zlib
from typing import Any, Final

import numpy as np
import zstandard
from numpy.typing import NDArray

from app.errors import TelemotionError
from estimators.sentences import say

SHUFFLED_COUNTS_CODEC: Final = "int16-delta-shuffle-zstd/1"
FLOATS_CODEC: Final = "float32-shuffle-zstd/1"

_LEVEL: Final = 3
_MAX_DECODED_BYTES: Final = 256 * 1024 * 1024


class DamagedChunkError(TelemotionError):
    """A stored chunk whose checksum or content does not match what was written."""

    code = "chunk_damaged"


def checksum(data: bytes) -> int:
    """Return the CRC-32 of `data` as stored in `signal_chunk.crc`."""
    return zlib.crc32(data)


def _compress(data: bytes) -> bytes:
    return zstandard.ZstdCompressor(level=_LEVEL, write_content_size=True).compress(data)


def _decompress(data: bytes, expected_bytes: int) -> bytes:
    try:
        plain = zstandard.ZstdDecompressor().decompress(data, max_output_size=_MAX_DECODED_BYTES)
    except zstandard.ZstdError as error:
        raise DamagedChunkError(say("stored.undecodable")) from error
    if len(plain) != expected_bytes:
        raise DamagedChunkError(say("stored.length", found=len(plain), expected=expected_bytes))
    return plain


def _shuffle(values: NDArray[Any]) -> bytes:
    """Order the bytes of an (N, C) table as (byte of the word, channel, tick)."""
    rows, columns = values.shape
    width = values.dtype.itemsize
    as_bytes = np.ascontiguousarray(values).view(np.uint8).reshape(rows, columns, width)
    return np.ascontiguousarray(as_bytes.transpose(2, 1, 0)).tobytes()


def _unshuffle(data: bytes, rows: int, columns: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    as_bytes = np.frombuffer(data, dtype=np.uint8).reshape(dtype.itemsize, columns, rows)
    return np.ascontiguousarray(as_bytes.transpose(2, 1, 0)).view(dtype).reshape(rows, columns)


def _zigzag_differences(values: NDArray[Any]) -> NDArray[Any]:
    """Difference along the ticks modulo the word, then fold the sign into bit 0."""
    differences = values.copy()
    differences[1:] -= values[:-1]
    folded: NDArray[Any] = (differences << 1) ^ (differences >> (values.dtype.itemsize * 8 - 1))
    return folded


def _undo_zigzag_differences(folded: NDArray[Any]) -> NDArray[Any]:
    unsigned = folded.view(folded.dtype.str.replace("i", "u"))
    differences = (unsigned >> 1).view(folded.dtype) ^ -(folded & 1)
    restored: NDArray[Any] = np.cumsum(differences, axis=0, dtype=folded.dtype)
    return restored


def decode_counts(data: bytes, rows: int, columns: int) -> NDArray[np.int16]:
    """Restore device counts, shape (rows, columns); they were written so before `int16-rice/1`."""
    dtype = np.dtype("<i2")
    folded = _unshuffle(_decompress(data, rows * columns * 2), rows, columns, dtype)
    return _undo_zigzag_differences(folded)


def encode_integers(values: NDArray[np.int64]) -> bytes:
    """Encode a table of whole numbers (sequences, times), shape (N, C)."""
    return _compress(_shuffle(_zigzag_differences(np.asarray(values, dtype="<i8"))))


def decode_integers(data: bytes, rows: int, columns: int) -> NDArray[np.int64]:
    """Restore `encode_integers`, shape (rows, columns)."""
    dtype = np.dtype("<i8")
    folded = _unshuffle(_decompress(data, rows * columns * 8), rows, columns, dtype)
    return _undo_zigzag_differences(folded)


def encode_floats(values: NDArray[np.float32]) -> bytes:
    """Encode 32-bit floats, shape (N, C); bit patterns of NaN are preserved."""
    return _compress(_shuffle(np.asarray(values, dtype="<f4")))


def decode_floats(data: bytes, rows: int, columns: int) -> NDArray[np.float32]:
    """Restore `encode_floats`, shape (rows, columns)."""
    return _unshuffle(_decompress(data, rows * columns * 4), rows, columns, np.dtype("<f4"))


def encode_flags(values: NDArray[np.uint8]) -> bytes:
    """Encode small whole numbers, shape (N, C)."""
    return _compress(_shuffle(np.asarray(values, dtype=np.uint8)))


def decode_flags(data: bytes, rows: int, columns: int) -> NDArray[np.uint8]:
    """Restore `encode_flags`, shape (rows, columns)."""
    return _unshuffle(_decompress(data, rows * columns), rows, columns, np.dtype(np.uint8))
