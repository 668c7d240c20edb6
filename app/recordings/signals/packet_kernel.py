"""Packets as bits: the columns of their heads, then those of their counts, each as in `signals.bit_columns`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.recordings.signals.bit_columns import Numbers, Words, finish, is_read, read_column, write_column
from estimators._kernels import kernel

Counts = NDArray[np.int16]


@kernel("int64(uint32[::1], int64[:, ::1], int16[:, ::1])")
def pack_packets(words: Words, heads: Numbers, counts: Counts) -> Any:
    """Write heads, shape (P, H), and counts, shape (N, C); return how many words were written."""
    state = np.zeros(3, np.uint64)
    numbers = np.empty((3, heads.shape[0]), np.int64)
    for c in range(heads.shape[1]):
        for i in range(heads.shape[0]):
            numbers[0, i] = heads[i, c]
        write_column(words, state, numbers)
    numbers = np.empty((3, counts.shape[0]), np.int64)
    for c in range(counts.shape[1]):
        for i in range(counts.shape[0]):
            numbers[0, i] = counts[i, c]
        write_column(words, state, numbers)
    return finish(words, state)


@kernel("boolean(uint32[::1], int64[:, ::1], int16[:, ::1])")
def unpack_packets(words: Words, heads: Numbers, counts: Counts) -> Any:
    """Read what `pack_packets` wrote into tables of the same shapes; False when the words do not fit them."""
    state = np.zeros(3, np.uint64)
    numbers = np.empty(heads.shape[0], np.int64)
    for c in range(heads.shape[1]):
        read_column(words, state, numbers)
        for i in range(heads.shape[0]):
            heads[i, c] = numbers[i]
    numbers = np.empty(counts.shape[0], np.int64)
    for c in range(counts.shape[1]):
        read_column(words, state, numbers)
        for i in range(counts.shape[0]):
            counts[i, c] = np.int16(numbers[i])
    return is_read(words, state)
