"""Curves over the gait cycle: mean and spread of the strides that count."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.kinds.walk.schemas import CurveName, CycleCurve
from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, Side
from estimators.errors import ShapeError
from estimators.gait import FootTrajectory, Measure, Strides, measure
from estimators.kinetics import ForcePeaks, JointLoad, force_peaks
from estimators.pipelines import ShoeWalk
from estimators.recording import Float

PHASES: Final = 51
"""Points of a curve: 0, 2, ... 100 % of the cycle."""
_LEAST: Final = 3
"""Cycles below this number have no spread worth showing."""
_NO_PEAKS: Final = ForcePeaks(float("nan"), float("nan"), float("nan"), False)


def cycle_curves(
    trajectory: FootTrajectory, strides: Strides, counted: NDArray[np.bool_]
) -> list[CycleCurve]:
    """Lay the cycles of a foot over each other, each from a contact with the ground to the next.

    Parameters
    ----------
    counted : ndarray of bool, shape (n,)
        Strides to take; those without a contact before are left out.

    Returns
    -------
    list of CycleCurve
        Height above the straight line between the footholds, and speed; none with fewer than three cycles.
    """
    cycles = _cycles(strides, counted)
    if cycles is None:
        return []
    holds, time_s = strides.footholds, trajectory.time_s
    floor_m = np.interp(time_s, holds.quietest_s, holds.position_m[:, 2])
    speed_mps = np.linalg.norm(trajectory.velocity_mps, axis=1)
    return [
        _curve("height", "m", time_s, trajectory.position_m[:, 2] - floor_m, cycles),
        _curve("speed", "m/s", time_s, speed_mps, cycles),
    ]


def force_curves(
    shoes: ShoeWalk, side: Side, strides: Strides, counted: NDArray[np.bool_]
) -> list[CycleCurve]:
    """Lay forces, moments and power of one foot over each other.

    Forces are parts of body weight (vertical, and forward along the course); moments about the foot's own left
    axis, pressing the toes down, and power are for each kilogram. So is the free moment, with which the ground turns
    the foot about the vertical through the centre of pressure, toes outward; it is nothing while the foot is unloaded.
    """
    cycles = _cycles(strides, counted)
    if cycles is None:
        return []
    shoe, time_s, mass_kg = shoes.shoes[side], shoes.time_s, shoes.mass_kg
    force = shoes.feet.reaction[side].force_n / (mass_kg * GRAVITY_MPS2)
    outward = 1.0 if side == "left" else -1.0
    twist = outward * np.nan_to_num(shoes.feet.reaction[side].free_moment_nm) / mass_kg
    curves = [
        _curve("force_vertical", "1", time_s, force[:, 2], cycles),
        _curve("force_forward", "1", time_s, shoes.feet.ahead(force), cycles),
        _curve("free_moment", "Nm/kg", time_s, twist, cycles),
    ]
    # A hinge turns about its own foot's axis, wherever that points.
    to_foot = rotation.conjugate(shoe.pose.q_room_heel)
    loads: list[tuple[JointLoad | None, CurveName, CurveName]] = [
        (shoe.ankle, "ankle_moment", "ankle_power"),
        (shoe.hinge, "toe_moment", "toe_power"),
    ]
    for load, moment, power in loads:
        if load is not None:
            about = rotation.rotate(to_foot, np.nan_to_num(load.moment_nm))[:, 1]
            curves += [
                _curve(moment, "Nm/kg", time_s, about / mass_kg, cycles),
                _curve(power, "W/kg", time_s, np.nan_to_num(load.power_w) / mass_kg, cycles),
            ]
    return curves


def peak_measures(
    shoes: ShoeWalk, side: Side, strides: Strides, counted: NDArray[np.bool_]
) -> dict[str, Measure]:
    """Return the peaks of the vertical force of a foot, parts of body weight, over the strides that count.

    Returns
    -------
    dict of str to Measure
        `force_most` of every stance; `force_loading`, `force_valley` and `force_push_off` of those with two peaks,
        whose number is their count.
    """
    time_s, force_n = shoes.time_s, shoes.feet.reaction[side].force_n[:, 2]
    weight_n = shoes.mass_kg * GRAVITY_MPS2
    most, found = [], []
    for k in np.flatnonzero(counted & np.isfinite(strides.duration_s) & np.isfinite(strides.toe_off_s)):
        ends_s = strides.contact_s[k] - strides.duration_s[k], strides.toe_off_s[k]
        start, stop = np.searchsorted(time_s, ends_s)
        try:
            peaks = force_peaks(force_n[start:stop], weight_n)
        except ShapeError:
            continue
        most.append(float(force_n[start:stop].max()) / weight_n)
        found.append(peaks if peaks.is_double else _NO_PEAKS)
    columns = {
        "force_most": most,
        "force_loading": [one.loading for one in found],
        "force_valley": [one.valley for one in found],
        "force_push_off": [one.push_off for one in found],
    }
    return {name: measure(np.array(values), "1") for name, values in columns.items()}


def _cycles(strides: Strides, counted: NDArray[np.bool_]) -> Float | None:
    """Return the moments of every phase of every cycle, shape (C, PHASES)."""
    known = np.flatnonzero(counted & np.isfinite(strides.duration_s))
    if len(known) < _LEAST:
        return None
    begin_s = strides.contact_s[known] - strides.duration_s[known]
    phase = np.linspace(0.0, 1.0, PHASES)
    return np.asarray(begin_s[:, None] + phase * strides.duration_s[known][:, None])


def _curve(name: CurveName, unit: str, time_s: Float, values: Float, cycles: Float) -> CycleCurve:
    found = np.interp(cycles, time_s, values)
    return CycleCurve(
        name=name,
        unit=unit,
        mean=[round(float(v), 5) for v in found.mean(axis=0)],
        spread=[round(float(v), 5) for v in found.std(axis=0, ddof=1)],
        cycle_count=len(cycles),
    )
