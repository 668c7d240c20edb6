"""Walking tests of the clinic from the strides of both feet: a walk, timed up and go, six minutes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides
from estimators.gait._summary import turns
from estimators.gait.walk.carried import carried_foot
from estimators.recording import Float
from estimators.sentences import say

GuidedKind = Literal["walk", "timed_up_and_go", "six_minute_walk"]
GUIDED_KINDS: Final[tuple[GuidedKind, ...]] = ("walk", "timed_up_and_go", "six_minute_walk")
SIX_MINUTES_S: Final = 360.0
_ABOUT_TURN_RAD: Final = np.deg2rad(120.0)
_LEAST_OF_SIX: Final = 0.98
_FEET_APART_M, _WAY_SHARE = 0.2, 0.05


@dataclass(frozen=True)
class GuidedTest:
    """Result of a walking test.

    Attributes
    ----------
    start_s, end_s : float
        First toe-off and last contact that count, on the recording's clock.
    distance_m, distance_sigma_m : float
        Way of the feet, mean of both, and its standard deviation from that of the strides. Of one foot, with a reason,
        where the other was carried, has gaps or lost strides; probably too short where both have gaps.
    step_count, turn_count, pause_count : int
        Steps of both feet (twice those of one, when only one is known; those of one, when the other is
        carried); turns as in `GaitSummary`; halts between bouts.
    turn_s : float
        Spent on turns by at least 120 degrees; NaN without one.
    minutes_m : ndarray
        Distance within each minute begun, for what fatigue does.
    reasons : tuple of str
        What the sensors cannot tell, or why the test is not complete.
    """

    kind: GuidedKind
    start_s: float
    end_s: float
    distance_m: float
    distance_sigma_m: float
    step_count: int
    turn_count: int
    pause_count: int
    turn_s: float
    minutes_m: Float
    reasons: tuple[str, ...]

    @property
    def time_s(self) -> float:
        """From the first step to the last."""
        return self.end_s - self.start_s

    @property
    def speed_mps(self) -> float:
        """Distance over time, halts and turns included."""
        return self.distance_m / self.time_s if self.time_s > 0.0 else float("nan")


def guided_test(feet: Mapping[Side, Strides], kind: GuidedKind = "walk") -> GuidedTest | None:
    """Score a walking test.

    Parameters
    ----------
    kind : str
        A six-minute walk counts no more than six minutes from the first step.

    Returns
    -------
    GuidedTest or None
        None when nobody took a stride.

    Raises
    ------
    SetupError
        For an unknown kind.
    """
    if kind not in GUIDED_KINDS:
        raise SetupError(f"no walking test is named {kind!r}; known: {', '.join(GUIDED_KINDS)}")
    counted = {side: _counted(strides) for side, strides in feet.items()}
    carried = carried_foot(feet)
    walked = {side: strides for side, strides in feet.items() if counted[side].any()}
    if not walked:
        return None
    start_s = min(float(strides.toe_off_s[strides.is_inside][0]) for strides in walked.values())
    end_s = max(float(strides.contact_s[strides.is_inside][-1]) for strides in walked.values())
    reasons: list[str] = []
    if kind == "six_minute_walk":
        end_s = min(end_s, start_s + SIX_MINUTES_S)
        if end_s - start_s < _LEAST_OF_SIX * SIX_MINUTES_S:
            reasons.append(say("walk.not_six_minutes", walked_s=end_s - start_s))
    within = {side: (strides.contact_s <= end_s) & counted[side] for side, strides in walked.items()}
    measured, stated = _measured(walked, within, carried)
    ways = [float(strides.length_m[within[side]].sum()) for side, strides in measured.items()]
    variances = [
        float(np.square(strides.length_sigma_m[within[side]]).sum()) for side, strides in measured.items()
    ]
    counts = [int(np.count_nonzero(within[side])) for side in measured]
    if len(walked) == 1 and carried is None:
        reasons.append(say("walk.one_foot_steps"))
    if len(measured) == 1 and carried is None:
        counts *= 2
    reasons.extend(stated)
    found = [
        [turn for turn in turns(strides) if strides.contact_s[turn[0]] <= end_s]
        for strides in walked.values()
    ]
    most = max(range(len(found)), key=lambda k: len(found[k]))
    about = [
        float(strides.contact_s[stop - 1] - strides.toe_off_s[start])
        for strides in [list(walked.values())[most]]
        for start, stop, angle in found[most]
        if abs(angle) >= _ABOUT_TURN_RAD
    ]
    if kind == "timed_up_and_go":
        reasons.append(say("walk.no_chair"))
        if not about:
            reasons.append(say("walk.no_turn"))
    bouts = max(len(np.unique(strides.bout[within[side]])) - 1 for side, strides in walked.items())
    return GuidedTest(
        kind=kind,
        start_s=start_s,
        end_s=end_s,
        distance_m=float(np.mean(ways)),
        distance_sigma_m=float(np.sqrt(np.sum(variances))) / len(ways),
        step_count=sum(counts),
        turn_count=len(found[most]),
        pause_count=max(bouts, 0),
        turn_s=float(np.sum(about)) if about else float("nan"),
        minutes_m=_minutes(measured, start_s, end_s),
        reasons=tuple(reasons),
    )


def _counted(strides: Strides) -> NDArray[np.bool_]:
    """Return which strides are of the test, shape (n,)."""
    return np.asarray(strides.is_inside & ((strides.flags & StrideFlag.ALOFT) == 0))


def _measured(
    feet: Mapping[Side, Strides], within: Mapping[Side, NDArray[np.bool_]], carried: Side | None
) -> tuple[Mapping[Side, Strides], list[str]]:
    """Return the feet whose way is known, and what to say of the others."""
    if carried is not None:
        return {side: strides for side, strides in feet.items() if side != carried}, [
            say("walk.carried_way", side=carried)
        ]
    lost_s = {
        side: float(strides.missing_s[within[side] & ((strides.flags & StrideFlag.MISSING) != 0)].sum())
        for side, strides in feet.items()
    }
    whole = {side: strides for side, strides in feet.items() if lost_s[side] == 0.0}
    if len(whole) == len(feet):
        return _alike(feet, within)
    if whole:
        (other,) = set(feet) - set(whole)
        return whole, [say("walk.other_foot", side=other, missing_s=lost_s[other])]
    return feet, [say("walk.count_short", missing_s=max(lost_s.values()))]


def _alike(
    feet: Mapping[Side, Strides], within: Mapping[Side, NDArray[np.bool_]]
) -> tuple[Mapping[Side, Strides], list[str]]:
    """Return both feet where they went equally far, otherwise the one that went further: the other lost strides.

    Apart they may be by a stride, and on a turn by its angle times the distance between them.
    """
    if len(feet) < 2:
        return feet, []
    ways = {side: float(strides.length_m[within[side]].sum()) for side, strides in feet.items()}
    stride_m = max(float(strides.length_m[within[side]].max(initial=0.0)) for side, strides in feet.items())
    turned_rad = max(abs(float(strides.turn_rad[within[side]].sum())) for side, strides in feet.items())
    longer = max(ways, key=lambda side: ways[side])
    allowed_m = stride_m + _FEET_APART_M * turned_rad + _WAY_SHARE * ways[longer]
    if ways[longer] - min(ways.values()) <= allowed_m:
        return feet, []
    (shorter,) = set(feet) - {longer}
    reason = say("walk.ways_apart", side=shorter, way_m=ways[shorter], other_m=ways[longer])
    return {longer: feet[longer]}, [reason]


def _minutes(feet: Mapping[Side, Strides], start_s: float, end_s: float) -> Float:
    """Return the distance within each minute begun: every stride evenly over its swing."""
    edges = np.arange(start_s, end_s, 60.0)
    edges = np.append(edges, end_s)
    way = np.zeros(len(edges))
    for strides in feet.values():
        length_m = np.where(_counted(strides), strides.length_m, 0.0)
        gone = np.concatenate([[0.0], np.cumsum(length_m)])
        at = np.stack([strides.toe_off_s, strides.contact_s], axis=1).reshape(-1)
        way += np.interp(edges, at, np.stack([gone[:-1], gone[1:]], axis=1).reshape(-1))
    return np.diff(way) / len(feet)
