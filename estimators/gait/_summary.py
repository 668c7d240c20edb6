"""A walk in numbers, each with its uncertainty and the strides it rests on."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait._placement import Steps, foot_placement, steps_between
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides
from estimators.gait.walk.carried import carried_foot
from estimators.gait.walk.measured import Measure, difference, measure, variation
from estimators.gait.walk.reasons import walk_reasons
from estimators.measures import measures_of
from estimators.recording import Float

Bool = NDArray[np.bool_]

EVENT_SIGMA_S = 0.02
"""Of one event from inertial signals, against force plates and simulation."""
_EVENT_RANDOM_S = 0.006
_LATE_S, _LATE_SHARED_S = 0.045, 0.04
"""A soft contact (0.04 s) and a slow toe-off (0.02 s) are late or early alike in every stride of one way of walking:
for times between the two, and between contacts of different feet."""
_AXES_RAD, _HEIGHT_M = np.deg2rad(2.0), 0.005
"""Of the foot's axes found from the walk and of the rolling contact, the same in every stride."""
_BESIDE_M = 0.01
_TURN_RAD = np.deg2rad(20.0)
_OF_TURNS = ("stride_length", "stride_time", "stance_share", "swing_time", "speed", "clearance")


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
        `double_support` per step, `double_support_share` of a stride and `walk_ratio`; empty with one foot, and where
        one is carried.
    asymmetry : dict of str to Measure
        Left less right over their mean, of what both feet have; empty where `both` is.
    initiation_length_m, termination_length_m : dict of Side to ndarray
        Strides that begin and end a bout.
    turning : dict of Side to dict of str to Measure
        `stride_length`, `stride_time`, `stance_share`, `swing_time`, `speed` and `clearance` of continuous strides
        along turns.
    turn_count : int
        Turns of a foot by at least 20 degrees within consecutive strides the same way, the larger of the feet.
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

    Returns
    -------
    GaitSummary
        Over continuous straight walking: strides that begin or end a bout, turn, or have samples missing are not
        averaged in.
    """
    numbers = {side: _foot(strides, steady(strides)) for side, strides in feet.items()}
    both: dict[str, Measure] = {}
    asymmetry: dict[str, Measure] = {}
    if set(feet) == {"left", "right"} and carried_foot(feet) is None:
        both = _double_support(feet["left"], feet["right"])
        both["walk_ratio"] = _walk_ratio(feet["left"], feet["right"])
        numbers["left"]["step_time"] = _step_time(feet["left"], feet["right"])
        numbers["right"]["step_time"] = _step_time(feet["right"], feet["left"])
        for name in measures_of("asymmetry"):
            asymmetry[name] = difference(numbers["left"][name], numbers["right"][name])
    return GaitSummary(
        feet=numbers,
        both=both,
        asymmetry=asymmetry,
        initiation_length_m={
            side: foot.length_m[foot.is_initiation & foot.is_inside] for side, foot in feet.items()
        },
        termination_length_m={
            side: foot.length_m[foot.is_termination & foot.is_inside] for side, foot in feet.items()
        },
        turn_count=max((len(turns(strides)) for strides in feet.values()), default=0),
        bout_count=max((len(np.unique(foot.bout[foot.is_inside])) for foot in feet.values()), default=0),
        reasons=tuple(
            walk_reasons(
                feet,
                {side: steady(strides) for side, strides in feet.items()},
                {side: turning(strides) for side, strides in feet.items()},
                {side: found["toe_out"] for side, found in numbers.items()},
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
    were missing is not known, so no turn is found there; a turn before Record or after Stop is none of the test.
    """
    least = np.deg2rad(5.0)
    is_unknown = (strides.flags & (StrideFlag.MISSING | StrideFlag.OUTSIDE)) != 0
    is_turn = (np.abs(strides.turn_rad) >= least) & ~is_unknown
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


def measure_steps(
    left_m: Float,
    left_s: Float,
    right_m: Float,
    right_s: Float,
    right_from_left_m: Float,
    strides: Mapping[Side, Strides] | None = None,
) -> dict[str, Measure]:
    """Measure steps between feet that can be related; see `steps_between` for the arguments.

    Parameters
    ----------
    strides : mapping of Side to Strides, optional
        Between these footholds: only steps between Record and Stop are measured.

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
    # The worlds are turned onto each other by the footholds at the ends of the way, which scatter as all do.
    scatter = [_beside_course(feet) for feet in (left_m, right_m)]
    shared = float(np.sqrt(0.5 * (scatter[0] ** 2 + scatter[1] ** 2) + _BESIDE_M**2))
    steps = steps_between(left_m, left_s, right_m, right_s, right_from_left_m)
    return step_measures(steps, shared, None if strides is None else steps_inside(strides, steps))


def steps_inside(strides: Mapping[Side, Strides], steps: Steps) -> Bool:
    """Return which steps lie between Record and Stop, shape (n,): those that end a stride there."""
    inside = {side: foot.is_inside for side, foot in strides.items()}
    landed = zip(steps.is_left, steps.foothold, strict=True)
    found = [inside["left" if is_left else "right"][number - 1] for is_left, number in landed]
    return np.array(found, dtype=np.bool_)


def _beside_course(position_m: Float) -> float:
    """Return how far footholds lie beside the straight line of their walk, rms, at least 1 cm."""
    centred = position_m[:, :2] - position_m[:, :2].mean(axis=0)
    smallest = np.linalg.svd(centred, compute_uv=False)[-1]
    return max(float(smallest / np.sqrt(max(len(centred) - 2, 1))), _BESIDE_M)


def step_measures(
    steps: Steps, shared_sigma_m: float = 0.0, is_counted: Bool | None = None
) -> dict[str, Measure]:
    """Measure steps that are found; see `measure_steps`.

    Parameters
    ----------
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
        "step_width": measure(steps.width_m[inner], "m", 0.01, name="step_width"),
        "step_length_left": measure(steps.length_m[inner & steps.is_left], "m", 0.01, name="step_length"),
        "step_length_right": measure(steps.length_m[inner & ~steps.is_left], "m", 0.01, name="step_length"),
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
    known_s = duration[np.isfinite(duration)]
    late = _LATE_S / float(known_s.mean()) if len(known_s) else 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        speed, cadence = length / duration, 120.0 / duration
        speed_sigma = speed * np.sqrt((sigma / length) ** 2 + (two_events / duration) ** 2)
        numbers = {
            "stride_length": measure(length, "m", sigma, name="stride_length"),
            "stride_time": measure(duration, "s", two_events, name="stride_time"),
            "stance_time": measure(strides.stance_s[use], "s", two_events, _LATE_S, name="stance_time"),
            "swing_time": measure(strides.swing_s[use], "s", two_events, _LATE_S, name="swing_time"),
            "stance_share": measure(
                strides.stance_s[use] / duration, "1", two_events / duration, late, name="stance_share"
            ),
            "speed": measure(speed, "m/s", speed_sigma, name="speed"),
            "cadence": measure(cadence, "steps/min", cadence * two_events / duration, name="cadence"),
            "clearance": measure(strides.clearance_m[use], "m", 0.01, _HEIGHT_M, name="clearance"),
            "circumduction": measure(strides.circumduction_m[use], "m", sigma, name="circumduction"),
            "contact_pitch": measure(
                strides.contact_pitch_rad[use], "rad", np.deg2rad(3.0), _AXES_RAD, name="contact_pitch"
            ),
            "toe_off_pitch": measure(
                strides.toe_off_pitch_rad[use], "rad", np.deg2rad(3.0), _AXES_RAD, name="toe_off_pitch"
            ),
            "toe_out": measure(strides.toe_out_rad[use], "rad", np.deg2rad(3.0), _AXES_RAD, name="toe_out"),
            "stride_length_variation": variation(length),
            "stride_time_variation": variation(duration, np.sqrt(2.0) * _EVENT_RANDOM_S),
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
        "double_support": measure(np.array(times), "s", two_events, _LATE_S, name="double_support"),
        "double_support_share": measure(
            np.array(shares), "1", two_events, _LATE_S * _rate_of(times, shares), name="double_support_share"
        ),
    }


def _walk_ratio(left: Strides, right: Strides) -> Measure:
    """Length of a step over steps a second, of each stride: near 0.4 m s in healthy adults at any speed.

    Sekiya N, Nagasaki H. Reproducibility of the walking patterns of normal young adults: test-retest reliability of the
    walk ratio. Gait Posture 7 (1998): step length over step rate, there in m per step a minute.
    """
    length_m = np.concatenate([one.length_m[steady(one)] for one in (left, right)])
    duration_s = np.concatenate([one.duration_s[steady(one)] for one in (left, right)])
    sigma_m = np.concatenate([one.length_sigma_m[steady(one)] for one in (left, right)])
    steps_each_s = 2.0 / duration_s
    slow = np.hypot(0.5 * sigma_m / steps_each_s, 0.5 * length_m * np.sqrt(0.5) * EVENT_SIGMA_S)
    return measure(0.5 * length_m / steps_each_s, "m s", slow, name="walk_ratio")


def _rate_of(times: list[float], shares: list[float]) -> float:
    """Return strides a second."""
    return float(sum(shares) / sum(times)) if times else 0.0


def _step_time(one: Strides, other: Strides) -> Measure:
    """From the contact of the other foot to that of this one."""
    times = []
    known_s = other.contact_s[other.flags == 0]
    for k in np.flatnonzero(steady(one)):
        before = known_s[known_s < one.contact_s[k]]
        if len(before) and one.contact_s[k] - before[-1] < one.duration_s[k]:
            times.append(one.contact_s[k] - before[-1])
    return measure(np.array(times), "s", np.sqrt(2.0) * EVENT_SIGMA_S, _LATE_SHARED_S, name="step_time")
