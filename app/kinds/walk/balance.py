"""Stored balance: paths of mass and pressure, base of support, and their numbers."""

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.kinds.walk.schemas import BalanceOut, SupportOut, WalkMeasure
from estimators.balance import sole_middle, stride_balance
from estimators.conventions import SIDES
from estimators.gait import measure
from estimators.kinetics import stretches
from estimators.pipelines import ShoeWalk
from estimators.recording import Float

_PATH_HZ: Final = 20.0
_SUPPORT_HZ: Final = 5.0


def balance_of(found: ShoeWalk) -> BalanceOut:
    """Return the balance of a walk.

    Returns
    -------
    BalanceOut
        Measures: `weight_on_left` (part of the weight) and `centre_to_left_standing` while standing;
        `centre_to_left` (how far the centre of mass is left of the middle between the soles, over whole strides),
        `centre_sway` (its width; both across the path that the feet share),
        `margin` (least of each second), `external_work` (J for each kilogram and metre),
        `pendulum_recovery`.
    """
    feet, centre, time_s = found.feet, found.centre, found.time_s
    thin = slice(None, None, max(1, round(feet.rate_hz / _PATH_HZ)))
    every = max(1, round(len(found.support_s) / max(time_s[-1] - time_s[0], 1e-9) / _SUPPORT_HZ))
    margin = np.interp(time_s, found.support_s, found.margin.margin_m)
    sigma = centre.position_sigma_m
    known = np.full(len(time_s), np.nan) if sigma is None else sigma[:, 1]
    return BalanceOut(
        mass_kg=round(found.mass_kg, 1),
        apart_m=round(found.apart_m, 3),
        apart_source=found.apart_source,
        measures=_measures(found),
        time_s=_rounded(time_s[thin], 3),
        centre_m=[_rounded(row, 4) for row in centre.position_m[thin]],
        centre_sigma_m=_rounded(np.nan_to_num(known[thin]), 4),
        pressure_m=[_rounded(row, 4) for row in feet.cop_m[thin, :2]],
        margin_m=[round(float(v), 4) if np.isfinite(v) else None for v in margin[thin]],
        support=[
            SupportOut(
                time_s=round(float(found.support_s[k]), 3),
                outline_m=[_rounded(row, 3) for row in found.margin.polygons[k]],
            )
            for k in range(0, len(found.support_s), every)
        ],
    )


def _measures(found: ShoeWalk) -> list[WalkMeasure]:
    feet, centre = found.feet, found.centre
    across = feet.aside(centre.position_m)
    measures = []
    seconds = _seconds(feet.is_standing, feet.rate_hz)
    if seconds:
        left, right = (feet.reaction[side].force_n[:, 2] for side in ("left", "right"))
        shares = [left[part].mean() / (left[part].mean() + right[part].mean()) for part in seconds]
        middle = 0.5 * sum(feet.aside(sole_middle(feet, side)) for side in SIDES)
        leans = [float(np.mean((across - middle)[part])) for part in seconds]
        measures.append(_measure("weight_on_left", shares, "1"))
        measures.append(_measure("centre_to_left_standing", leans, "m", _sigma(found, feet.is_standing)))
    strides = stride_balance(
        feet, {side: shoe.contact for side, shoe in found.shoes.items()}, centre, found.mass_kg
    )
    if strides.parts:
        measures += [
            _measure("centre_to_left", strides.aside_m, "m", _sigma(found, ~feet.is_standing)),
            _measure("centre_sway", strides.sway_m, "m"),
            _measure("external_work", strides.work_j_per_kg_m, "J/kg/m"),
            _measure("pendulum_recovery", strides.recovery, "1"),
        ]
    least = _least_of_seconds(found.support_s, found.margin.margin_m)
    if len(least):
        measures.append(_measure("margin", least, "m"))
    return measures


def _seconds(is_standing: NDArray[np.bool_], rate_hz: float) -> list[slice]:
    """Return whole seconds of standing; what is left of each stretch joins its last one."""
    second = max(1, round(rate_hz))
    found = []
    for start, stop in stretches(is_standing):
        count = max(1, (stop - start) // second)
        edges = [start + k * second for k in range(count)] + [stop]
        found += [slice(a, b) for a, b in pairwise(edges)]
    return found


def _sigma(found: ShoeWalk, chosen: NDArray[np.bool_]) -> float | None:
    sigma = found.centre.position_sigma_m
    return None if sigma is None else float(sigma[chosen, 1].mean())


def _least_of_seconds(time_s: Float, margin_m: Float) -> Float:
    known = np.isfinite(margin_m)
    seconds = np.floor(time_s[known]).astype(int)
    return np.array([margin_m[known][seconds == k].min() for k in np.unique(seconds)])


def _measure(
    name: str, values: Float | list[float], unit: str, systematic: float | None = None
) -> WalkMeasure:
    """Average strides or seconds; what is off in all of them alike does not average out."""
    found = measure(np.asarray(values, dtype=np.float64), unit)
    spread = found.spread if np.isfinite(found.spread) else None
    parts = [] if spread is None else [found.sigma]
    parts += [] if systematic is None or not np.isfinite(systematic) else [systematic]
    return WalkMeasure(
        measure=name,
        value=round(found.value, 5) if np.isfinite(found.value) else None,
        sigma=round(float(np.hypot.reduce(parts)), 5) if parts else None,
        spread=None if spread is None else round(spread, 5),
        count=found.count,
        unit=unit,
    )


def _rounded(values: Float, digits: int) -> list[float]:
    return [round(float(v), digits) for v in values]
