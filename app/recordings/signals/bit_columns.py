"""Columns of whole numbers as bits: compiled, without the interpreter lock.

A column is written as what its predictor got wrong. The predictor says zero, or continues the last number
or the line through the last two; its errors are folded to be positive (zigzag) and written in Golomb-Rice
code: the part above bit k in unary, the k bits below it as they are. Order and k are chosen for each column and
chunk, so a quiet column takes a bit or two a number whatever stands beside it, and nothing clips: a number too
far from its prediction is written whole. FLAC keeps sound in the same way.

Column::

    order    2 bits   0 to 2 of the predictor, 3 for a constant
    start    for each of the first `order` differences, or for the constant: 7 bits for how many bits the folded
             number has, then these
    k        5 bits   (not of a constant)
    errors   the remaining numbers

Bits fill words of 32 from the lowest. Arithmetic is modulo 2^64: any 64-bit numbers come back exactly.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import step

_CONSTANT: Final = 3
_ORDER_BITS: Final = 2
_K_BITS: Final = 5
_LENGTH_BITS: Final = 7
_LONGEST_UNARY: Final = 24
_VERY_LARGE: Final = 2**40
"""Larger errors count as this where orders are compared, so that sums do not overflow."""
_MOST_BITS_A_NUMBER: Final = _LONGEST_UNARY + 64
_MOST_BITS_A_COLUMN: Final = 256

Word = Any
"""A number of 64 bits without a sign; compiled code does not mix them with others."""
Numbers = NDArray[np.int64]
Words = NDArray[np.uint32]
State = NDArray[np.uint64]
"""Of a writer or reader, three numbers: bits held, how many they are, the next word."""


def room_words(rows: int, columns: int) -> int:
    """Return how many words a table takes at most."""
    return ((_MOST_BITS_A_NUMBER + 1) * rows + _MOST_BITS_A_COLUMN) * columns // 32 + 2


@step("void(uint32[::1], uint64[::1], uint64, int64)")
def put(words: Words, state: State, value: Word, bits: Any) -> None:
    """Write a number of at most 32 bits."""
    held = state[0] | (np.uint64(value) << state[1])
    count = state[1] + np.uint64(bits)
    if count >= np.uint64(32):
        words[state[2]] = np.uint32(held & np.uint64(0xFFFFFFFF))
        state[2] += np.uint64(1)
        held >>= np.uint64(32)
        count -= np.uint64(32)
    state[0] = held
    state[1] = count


@step("uint64(uint32[::1], uint64[::1], int64)")
def get(words: Words, state: State, bits: int) -> Word:
    """Read a number of at most 32 bits; zero beyond the end."""
    wanted = np.uint64(bits)
    if state[1] < wanted:
        if state[2] < np.uint64(len(words)):
            state[0] |= np.uint64(words[state[2]]) << state[1]
        state[2] += np.uint64(1)
        state[1] += np.uint64(32)
    value = state[0] & ((np.uint64(1) << wanted) - np.uint64(1))
    state[0] >>= wanted
    state[1] -= wanted
    return value


@step("void(uint32[::1], uint64[::1], uint64)")
def put_word(words: Words, state: State, value: Word) -> None:
    """Write 64 bits."""
    put(words, state, np.uint64(value) & np.uint64(0xFFFFFFFF), 32)
    put(words, state, np.uint64(value) >> np.uint64(32), 32)


@step("uint64(uint32[::1], uint64[::1])")
def get_word(words: Words, state: State) -> Word:
    """Read 64 bits."""
    low = get(words, state, 32)
    return low | (get(words, state, 32) << np.uint64(32))


@step("uint64(int64)")
def _folded(number: int) -> Word:
    return np.uint64((number << 1) ^ (number >> 63))


@step("int64(uint64)")
def _unfolded(folded: Word) -> Any:
    return np.int64(folded >> np.uint64(1)) ^ -np.int64(folded & np.uint64(1))


@step("void(uint32[::1], uint64[::1], int64)")
def _put_start(words: Words, state: State, number: int) -> None:
    folded = _folded(number)
    length = 0
    while length < 64 and (folded >> np.uint64(length)) != np.uint64(0):
        length += 1
    put(words, state, np.uint64(length), _LENGTH_BITS)
    low = min(length, 32)
    put(words, state, folded & ((np.uint64(1) << np.uint64(low)) - np.uint64(1)), low)
    if length > 32:
        put(words, state, folded >> np.uint64(32), length - 32)


@step("int64(uint32[::1], uint64[::1])")
def _get_start(words: Words, state: State) -> Any:
    length: Any = np.int64(get(words, state, _LENGTH_BITS))
    folded = get(words, state, min(length, 32))
    if length > 32:
        folded |= get(words, state, min(length, 64) - 32) << np.uint64(32)
    return _unfolded(folded)


@step("void(uint32[::1], uint64[::1], uint64, int64)")
def _put_far(words: Words, state: State, folded: Word, k: int) -> None:
    """Write an error whose code does not fit a word."""
    above = folded >> np.uint64(k)
    if above < np.uint64(_LONGEST_UNARY):
        put(words, state, np.uint64(1) << above, np.int64(above) + 1)
        put(words, state, folded & ((np.uint64(1) << np.uint64(k)) - np.uint64(1)), k)
    else:
        put(words, state, np.uint64(0), _LONGEST_UNARY)
        put_word(words, state, folded)


@step("void(uint32[::1], uint64[::1], int64[:, ::1])")
def write_column(words: Words, state: State, numbers: Numbers) -> None:
    """Write the column in the first row of `numbers`, shape (3, N); the other rows are overwritten."""
    count = numbers.shape[1]
    order, least, unequal = 0, 0, 0
    for i in range(count):
        unequal |= numbers[0, i] ^ numbers[0, 0]
        least += min(abs(numbers[0, i]), _VERY_LARGE)
    if unequal == 0:
        put(words, state, np.uint64(_CONSTANT), _ORDER_BITS)
        _put_start(words, state, numbers[0, 0])
        return
    for tried in range(1, min(3, count)):
        total = 0
        for i in range(tried, count):
            error = numbers[tried - 1, i] - numbers[tried - 1, i - 1]
            numbers[tried, i] = error
            total += min(abs(error), _VERY_LARGE)
        if total < least:
            order, least = tried, total
    put(words, state, np.uint64(order), _ORDER_BITS)
    for i in range(order):
        _put_start(words, state, numbers[i, i])
    # Folded errors are twice as large; the best k is near the logarithm of ln 2 times their mean.
    k = 0
    while k < 31 and (count - order) << k < least:
        k += 1
    put(words, state, np.uint64(k), _K_BITS)
    low = (np.uint64(1) << np.uint64(k)) - np.uint64(1)
    held, bits, at = state[0], state[1], state[2]
    for i in range(order, count):
        folded = _folded(numbers[order, i])
        above = folded >> np.uint64(k)
        if above + np.uint64(k) < np.uint64(_LONGEST_UNARY):
            code = ((folded & low) << (above + np.uint64(1))) | (np.uint64(1) << above)
            held |= code << bits
            bits += above + np.uint64(k + 1)
            if bits >= np.uint64(32):
                words[at] = np.uint32(held & np.uint64(0xFFFFFFFF))
                at += np.uint64(1)
                held >>= np.uint64(32)
                bits -= np.uint64(32)
        else:
            state[0], state[1], state[2] = held, bits, at
            _put_far(words, state, folded, k)
            held, bits, at = state[0], state[1], state[2]
    state[0], state[1], state[2] = held, bits, at


@step("void(uint32[::1], uint64[::1], int64[::1])")
def read_column(words: Words, state: State, numbers: Numbers) -> None:
    """Read a column as long as `numbers`."""
    count = len(numbers)
    order: Any = np.int64(get(words, state, _ORDER_BITS))
    if order == _CONSTANT:
        numbers[:] = _get_start(words, state)
        return
    order = min(order, count)
    for i in range(order):
        numbers[i] = _get_start(words, state)
    k = np.uint64(get(words, state, _K_BITS))
    low = (np.uint64(1) << k) - np.uint64(1)
    held, bits, at = state[0], state[1], state[2]
    one, word = np.uint64(1), np.uint64(32)
    end = np.uint64(len(words))
    for i in range(order, count):
        if bits < word:
            if at < end:
                held |= np.uint64(words[at]) << bits
            at += one
            bits += word
        above = np.uint64(0)
        while above < np.uint64(_LONGEST_UNARY) and not held & one:
            held >>= one
            above += one
        if above < np.uint64(_LONGEST_UNARY):
            held >>= one
            bits -= above + one
            if bits < k:
                if at < end:
                    held |= np.uint64(words[at]) << bits
                at += one
                bits += word
            folded = (above << k) | (held & low)
            held >>= k
            bits -= k
        else:
            state[0], state[1], state[2] = held, bits - above, at
            folded = get_word(words, state)
            held, bits, at = state[0], state[1], state[2]
        numbers[i] = _unfolded(folded)
    state[0], state[1], state[2] = held, bits, at
    for turn in range(order - 1, -1, -1):
        for i in range(turn + 1, count):
            numbers[i] += numbers[i - 1]


@step("int64(uint32[::1], uint64[::1])")
def finish(words: Words, state: State) -> Any:
    """Write the bits still held; return how many words there are."""
    if state[1] > np.uint64(0):
        put(words, state, np.uint64(0), 32 - np.int64(state[1]))
    return np.int64(state[2])


@step("boolean(uint32[::1], uint64[::1])")
def is_read(words: Words, state: State) -> Any:
    """Whether a reader has read all words and none beyond the last."""
    used_bits = np.int64(state[2]) * 32 - np.int64(state[1])
    return 32 * (len(words) - 1) < used_bits <= 32 * len(words)
