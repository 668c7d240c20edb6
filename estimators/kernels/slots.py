"""Arrays of one filter in the rows that it shares with others: what a pool of sessions is made of."""

from typing import Any

from numpy.typing import NDArray


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


__all__ = ["into_row"]
