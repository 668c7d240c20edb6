"""What is kept of balance: paths of mass and pressure, base of support, and their numbers."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.recordings.walk_schemas import BalanceOut, SupportOut, WalkMeasure
from estimators import rotation
from estimators.balance import walking_work
from estimators.conventions import Side
from estimators.kinetics import ShoeGeometry, ShoePose
from estimators.pipelines import ShoeWalk
from estimators.recording import Float

_PATH_HZ: Final = 20.0
_SUPPORT_HZ: Final = 5.0


def balance_of(found: ShoeWalk) -> BalanceOut:
    """Return the balance of a walk.

    Parameters
    ----------
    found : ShoeWalk

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
    left, right = feet.pose["left"], feet.pose["right"]
    walking = ~feet.is_standing
    across = feet.aside(centre.position_m)
    measures = []
    if feet.is_standing.any():
        force = [feet.reaction[side].force_n[feet.is_standing, 2].mean() for side in ("left", "right")]
        measures.append(_measure("weight_on_left", force[0] / sum(force), "1"))
        still = feet.is_standing
        middle = 0.5 * (feet.aside(_sole(left)) + feet.aside(_sole(right)))[still]
        aside = float(np.mean(across[still] - middle))
        measures.append(_measure("centre_to_left_standing", aside, "m", _sigma(found, still)))
    if walking.any():
        strides = _whole_strides(found, walking)
        middle_m = 0.5 * (_stood(found, "left") + _stood(found, "right"))
        aside = float(np.mean(across[strides])) - middle_m
        measures.append(_measure("centre_to_left", aside, "m", _sigma(found, strides)))
        low, high = np.percentile(across[walking], [2.5, 97.5])
        measures.append(_measure("centre_sway", high - low, "m"))
        work = walking_work(centre.position_m[walking], centre.velocity_mps[walking], found.mass_kg)
        measures.append(_measure("external_work", work.external_j_per_m / found.mass_kg, "J/kg/m"))
        measures.append(_measure("pendulum_recovery", work.recovery, "1"))
    least = _least_of_seconds(found.support_s, found.margin.margin_m)
    if len(least):
        measures.append(
            WalkMeasure(
                measure="margin",
                value=round(float(least.mean()), 4),
                sigma=None,
                spread=round(float(least.std()), 4),
                count=len(least),
                unit="m",
            )
        )
    return measures


def _sole(pose: ShoePose) -> Float:
    """Return the middle of a sole, shape (N, 3)."""
    geometry = ShoeGeometry()
    ahead = 0.5 * (geometry.rear_edge_m + geometry.hinge_m + geometry.toe_edge_m)
    return np.asarray(pose.heel_m + rotation.rotate(pose.q_room_heel, np.array([ahead, 0.0, 0.0])))


def _stood(found: ShoeWalk, side: Side) -> float:
    """Return how far left the sole of a foot stood, mean of its rests but the first and the last."""
    rests = found.shoes[side].contact.core.mean(axis=1).astype(int)
    inner = rests[1:-1] if len(rests) > 2 else rests
    return float(found.feet.aside(_sole(found.feet.pose[side]))[inner].mean())


def _whole_strides(found: ShoeWalk, walking: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the samples of whole strides of the left foot: part of a stride leans to one side."""
    lands = found.shoes["left"].contact.land
    lands = lands[walking[np.minimum(lands, len(walking) - 1)]]
    if len(lands) < 3:
        return walking
    chosen = np.zeros_like(walking)
    chosen[lands[0] : lands[-2]] = True
    return chosen


def _sigma(found: ShoeWalk, chosen: NDArray[np.bool_]) -> float | None:
    sigma = found.centre.position_sigma_m
    return None if sigma is None else float(sigma[chosen, 1].mean())


def _least_of_seconds(time_s: Float, margin_m: Float) -> Float:
    known = np.isfinite(margin_m)
    seconds = np.floor(time_s[known]).astype(int)
    return np.array([margin_m[known][seconds == k].min() for k in np.unique(seconds)])


def _measure(name: str, value: float, unit: str, sigma: float | None = None) -> WalkMeasure:
    return WalkMeasure(
        measure=name,
        value=round(float(value), 5) if np.isfinite(value) else None,
        sigma=None if sigma is None or not np.isfinite(sigma) else round(float(sigma), 5),
        spread=None,
        count=1,
        unit=unit,
    )


def _rounded(values: Float, digits: int) -> list[float]:
    return [round(float(v), digits) for v in values]


__all__ = ["balance_of"]
