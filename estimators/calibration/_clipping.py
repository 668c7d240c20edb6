"""Channels that stop at the end of their range."""

from typing import Final

import numpy as np

from estimators.recording import Float

_RUN: Final = 3
_JUST_BELOW: Final = 0.03
_SAME_RANGE: Final = 0.99
_SAME_LEVEL: Final = 1e-9
_REPEATS: Final = 4


def find_plateau(values: Float, least: float) -> float | None:
    """Return the level at which a three-axis sensor is clipped, or None.

    Parameters
    ----------
    values : ndarray, shape (N, 3)
        NaN is skipped.
    least : float
        No device of this kind has a smaller range: peaks below it are peaks.

    Returns
    -------
    float or None
        The largest magnitude of an axis, if it is held for three samples or more and more often than all values
        up to 3 percent below it together: at a clip level samples pile up, near a soft peak they thin out. As all
        axes of a device have one range, no axis may reach beyond it. Where no axis is held for three samples, all
        axes and both signs together tell: four samples at the same largest magnitude to the last digit, two of
        them in a row and twice as many as up to 3 percent below, are short peaks cut off.
    """
    reached = float(np.nanmax(np.abs(values), initial=0.0))
    repeats = beneath = longest_of_all = 0
    for k in range(values.shape[1]):
        for sign in (1.0, -1.0):
            channel = sign * values[:, k]
            channel = channel[np.isfinite(channel)]
            top = float(channel.max(initial=0.0))
            if top < max(least, _SAME_RANGE * reached):
                continue
            at_top = channel >= top * (1.0 - _SAME_LEVEL)
            if at_top.all():
                # A channel that never leaves the top is dead, not clipped.
                continue
            below = int(np.count_nonzero((channel >= (1.0 - _JUST_BELOW) * top) & ~at_top))
            edges = np.flatnonzero(np.diff(np.concatenate(([False], at_top, [False])).astype(np.int8)))
            longest = int((edges[1::2] - edges[::2]).max(initial=0))
            if longest >= _RUN and np.count_nonzero(at_top) >= below:
                return top
            if top >= reached * (1.0 - _SAME_LEVEL):
                repeats += int(np.count_nonzero(at_top))
                beneath += below
                longest_of_all = max(longest_of_all, longest)
    is_repeated = repeats >= _REPEATS and longest_of_all >= 2 and repeats >= 2 * beneath
    return reached if is_repeated else None


__all__ = ["find_plateau"]
