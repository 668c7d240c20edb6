"""A walk in numbers, each with its uncertainty and the strides it rests on."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait._placement import Steps, foot_placement, steps_between
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides
from estimators.gait._walk_reasons import walk_reasons
from estimators.recording import Float

Bool = NDArray[np.bool_]

EVENT_SIGMA_S = 0.02
"""Of one event from inertial signals, against force plates and simulation."""
_TURN_RAD = np.deg2rad(20.0)
_LEAST_FOR_SPREAD = 3
_OF_TURNS = ("stride_length", "stride_time", "stance_share", "swing_time", "speed", "clearance")


@dataclass(frozen=True)
class Measure:
    """One number of a walk.

    Attributes
    ----------
    value : float
        Mean over the strides; NaN when there is none.
    sigma : float
        Standard error of that mean: spread over strides and what the sensors leave uncertain.
    spread : float
        Standard deviation over strides (ddof 1); NaN below 3 strides.
    count : int
        Strides.
    unit : str
    """

    value: float
    sigma: float
    spread: float
    count: int
    unit: str


@dataclass(frozen=True)
class GaitSummary:
    """Steady straight walking of one or both feet.

    Attributes
    ----------
    feet : dict of Side to dict of str to Measure
        Per foot: `stride_length`, `stride_time`, `stance_share`, `swing_time`, `speed`, `cadence`, `clearance`,
        `step_time` (with both feet), `circumduction`, `contact_pitch`, `toe_off_pitch`, `toe_out`,
        `lateral_placement` (rms spread against the sliding path), `stride_length_variation` and
        `stride_time_variation` (coefficients of variation).
    both : dict of str to Measure
        `double_support` per step and `double_support_share` of a stride; empty with one foot.
    asymmetry : dict of str to Measure
        Left less right over their mean, of what both feet have; empty with one foot.
    initiation_length_m, termination_length_m : dict of Side to ndarray
        Strides that begin and end a bout.
    turning : dict of Side to dict of str to Measure
        `stride_length`, `stride_time`, `stance_share`, `swing_time`, `speed` and `clearance` of continuous strides
        along turns.
    turn_count : int
        Turns of a foot by at least 20 degrees within consecutive strides the same way, the larger of the feet.
    bout_count : int
    reasons : tuple of str
        What could not be given, and why.
    """

    feet: Mapping[Side, Mapping[str, Measure]]
    both: Mapping[str, Measure]
    asymmetry: Mapping[str, Measure]
    initiation_length_m: Mapping[Side, Float]
    termination_length_m: Mapping[Side, Float]
    turn_count: int
    bout_count: int
    reasons: tuple[str, ...]
    turning: Mapping[Side, Mapping[str, Measure]] = field(default_factory=dict)


def summarise(feet: Mapping[Side, Strides]) -> GaitSummary:
    """Put the strides of one or both feet into numbers.

    Parameters
    ----------
    feet : mapping of Side to Strides

    Returns
    -------
    GaitSummary
        Over continuous straight walking: strides that begin or end a bout, turn, or have samples missing are not
        averaged in.
    """
    numbers = {side: _foot(strides, steady(strides)) for side, strides in feet.items()}
    both: dict[str, Measure] = {}
    asymmetry: dict[str, Measure] = {}
    if set(feet) == {"left", "right"}:
        both = _double_support(feet["left"], feet["right"])
        numbers["left"]["step_time"] = _step_time(feet["left"], feet["right"])
        numbers["right"]["step_time"] = _step_time(feet["right"], feet["left"])
        for name in ("stride_length", "step_time", "stance_share", "swing_time", "clearance"):
            asymmetry[name] = _difference(numbers["left"][name], numbers["right"][name])
    return GaitSummary(
        feet=numbers,
        both=both,
        asymmetry=asymmetry,
        initiation_length_m={side: foot.length_m[foot.is_initiation] for side, foot in feet.items()},
        termination_length_m={side: foot.length_m[foot.is_termination] for side, foot in feet.items()},
        turn_count=max((len(turns(strides)) for strides in feet.values()), default=0),
        bout_count=max((int(s.bout.max()) + 1 for s in feet.values() if s.count), default=0),
        reasons=tuple(
            walk_reasons(
                feet,
                {side: steady(strides) for side, strides in feet.items()},
                {side: turning(strides) for side, strides in feet.items()},
            )
        ),
        turning={side: _over_turns(strides) for side, strides in feet.items()},
    )


def steady(strides: Strides) -> Bool:
    """Return which strides are continuous straight walking, shape (n,)."""
    return np.asarray(_continuous(strides) & ~_is_turning(strides))


def turning(strides: Strides) -> Bool:
    """Return which strides are continuous walking along a turn, shape (n,); see `turns`."""
    return np.asarray(_continuous(strides) & _is_turning(strides))


def _continuous(strides: Strides) -> Bool:
    return np.asarray(~strides.is_initiation & ~strides.is_termination & (strides.flags == 0))


def _is_turning(strides: Strides) -> Bool:
    found = np.abs(strides.turn_rad) > _TURN_RAD
    for start, stop, _ in turns(strides):
        found[start:stop] = True
    return np.asarray(found)


def turns(strides: Strides) -> list[tuple[int, int, float]]:
    """Return turns of at least 20 degrees: first stride, one past the last, and the angle (left positive).

    Consecutive strides that turn the same way by at least 5 degrees each are one turn. What a foot did while samples
    were missing is not known, so no turn is found there.
    """
    least = np.deg2rad(5.0)
    is_turn = (np.abs(strides.turn_rad) >= least) & ((strides.flags & StrideFlag.MISSING) == 0)
    way = np.where(is_turn, np.sign(strides.turn_rad), 0.0)
    found = []
    start = 0
    for k in range(1, len(way) + 1):
        if k == len(way) or way[k] != way[start] or strides.bout[k] != strides.bout[start]:
            angle = float(strides.turn_rad[start:k].sum())
            if way[start] != 0.0 and abs(angle) >= _TURN_RAD:
                found.append((start, k, angle))
            start = k
    return found


def measure(values: Float, unit: str, sigma: Float | float = 0.0) -> Measure:
    """Average values of single strides; `sigma` is the uncertainty of each. Values that are not known are left out."""
    known = np.isfinite(values)
    count = int(np.count_nonzero(known))
    if count == 0:
        return Measure(float("nan"), float("nan"), float("nan"), 0, unit)
    chosen = values[known]
    each = np.broadcast_to(sigma, values.shape)[known]
    spread = float(chosen.std(ddof=1)) if count >= _LEAST_FOR_SPREAD else float("nan")
    sensors = float(np.sqrt(np.mean(each**2)))
    # The spread over strides already holds what the sensors add to each; with few strides only that is known.
    error = max(spread, sensors) if np.isfinite(spread) else sensors
    return Measure(float(chosen.mean()), error / np.sqrt(count), spread, count, unit)


def measure_steps(
    left_m: Float, left_s: Float, right_m: Float, right_s: Float, right_from_left_m: Float
) -> dict[str, Measure]:
    """Measure steps between feet that can be related; see `steps_between` for the arguments.

    Returns
    -------
    dict of str to Measure
        `step_width`, `step_length_left` and `step_length_right` (of the foot that lands), without the first and the
        last step of each foot.

    Raises
    ------
    ShapeError
        With fewer than two footholds of a foot.
    """
    return step_measures(steps_between(left_m, left_s, right_m, right_s, right_from_left_m))


def step_measures(
    steps: Steps, shared_sigma_m: float = 0.0, is_counted: Bool | None = None
) -> dict[str, Measure]:
    """Measure steps that are found; see `measure_steps`.

    Parameters
    ----------
    steps : Steps
    shared_sigma_m : float
        One sigma of where the feet are against each other, which is the same for all steps and so no count makes
        smaller.
    is_counted : ndarray of bool, shape (n,), optional
        Steps to average, beside the first and the last ones; all by default.
    """
    inner = np.ones(len(steps.is_left), dtype=np.bool_) if is_counted is None else is_counted.copy()
    inner[:1], inner[-2:] = False, False
    # Footholds of both feet scatter by as much as two instants of one stance differ.
    found = {
        "step_width": measure(steps.width_m[inner], "m", 0.01),
        "step_length_left": measure(steps.length_m[inner & steps.is_left], "m", 0.01),
        "step_length_right": measure(steps.length_m[inner & ~steps.is_left], "m", 0.01),
    }
    return {
        name: replace(one, sigma=float(np.hypot(one.sigma, shared_sigma_m))) for name, one in found.items()
    }


def _over_turns(strides: Strides) -> dict[str, Measure]:
    found = _foot(strides, turning(strides))
    return {name: found[name] for name in _OF_TURNS}


def _foot(strides: Strides, use: Bool) -> dict[str, Measure]:
    duration, length = strides.duration_s[use], strides.length_m[use]
    sigma = strides.length_sigma_m[use]
    two_events = np.sqrt(2.0) * EVENT_SIGMA_S
    with np.errstate(invalid="ignore", divide="ignore"):
        speed, cadence = length / duration, 120.0 / duration
        speed_sigma = speed * np.sqrt((sigma / length) ** 2 + (two_events / duration) ** 2)
        numbers = {
            "stride_length": measure(length, "m", sigma),
            "stride_time": measure(duration, "s", two_events),
            "stance_time": measure(strides.stance_s[use], "s", two_events),
            "swing_time": measure(strides.swing_s[use], "s", two_events),
            "stance_share": measure(strides.stance_s[use] / duration, "1", two_events / duration),
            "speed": measure(speed, "m/s", speed_sigma),
            "cadence": measure(cadence, "steps/min", cadence * two_events / duration),
            "clearance": measure(strides.clearance_m[use], "m", 0.01),
            "circumduction": measure(strides.circumduction_m[use], "m", sigma),
            "contact_pitch": measure(strides.contact_pitch_rad[use], "rad", np.deg2rad(3.0)),
            "toe_off_pitch": measure(strides.toe_off_pitch_rad[use], "rad", np.deg2rad(3.0)),
            "toe_out": measure(strides.toe_out_rad[use], "rad", np.deg2rad(3.0)),
            "stride_length_variation": _variation(length),
            "stride_time_variation": _variation(duration),
        }
    numbers["lateral_placement"] = _lateral(strides, use)
    return numbers


def _lateral(strides: Strides, use: Bool) -> Measure:
    """Return the rms of lateral placement in windows of three footholds within steady walking."""
    middles = []
    for start, stop in _stretches(use):
        placed = foot_placement(strides.footholds.position_m[start : stop + 1])
        middles.extend(placed.lateral_m.reshape(-1).tolist())
    values = np.array(middles)
    if not len(values):
        return Measure(float("nan"), float("nan"), float("nan"), 0, "m")
    count = len(values) // 3
    rms = float(np.sqrt(np.mean(values**2)))
    # Each window of three has one degree of freedom.
    return Measure(rms, rms / np.sqrt(2.0 * count), float("nan"), count, "m")


def _stretches(use: Bool) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], use, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _variation(values: Float) -> Measure:
    known = values[np.isfinite(values)]
    count = len(known)
    if count < _LEAST_FOR_SPREAD:
        return Measure(float("nan"), float("nan"), float("nan"), count, "1")
    share = float(known.std(ddof=1) / known.mean())
    return Measure(share, share / np.sqrt(2.0 * (count - 1)), float("nan"), count, "1")


def _double_support(left: Strides, right: Strides) -> dict[str, Measure]:
    """Both feet on the ground: from a contact of one foot to the toe-off of the other."""
    times, shares = [], []
    for one, other in ((left, right), (right, left)):
        known_s = other.toe_off_s[other.flags == 0]
        for k in np.flatnonzero(steady(one)):
            after = known_s[known_s > one.contact_s[k]]
            if len(after) and after[0] - one.contact_s[k] < one.duration_s[k]:
                times.append(after[0] - one.contact_s[k])
                shares.append(times[-1] / one.duration_s[k])
    two_events = np.sqrt(2.0) * EVENT_SIGMA_S
    return {
        "double_support": measure(np.array(times), "s", two_events),
        "double_support_share": measure(np.array(shares), "1", two_events),
    }


def _step_time(one: Strides, other: Strides) -> Measure:
    """From the contact of the other foot to that of this one."""
    times = []
    known_s = other.contact_s[other.flags == 0]
    for k in np.flatnonzero(steady(one)):
        before = known_s[known_s < one.contact_s[k]]
        if len(before) and one.contact_s[k] - before[-1] < one.duration_s[k]:
            times.append(one.contact_s[k] - before[-1])
    return measure(np.array(times), "s", np.sqrt(2.0) * EVENT_SIGMA_S)


def _difference(left: Measure, right: Measure) -> Measure:
    mean = 0.5 * (left.value + right.value)
    value = (left.value - right.value) / mean if mean else float("nan")
    sigma = float(np.hypot(left.sigma, right.sigma) / abs(mean)) if mean else float("nan")
    return Measure(value, sigma, float("nan"), min(left.count, right.count), "1")


__all__ = [
    "GaitSummary",
    "Measure",
    "measure",
    "measure_steps",
    "steady",
    "step_measures",
    "summarise",
    "turning",
    "turns",
]
