"""CRC-32 of a packet in compiled code, eight bytes at a time."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.kernels import borrowing

_POLYNOMIAL: Final = 0xEDB88320


def _tables() -> NDArray[np.uint32]:
    found = np.zeros((8, 256), dtype=np.uint32)
    for byte in range(256):
        value = byte
        for _ in range(8):
            value = (value >> 1) ^ (_POLYNOMIAL if value & 1 else 0)
        found[0, byte] = value
    for table in range(1, 8):
        before = found[table - 1]
        found[table] = (before >> 8) ^ found[0, before & 0xFF]
    return found


TABLES: Final = _tables()
"""The CRC of each byte with 0 to 7 bytes of zero behind it."""


@borrowing("u4(u1[::1], i8, i8, u4, u4[:, ::1])")
def crc32(
    data: NDArray[np.uint8], start: int, stop: int, before: np.uint32, tables: NDArray[np.uint32]
) -> np.uint32:
    """Return the CRC-32 of `data[start:stop]` behind bytes whose CRC is `before`, as `zlib.crc32`.

    Parameters
    ----------
    before : uint32
        Zero for the first bytes.
    tables : ndarray of uint32, shape (8, 256)
        `TABLES`.
    """
    one = np.uint32(0xFF)
    value = np.uint32(before) ^ np.uint32(0xFFFFFFFF)
    at = start
    while at + 8 <= stop:
        low = value ^ (
            np.uint32(data[at])
            | (np.uint32(data[at + 1]) << np.uint32(8))
            | (np.uint32(data[at + 2]) << np.uint32(16))
            | (np.uint32(data[at + 3]) << np.uint32(24))
        )
        value = (
            tables[7, low & one]
            ^ tables[6, (low >> np.uint32(8)) & one]
            ^ tables[5, (low >> np.uint32(16)) & one]
            ^ tables[4, low >> np.uint32(24)]
            ^ tables[3, data[at + 4]]
            ^ tables[2, data[at + 5]]
            ^ tables[1, data[at + 6]]
            ^ tables[0, data[at + 7]]
        )
        at += 8
    while at < stop:
        value = (value >> np.uint32(8)) ^ tables[0, (value ^ np.uint32(data[at])) & one]
        at += 1
    return np.uint32(value ^ np.uint32(0xFFFFFFFF))
