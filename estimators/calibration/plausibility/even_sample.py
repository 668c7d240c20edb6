"""A sample of numbers that come one after the other for hours, in little room."""

from array import array
from typing import Final

import numpy as np

from estimators.recording import Float

_MOST: Final = 64


class EvenSample:
    """At most 64 of all rows that came, even over the time: for medians of sessions that go on for hours.

    When there are too many, every second is dropped, and from then on every second of those that come is left out.
    While no more than 64 have come, all of them are there.

    Parameters
    ----------
    width : int
        Numbers of a row.
    """

    def __init__(self, width: int = 1) -> None:
        self._width, self._numbers = width, array("d")
        self._came, self._every = 0, 1

    def __len__(self) -> int:
        return len(self._numbers) // self._width

    def add(self, *row: float) -> None:
        """Take the next row."""
        if self._came % self._every == 0:
            if len(self) == _MOST:
                self._numbers = array("d", self._rows()[::2].ravel().tolist())
                self._every *= 2
            self._numbers.extend(row)
        self._came += 1

    def median(self) -> Float:
        """Return the median of each column, shape (width,); of no rows NaN."""
        if not len(self):
            return np.full(self._width, np.nan)
        return np.asarray(np.median(self._rows(), axis=0))

    def _rows(self) -> Float:
        return np.frombuffer(self._numbers).reshape(-1, self._width)
