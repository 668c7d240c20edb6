"""How much farther than a gyroscope says gravity and field turn: a wrong rate or clock, or a wrong range or unit."""

from typing import Final, NamedTuple

import numpy as np

from estimators.calibration.plausibility.leftover import of_field_at, of_force_at
from estimators.recording import Float

FITS: Final = np.array([2.5, 3.5])
"""What the right reading leaves of gravity, and of the field, in a window on average: in sound recordings, a magnet
nearby included, at most 1.7 and 2.9."""
NEAREST: Final = 1.2
"""A gyroscope that is off by less is a poor one."""
_FARTHEST: Final = 6.0
_STEP: Final = 1.07
"""From one pace that is tried to the next: in some seconds a limb turns by a few radians."""
_ROUNDS: Final = 7
"""Of halving the steps around the best: to a thousandth."""
_MOST_WINDOWS: Final = 6


class Moved(NamedTuple):
    """Windows in which a direction turned in a sensor.

    Attributes
    ----------
    rate : ndarray, shape (W, N, 3)
        Gyroscope, rad/s.
    direction : ndarray, shape (W, N, 3)
        Gravity or field, of about unit size.
    """

    rate: Float
    direction: Float

    def first(self, count: int) -> "Moved":
        """Return the first windows: those that say most."""
        return Moved(self.rate[:count], self.direction[:count])


def at_pace(gravity: Moved, earth: Moved, step_s: float, pace: float) -> Float:
    """Return what is left at a pace of the clock, and of the gyroscope, and the prices; see `Evidence.paced`."""
    turned = [Moved(pace * rate, direction) for rate, direction in (gravity, earth)]
    # For the field the two are the same.
    nothing = np.zeros(2)
    of_field = of_field_at(*turned[1], step_s) if len(earth.rate) else nothing
    if not len(gravity.rate):
        return np.array([[nothing, of_field]] * 2)
    of_clock = of_force_at(*gravity, pace * step_s)
    return np.array([[of_clock, of_field], [of_force_at(*turned[0], step_s), of_field]])


def pace_of(gravity: Moved, earth: Moved, step_s: float, as_they_are: Float) -> float:
    """Return how many times as far as a gyroscope says its sensor turns; 1 where no other number fits.

    Parameters
    ----------
    as_they_are : ndarray, shape (2,)
        What readings leave of gravity and field as they are.
    """
    windows = np.array([len(gravity.rate), len(earth.rate)])
    if not windows.any() or (as_they_are <= FITS * windows).all():
        return 1.0
    gravity, earth = gravity.first(_MOST_WINDOWS), earth.first(_MOST_WINDOWS)

    def cost(pace: float) -> float:
        return float(at_pace(gravity, earth, step_s, pace).sum(axis=(1, 2)).min())

    count = round(np.log(_FARTHEST) / np.log(_STEP))
    tried = _STEP ** np.arange(-count, count + 1, dtype=np.float64)
    costs = [cost(one) for one in tried.tolist()]
    best, least, step = float(tried[int(np.argmin(costs))]), min(costs), _STEP
    for _ in range(_ROUNDS):
        step = float(np.sqrt(step))
        for one in (best / step, best * step):
            if (found := cost(one)) < least:
                best, least = one, found
    # At the end of what was tried nothing fits: the gyroscope is only ignored.
    return best if NEAREST < max(best, 1.0 / best) < _FARTHEST / _STEP else 1.0
