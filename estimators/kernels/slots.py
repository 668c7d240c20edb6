"""Arrays of one filter in the rows that it shares with others: what a pool of sessions is made of."""

import contextlib
import math
import mmap
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


def sparse_zeros(shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """Return zeros of which only small pages that are written to use memory.

    NumPy asks for huge pages where an array is large: whoever writes a few rows of it then waits milliseconds until two
    megabytes are cleared. That suits what is worked on all the time, not rows that a session fills within seconds.
    """
    if not hasattr(mmap, "MADV_NOHUGEPAGE"):
        return np.zeros(shape, dtype)
    memory = mmap.mmap(-1, max(1, math.prod(shape) * np.dtype(dtype).itemsize), mmap.MAP_PRIVATE)
    # Where all memory is in huge pages; a kernel without them knows no such advice.
    with contextlib.suppress(OSError):
        memory.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(memory, dtype, math.prod(shape)).reshape(shape)


def into_row(values: NDArray[Any], row: NDArray[Any]) -> NDArray[Any]:
    """Return `row` with the values in it; values that are that row already are returned as they are.

    Parameters
    ----------
    values : ndarray
        What was held so far.
    row : ndarray, the same shape
        A view of the pool's array.
    """
    if values.base is not row.base or values.ctypes.data != row.ctypes.data:
        row[...] = values
        return row
    return values
