"""Height and speed of a foot over its gait cycle: mean and spread of the strides that count."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.recordings.walk_schemas import CycleCurve
from estimators.gait import FootTrajectory, Strides

PHASES: Final = 51
"""Points of a curve: 0, 2, ... 100 % of the cycle."""
_LEAST: Final = 3
"""Cycles below this number have no spread worth showing."""


def cycle_curves(
    trajectory: FootTrajectory, strides: Strides, counted: NDArray[np.bool_]
) -> list[CycleCurve]:
    """Lay the cycles of a foot over each other, each from a contact with the ground to the next.

    Parameters
    ----------
    trajectory : FootTrajectory
    strides : Strides
    counted : ndarray of bool, shape (n,)
        Strides to take; those without a contact before are left out.

    Returns
    -------
    list of CycleCurve
        Height above the straight line between the footholds, and speed; none with fewer than three cycles.
    """
    known = np.flatnonzero(counted & np.isfinite(strides.duration_s))
    if len(known) < _LEAST:
        return []
    holds = strides.footholds
    floor_m = np.interp(trajectory.time_s, holds.quietest_s, holds.position_m[:, 2])
    shown = {
        "height": trajectory.position_m[:, 2] - floor_m,
        "speed": np.linalg.norm(trajectory.velocity_mps, axis=1),
    }
    begin_s = strides.contact_s[known] - strides.duration_s[known]
    phase = np.linspace(0.0, 1.0, PHASES)
    time_s = begin_s[:, None] + phase * strides.duration_s[known][:, None]
    curves = []
    for name, values in shown.items():
        cycles = np.interp(time_s, trajectory.time_s, values)
        curves.append(
            CycleCurve(
                name="height" if name == "height" else "speed",
                unit="m" if name == "height" else "m/s",
                mean=[round(float(v), 5) for v in cycles.mean(axis=0)],
                spread=[round(float(v), 5) for v in cycles.std(axis=0, ddof=1)],
                cycle_count=len(known),
            )
        )
    return curves


__all__ = ["PHASES", "cycle_curves"]
