"""How far the feet are apart, from the forces alone: Newton's law of rotation."""

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.balance.mass_centre._published import acceleration, integrate_twice
from estimators.conventions import SIDES, Side
from estimators.errors import SetupError, ShapeError
from estimators.kinetics import LEAST_LOAD_N, GroundReaction
from estimators.recording import Float


def distance_between_feet(
    reactions: dict[Side, GroundReaction],
    rate_hz: float,
    mass_kg: float,
    com_height_m: float,
    *,
    axis: int = 1,
    high_pass_hz: float = 0.3,
    is_walking: NDArray[np.bool_] | None = None,
) -> float:
    """Return the distance from the right to the left foot at the start, metres.

    Parameters
    ----------
    reactions : dict of Side to GroundReaction
        Each foot in a frame of its own: same heading, but both starting at zero along `axis`.
    com_height_m : float
        Above the floor; 0.55 of stature does.
    axis : int
        1 for sideways, 0 for forward.
    high_pass_hz : float
        Below it neither the double integral nor the sum of moments says anything.
    is_walking : ndarray of bool, shape (N,), optional
        Samples that count; all by default.

    Raises
    ------
    ShapeError
        If the feet do not carry the weight in turn: standing tells nothing.
    SetupError
        For an axis that is not horizontal.

    Notes
    -----
    With no change of angular momentum `(c - p) x F = 0` (Schepers 2009, section 4.4), so
    `c_0 = w_l p_l + w_r p_r + z F_y / F_z` is the centre of mass but for D times the right foot's share of
    the weight. The fast part of c is known from the double integral of the force: D is the regression of
    their difference on the share.
    """
    if axis not in (0, 1):
        raise SetupError("axis is 0 (forward) or 1 (sideways)")
    force = {
        side: np.where(reactions[side].is_loaded[:, None], reactions[side].force_n, 0.0) for side in SIDES
    }
    total = force["left"] + force["right"]
    if not total[:, 2].min() > max(LEAST_LOAD_N, 0.1 * float(total[:, 2].mean())):
        raise ShapeError("nobody stands on the shoes at times; cut that out first")
    share = force["right"][:, 2] / total[:, 2]
    anchor = (1.0 - share) * np.nan_to_num(reactions["left"].cop_m[:, axis])
    anchor += share * np.nan_to_num(reactions["right"].cop_m[:, axis])
    anchor += com_height_m * total[:, axis] / total[:, 2]
    _, moved = integrate_twice(acceleration(total, mass_kg), rate_hz)
    sections = scipy.signal.butter(2, high_pass_hz, "high", fs=rate_hz, output="sos")

    def fast(values: Float) -> Float:
        padding = min(values.size - 1, round(3.0 * rate_hz / high_pass_hz))
        return np.asarray(scipy.signal.sosfiltfilt(sections, values, padlen=padding))

    counted = np.ones(share.size, dtype=np.bool_) if is_walking is None else is_walking
    stepping = fast(share)[counted]
    power = float(stepping @ stepping)
    if power < 0.01 * stepping.size or not stepping.size:
        raise ShapeError("the feet do not carry the weight in turn; a distance takes some steps")
    return float(stepping @ (fast(anchor) - fast(moved[:, axis]))[counted] / power)
