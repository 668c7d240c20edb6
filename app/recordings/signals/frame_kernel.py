"""Tables of measured numbers as bits: each column in steps of its own, so fine that nothing of worth is lost.

Column::

    form      2 bits   0 in the steps of the column before (of the first: 2^-15), 1 in steps of its own,
                       2 words of 64 bits as they are, 3 nothing known (all NaN)
    step      8 bits   (form 1) the power of two, plus 128
    gaps      1 bit    (forms 0 and 1) 1: a bit a row follows, 1 where nothing is known
    numbers            (forms 0 and 1) multiples of the step, as in `signals.bit_columns`; in a gap the last one known

Steps are powers of two: products with them are exact.
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.recordings.signals.bit_columns import (
    Words,
    finish,
    get,
    get_word,
    is_read,
    put,
    put_word,
    read_column,
    write_column,
)
from estimators._kernels import kernel, step

COMPONENT: Final = 0
METRE: Final = 1
RADIAN: Final = 2
SIGMA_RADIAN: Final = 3
SIGMA_METRE: Final = 4
OTHER: Final = 5
"""What a column holds; see `app.recordings.signals.frame_codec.Columns`."""
_SAME, _OWN, _WORDS, _UNKNOWN = 0, 1, 2, 3
_FIRST_STEP: Final = -15
_COMPONENT_STEP: Final = -15
_PLAIN_STEP: Final = -14
_SIGMA_BITS: Final = 9
_OTHER_BITS: Final = 22
_LOWEST_STEP, _HIGHEST_STEP = -127, 127
_LARGEST: Final = 2.0**52
"""Multiples of the step beyond it would not be whole numbers any more."""

Table = NDArray[np.float64]
Flags = NDArray[np.uint8]


@step("int64(float64)")
def _power(value: float) -> int:
    """Return the largest n with 2^n <= value, of a positive finite value."""
    return math.frexp(value)[1] - 1


@step("float64(float64[:, ::1], uint8[::1], int64)")
def _least(table: Table, kinds: Flags, kind: int) -> float:
    """Return the least positive number in the columns of a kind; infinite if there is none."""
    least = np.inf
    for c in range(table.shape[1]):
        if kinds[c] == kind:
            for i in range(table.shape[0]):
                if 0.0 < table[i, c] < least:
                    least = table[i, c]
    return least


@step("float64(float64[::1])")
def _hold(column: Table) -> float:
    """Replace NaN by the number before, at the start by the first there is; return the largest magnitude."""
    last, largest = np.nan, 0.0
    for value in column[::-1]:
        if value == value:
            last, largest = value, max(largest, abs(value))
    for i in range(len(column)):
        if column[i] == column[i]:
            last = column[i]
        column[i] = last
    return largest


@step("int64(float64[:, ::1], int64, int64, int64, float64, float64, float64)")
def _step(
    table: Table, c: int, kind: int, pair: int, least_rad: float, least_m: float, largest: float
) -> int:
    """Return the power of two of a column's step: half a step must not matter.

    Half a step is at most a sixteenth of the least sigma, where a tenth is allowed. A turn is wrong by at most
    twice the error of its quaternion, that by at most one step (four components of half a step): of the least
    sigma a 32th part.
    """
    if kind == COMPONENT:
        return _COMPONENT_STEP if least_rad == np.inf else min(_COMPONENT_STEP, _power(least_rad) - 6)
    if kind == METRE:
        return _PLAIN_STEP if least_m == np.inf else min(_PLAIN_STEP, _power(least_m) - 3)
    if kind == OTHER:
        return _FIRST_STEP if not 0.0 < largest < np.inf else _power(largest) - _OTHER_BITS
    least = np.inf
    if kind == RADIAN:
        if pair < 0:
            return _PLAIN_STEP
        for i in range(table.shape[0]):
            if table[i, pair] < least:
                least = table[i, pair]
        if least <= 0.0:
            # Its sigma says that it is exact.
            return _LOWEST_STEP - 1
        return _PLAIN_STEP if least == np.inf else min(_PLAIN_STEP, _power(least) - 3)
    for i in range(table.shape[0]):
        if 0.0 < table[i, c] < least:
            least = table[i, c]
    return _PLAIN_STEP if least == np.inf else _power(least) - _SIGMA_BITS


@kernel(
    "int64(uint32[::1], float64[:, ::1], uint64[:, ::1], uint8[::1], int64[::1], uint8[:, ::1])",
)
def pack_frames(
    words: Words,
    table: Table,
    table_bits: NDArray[np.uint64],
    kinds: Flags,
    pairs: NDArray[np.int64],
    flags: Flags,
) -> Any:
    """Write a table of numbers and a table of flags; return how many words were written.

    Parameters
    ----------
    words : ndarray of uint32
        Room for `_bit_columns.room_words` of both tables.
    table : ndarray, shape (N, C)
    table_bits : ndarray of uint64, shape (N, C)
        The same memory.
    kinds : ndarray of uint8, shape (C,)
    pairs : ndarray of int64, shape (C,)
        Column of the sigma of a column; -1 without.
    flags : ndarray of uint8, shape (N, F)
    """
    state = np.zeros(3, np.uint64)
    rows = table.shape[0]
    numbers = np.empty((3, rows), np.int64)
    before = _FIRST_STEP
    least_rad, least_m = _least(table, kinds, SIGMA_RADIAN), _least(table, kinds, SIGMA_METRE)
    column = np.empty(rows)
    for c in range(table.shape[1]):
        known, largest = 0, 0.0
        for i in range(rows):
            value = table[i, c]
            column[i] = value
            known += value == value
            largest = max(largest, abs(value))
        if known == 0:
            put(words, state, np.uint64(_UNKNOWN), 2)
            continue
        if known < rows:
            largest = _hold(column)
        step = _step(table, c, kinds[c], pairs[c], least_rad, least_m, largest)
        if step < _LOWEST_STEP or step > _HIGHEST_STEP or not largest * 2.0**-step < _LARGEST:
            put(words, state, np.uint64(_WORDS), 2)
            for i in range(rows):
                put_word(words, state, table_bits[i, c])
            continue
        if step == before:
            put(words, state, np.uint64(_SAME), 2)
        else:
            put(words, state, np.uint64(_OWN), 2)
            put(words, state, np.uint64(step + 128), 8)
            before = step
        put(words, state, np.uint64(known < rows), 1)
        if known < rows:
            for i in range(rows):
                put(words, state, np.uint64(table[i, c] != table[i, c]), 1)
        scale = 2.0**-step
        for i in range(rows):
            numbers[0, i] = np.int64(np.rint(column[i] * scale))
        write_column(words, state, numbers)
    for c in range(flags.shape[1]):
        for i in range(rows):
            numbers[0, i] = flags[i, c]
        write_column(words, state, numbers)
    return finish(words, state)


@kernel("boolean(uint32[::1], float64[:, ::1], uint64[:, ::1], uint8[:, ::1])")
def unpack_frames(words: Words, table: Table, table_bits: NDArray[np.uint64], flags: Flags) -> Any:
    """Read what `pack_frames` wrote into tables of the same shapes; False when the words do not fit them."""
    state = np.zeros(3, np.uint64)
    rows = table.shape[0]
    numbers = np.empty(rows, np.int64)
    gaps = np.zeros(rows, np.bool_)
    step: Any = _FIRST_STEP
    for c in range(table.shape[1]):
        form = np.int64(get(words, state, 2))
        if form == _UNKNOWN:
            table[:, c] = np.nan
            continue
        if form == _WORDS:
            for i in range(rows):
                table_bits[i, c] = get_word(words, state)
            continue
        if form == _OWN:
            step = np.int64(get(words, state, 8)) - 128
        has_gaps = get(words, state, 1) != np.uint64(0)
        if has_gaps:
            for i in range(rows):
                gaps[i] = get(words, state, 1) != np.uint64(0)
        read_column(words, state, numbers)
        scale = 2.0**step
        for i in range(rows):
            table[i, c] = np.nan if has_gaps and gaps[i] else float(numbers[i]) * scale
    for c in range(flags.shape[1]):
        read_column(words, state, numbers)
        for i in range(rows):
            flags[i, c] = np.uint8(numbers[i])
    return is_read(words, state)
