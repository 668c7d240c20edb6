"""Ground reaction without force sensors: from the acceleration of the centre of mass and when feet touch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2, SIDES, Side
from estimators.errors import SetupError, ShapeError
from estimators.kinetics._contact import stretches
from estimators.recording import Float


@dataclass(frozen=True)
class PredictedReaction:
    """Of the ground over N samples, room frame: predicted, not measured.

    Attributes
    ----------
    force_n : dict of Side to ndarray, shape (N, 3)
    total_n : ndarray, shape (N, 3)
    cop_m : ndarray, shape (N, 3)
        Of both feet, on the floor.
    share : dict of Side to ndarray, shape (N,)
        Of the weight.
    """

    force_n: dict[Side, Float]
    total_n: Float
    cop_m: Float
    share: dict[Side, Float]


def predicted_reaction(
    com_m: Float,
    com_acceleration_mps2: Float,
    mass_kg: float,
    contact: dict[Side, NDArray[np.bool_]],
    floor_m: Float | float = 0.0,
) -> PredictedReaction:
    """Predict the ground reaction of a walk from inertial sensors alone.

    Parameters
    ----------
    com_m, com_acceleration_mps2 : ndarray, shape (N, 3)
        Of the centre of mass: from worn segments, or a sensor on the pelvis.
    contact : dict of Side to ndarray of bool, shape (N,)
        From gait events.
    floor_m : float or ndarray, shape (N,)

    Raises
    ------
    SetupError
        If a side is missing or the mass cannot be.
    ShapeError
        If the series differ in length.

    Notes
    -----
    Newton gives the sum, `m (a - g)`; in single support one foot has it all. In double support the weight
    goes from one foot to the other as a minimum-jerk step over its time, the smooth-transition assumption
    (Ren, Jones and Howard 2008) with the curve of our own. The pressure centre is where the line of the total
    force meets the floor, which takes the angular momentum for constant. When neither foot touches, nothing
    acts.
    """
    if set(contact) != set(SIDES) or not mass_kg > 0.0:
        raise SetupError("a prediction needs the contact of both feet and a mass above zero")
    samples = com_m.shape[0]
    if com_acceleration_mps2.shape != com_m.shape or any(len(contact[side]) != samples for side in SIDES):
        raise ShapeError("centre of mass, acceleration and contacts must have the same samples")
    total = mass_kg * (com_acceleration_mps2 + np.array([0.0, 0.0, GRAVITY_MPS2]))
    left, right = contact["left"], contact["right"]
    share = np.where(left & ~right, 1.0, 0.0)
    for start, end in stretches(left & right):
        before = share[start - 1] if start else 0.5
        after = 0.5 if end == samples else float(left[end] and not right[end])
        if start == 0:
            before = 0.5
        share[start:end] = _handed_over(before, after, end - start, start == 0, end == samples)
    shares: dict[Side, Float] = {"left": share, "right": np.where(left | right, 1.0 - share, 0.0)}
    total = np.where((left | right)[:, None], total, 0.0)
    vertical = np.where(total[:, 2] > 0.1 * mass_kg * GRAVITY_MPS2, total[:, 2], np.nan)
    height = com_m[:, 2] - floor_m
    cop = com_m - (height / vertical)[:, None] * total
    cop[:, 2] = np.where(np.isnan(vertical), np.nan, floor_m)
    force: dict[Side, Float] = {side: shares[side][:, None] * total for side in SIDES}
    return PredictedReaction(force, total, cop, shares)


def _handed_over(before: float, after: float, count: int, begins: bool, ends: bool) -> Float:
    """Return how a share changes over a double support; standing at an end of the record is half and half."""
    u = (np.arange(count) + 0.5) / count
    if begins or ends:
        # Somebody who stands shifts the weight only near the step.
        u = np.clip((u - 1.0) * 4.0 + 1.0, 0.0, 1.0) if begins else np.clip(u * 4.0, 0.0, 1.0)
    step = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    return np.asarray(before + (after - before) * step)
