"""One side against the other."""

from typing import Final

import numpy as np

_SIGMAS: Final = 2.0


def symmetry_ratio(affected: float, other: float, sigma: float = 0.0) -> float:
    """Return ln(x_affected / x_other): 0 is alike, -0.2231 is a fifth less.

    Parameters
    ----------
    affected, other : float
        A measure of each side, above zero.
    sigma : float
        Standard deviation of one value.

    Returns
    -------
    float
        NaN where a value is below two sigma or not above zero: a ratio of what may be nothing says nothing.
    """
    return float(np.log(affected / other)) if _is_known(affected, other, sigma) else float("nan")


def symmetry_angle(left: float, right: float, sigma: float = 0.0) -> float:
    """Return (45 deg - atan(x_left / x_right)) / 90 deg, which needs no side to refer to.

    Parameters
    ----------
    left, right : float
        A measure of each side, above zero.
    sigma : float
        Standard deviation of one value.

    Returns
    -------
    float
        -0.5 to 0.5, 0 is alike, negative where the left is larger; NaN as of `symmetry_ratio`.

    Notes
    -----
    Zifchock, Davis, Higginson and Royer 2008, Gait Posture 27:622; 50 and 40 give -0.0704.
    """
    if not _is_known(left, right, sigma):
        return float("nan")
    return float((0.25 * np.pi - np.arctan(left / right)) / (0.5 * np.pi))


def _is_known(one: float, other: float, sigma: float) -> bool:
    least = min(one, other)
    return bool(np.isfinite(one + other) and least > 0 and least >= _SIGMAS * sigma)
