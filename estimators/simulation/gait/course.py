"""Where and when the feet are put: a course of straight legs, turns, stairs and halts to footholds in time."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import SIDES, Side
from estimators.errors import SetupError

Float = NDArray[np.float64]

DOUBLE_SUPPORT_PER_STRIDE = 0.12
SHIFT_S = 0.6
"""How long the weight takes to go onto one leg at a start, and back onto both at a stop."""


@dataclass(frozen=True)
class Leg:
    """Consecutive steps of one kind.

    Attributes
    ----------
    turn_rad : float
        Over all of them together, counter-clockwise positive.
    rise_m : float
        Of every step: a stair up, or down when negative.
    length_scale : float
        Of the step length, for short steps in a turn or on stairs.
    """

    steps: int
    turn_rad: float = 0.0
    rise_m: float = 0.0
    length_scale: float = 1.0


@dataclass(frozen=True)
class Bout:
    """Walking from standing to standing.

    Attributes
    ----------
    legs : tuple of Leg
        The first step of a bout is half as long, the last one brings the feet level.
    """

    legs: tuple[Leg, ...]
    stand_after_s: float = 4.0


@dataclass(frozen=True)
class FootStyle:
    """How one leg walks; defaults are a healthy one.

    Attributes
    ----------
    pitch_scale : float
        Of the pitch at toe-off and early swing; below one for weak push-off, 0.3 for shuffling.
    landing_pitch_rad : float
        Of the foot at landing, toe down positive: a heel strike is negative, a drop foot lands toe first.
    clearance_m : float
        How far the middle of the swing is raised.
    circumduction_m : float
        How far the middle of the swing leads outward.
    length_scale, step_time_scale : float
        Of this leg's steps, in length and in duration.
    """

    pitch_scale: float = 1.0
    landing_pitch_rad: float = float(np.radians(-19.0))
    toe_out_rad: float = float(np.radians(6.0))
    toe_out_sd_rad: float = float(np.radians(1.5))
    clearance_m: float = 0.045
    circumduction_m: float = 0.02
    length_scale: float = 1.0
    step_time_scale: float = 1.0


def _healthy() -> dict[Side, FootStyle]:
    return {"left": FootStyle(), "right": FootStyle()}


@dataclass(frozen=True)
class WalkStyle:
    """How somebody walks.

    Attributes
    ----------
    stride_length_sd_m, lateral_sd_m : float
        Of the strides; of each foothold sideways.
    standing_left_share : float
        Of the weight on the left foot while standing.
    """

    stride_time_s: float = 1.15
    stride_length_m: float = 1.25
    step_width_m: float = 0.10
    stride_length_sd_m: float = 0.02
    lateral_sd_m: float = 0.01
    stride_time_sd_s: float = 0.0
    standing_left_share: float = 0.5
    feet: dict[Side, FootStyle] = field(default_factory=_healthy)

    def mirrored(self) -> "WalkStyle":
        """Return the same walk with the legs changed."""
        return replace(
            self,
            standing_left_share=1.0 - self.standing_left_share,
            feet={"left": self.feet["right"], "right": self.feet["left"]},
        )


@dataclass(frozen=True)
class Stance:
    """One foot on the ground, from landing to lift.

    Attributes
    ----------
    land_s, lift_s : float
        Minus and plus infinity for the first and the last of a recording.
    position_m : ndarray, shape (3,)
        The heel sensor while the foot is flat, less its height: a point of the floor, room frame.
    rests_from_s, rests_to_s : float
        Standing with weight on both feet; empty when `rests_to_s <= rests_from_s`.
    path_heading_rad : float
        Where the body goes at landing.
    """

    land_s: float
    lift_s: float
    position_m: Float
    yaw_rad: float
    landing_pitch_rad: float
    rests_from_s: float
    rests_to_s: float
    path_heading_rad: float


@dataclass(frozen=True)
class Footing:
    """The whole plan.

    Attributes
    ----------
    steps : list of (Side, land_s, heading_rad, floor_m)
        In order of landing; heading of the path and mean height of both feet's floors then.
    shifts : list of (start_s, end_s, share change of the left foot)
    active_s : list of (start_s, end_s)
        From the first lift to the last landing of each bout.
    """

    stances: dict[Side, list[Stance]]
    steps: list[tuple[Side, float, float, float]]
    shifts: list[tuple[float, float, float]]
    active_s: list[tuple[float, float]]
    end_s: float
    standing_left_share: float = 0.5


def other(side: Side) -> Side:
    """Return the other side."""
    return "left" if side == "right" else "right"


def plan(
    style: WalkStyle, course: tuple[Bout, ...], first_foot: Side, stand_before_s: float, seed: int
) -> Footing:
    """Lay out footholds and times of a course.

    Parameters
    ----------
    first_foot : Side
        Of every bout.
    seed : int
        Draws are in the order of steps, sideways counted outward: a mirrored walk has the mirrored draws.

    Raises
    ------
    SetupError
        For a course without steps or a time that is too short to shift the weight in.
    """
    if not course or any(sum(leg.steps for leg in bout.legs) < 2 for bout in course):
        raise SetupError("every bout of a course needs at least two steps")
    shortest = min([stand_before_s] + [bout.stand_after_s for bout in course])
    if shortest < 2.0 * SHIFT_S:
        raise SetupError(f"standing for {shortest} s is too short; shifting the weight takes {2 * SHIFT_S} s")
    rng = np.random.default_rng([seed, 21])
    walker = _Walker(style, rng, stand_before_s)
    for bout in course:
        walker.walk(bout, first_foot)
    return walker.finish()


class _Walker:
    def __init__(self, style: WalkStyle, rng: np.random.Generator, stand_before_s: float) -> None:
        self._style, self._rng = style, rng
        self._at_s = stand_before_s
        self._centre = np.zeros(2)
        self._heading = 0.0
        self._floor: dict[Side, float] = {"left": 0.0, "right": 0.0}
        self._stances: dict[Side, list[Stance]] = {"left": [], "right": []}
        self._steps: list[tuple[Side, float, float, float]] = []
        self._shifts: list[tuple[float, float, float]] = []
        self._active: list[tuple[float, float]] = []
        self._open: dict[Side, Stance] = {
            side: self._stance(side, -np.inf, 0.0, 0.0, 0.0, -np.inf, -np.inf) for side in SIDES
        }

    def _stance(
        self, side: Side, land_s: float, outward: float, rise: float, yaw: float, rest: float, rest_to: float
    ) -> Stance:
        foot = self._style.feet[side]
        sign = 1.0 if side == "left" else -1.0
        normal = np.array([-np.sin(self._heading), np.cos(self._heading)])
        position = self._centre + sign * (0.5 * self._style.step_width_m + outward) * normal
        # On stairs the foot is put down nearly flat.
        landing = foot.landing_pitch_rad * (0.2 if rise else 1.0)
        return Stance(
            land_s,
            np.inf,
            np.array([*position, self._floor[side]]),
            self._heading + sign * (foot.toe_out_rad + yaw),
            landing,
            rest,
            rest_to,
            self._heading,
        )

    def _lift(self, side: Side, at_s: float, rests_to_s: float | None = None) -> None:
        stance = self._open.pop(side)
        rests_to = stance.rests_to_s if rests_to_s is None else rests_to_s
        self._stances[side].append(replace(stance, lift_s=at_s, rests_to_s=rests_to))

    def walk(self, bout: Bout, first: Side) -> None:
        style, rng = self._style, self._rng
        double_s = DOUBLE_SUPPORT_PER_STRIDE * style.stride_time_s
        each = [leg for leg in bout.legs for _ in range(leg.steps)]
        side, count = first, len(each)
        started_s = self._at_s
        lift_s = started_s + SHIFT_S
        for side_ in SIDES:
            # Both feet rest until the weight begins to shift.
            self._open[side_] = replace(self._open[side_], rests_to_s=started_s)
        sign = {"left": 1.0, "right": -1.0}
        rest_share = style.standing_left_share
        all_of_it = {"left": 1.0, "right": 0.0}
        self._shifts.append((started_s, lift_s, all_of_it[other(first)] - rest_share))
        self._active.append((lift_s, lift_s))
        previous_land = lift_s - double_s
        for number, leg in enumerate(each):
            is_first, is_last = number == 0, number == count - 1
            foot = style.feet[side]
            self._lift(side, lift_s)
            noise = rng.normal(size=4)
            duration = 0.5 * style.stride_time_s * foot.step_time_scale
            duration += 0.5 * style.stride_time_sd_s * float(np.clip(noise[3], -2.5, 2.5))
            land_s = previous_land + max(duration, 2.5 * double_s)
            length = 0.0 if is_last else 0.5 * style.stride_length_m * foot.length_scale * leg.length_scale
            along = outward = 0.0
            if is_first:
                length *= 0.5
            elif number < count - 2:
                # The last foothold of each foot is exact, so that both end as far apart as they began.
                along, outward = 0.5 * style.stride_length_sd_m * noise[0], style.lateral_sd_m * noise[1]
            turn = 0.0 if is_last else leg.turn_rad / leg.steps
            half = self._heading + 0.5 * turn
            self._centre = self._centre + length * np.array([np.cos(half), np.sin(half)])
            self._heading += turn
            rise = 0.0 if is_last else leg.rise_m
            self._floor[side] = self._floor[other(side)] + rise
            stance = self._stance(
                side, land_s, outward, rise, foot.toe_out_sd_rad * noise[2], np.inf, -np.inf
            )
            forward = np.array([np.cos(self._heading), np.sin(self._heading), 0.0])
            self._open[side] = replace(stance, position_m=stance.position_m + along * forward)
            floor = 0.5 * (self._floor["left"] + self._floor["right"])
            self._steps.append((side, land_s, self._heading, floor))
            if is_last:
                self._shifts.append((land_s, land_s + SHIFT_S, rest_share - all_of_it[other(side)]))
                self._active[-1] = (self._active[-1][0], land_s)
                for side_ in SIDES:
                    self._open[side_] = replace(self._open[side_], rests_from_s=land_s + SHIFT_S)
                self._at_s = land_s + SHIFT_S + bout.stand_after_s
            else:
                lift_s = land_s + double_s
                self._shifts.append((land_s, lift_s, sign[side]))
            previous_land = land_s
            side = other(side)

    def finish(self) -> Footing:
        for side in SIDES:
            self._lift(side, np.inf, np.inf)
        share = self._style.standing_left_share
        return Footing(self._stances, self._steps, self._shifts, self._active, self._at_s, share)
