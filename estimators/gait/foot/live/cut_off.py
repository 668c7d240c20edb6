"""Which axes of a sample that is marked as cut off are, live, where no level is declared."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.gait._stance_kernel import CUT_FORCE, CUT_RATE
from estimators.gait.foot.parameters import LEAST_RANGE
from estimators.recording import Float

_NEAR: Final = 0.97
"""All axes of a device have one range but for their calibration."""
_LEAST: Final = (LEAST_RANGE["gyroscope_clip_radps"], LEAST_RANGE["accelerometer_clip_mps2"])
_BITS: Final = (np.array([CUT_RATE, 2 * CUT_RATE, 4 * CUT_RATE]), np.full(3, CUT_FORCE))


class CutOffAxes:
    """Finds the axes behind a mark, which says only that one of the six is at the end of its range.

    An axis that is cut off is at the largest value that its triad has ever shown, and beyond the range of the least
    device; where both triads are, both are taken for it. A mark on a sample where no axis is says nothing: a device
    may mark a whole packet of all its sensors.

    Parameters
    ----------
    largest : ndarray, shape (2,), optional
        Magnitudes of any axis so far, rad/s and m/s^2; what the next sample depends on. Carried on in place.
    """

    def __init__(self, largest: Float | None = None) -> None:
        self.largest = np.zeros(2) if largest is None else largest

    def find(
        self, gyroscope_radps: Float, accelerometer_mps2: Float, is_marked: NDArray[np.bool_]
    ) -> NDArray[np.uint8]:
        """Take the next K samples, shape (K, 3), and return `CUT_RATE` bits of each axis and `CUT_FORCE`, (K,)."""
        found = np.zeros(len(is_marked), dtype=np.uint8)
        if not len(found):
            return found
        if not is_marked.any():
            # Nearly every chunk of a live foot: only what is remembered of it.
            for triad, values in enumerate((gyroscope_radps, accelerometer_mps2)):
                self.largest[triad] = max(self.largest[triad], values.max(), -values.min())
            return found
        for triad, values in enumerate((np.abs(gyroscope_radps), np.abs(accelerometer_mps2))):
            highest = np.concatenate([self.largest[triad : triad + 1], values.max(axis=1)])
            largest = np.maximum.accumulate(highest)[1:]
            self.largest[triad] = largest[-1]
            limit = np.maximum(_NEAR * largest, _LEAST[triad])
            is_cut = is_marked[:, None] & (values >= limit[:, None])
            found |= np.bitwise_or.reduce(np.where(is_cut, _BITS[triad], 0).astype(np.uint8), axis=1)
        return found
