"""How a person performs an exercise: amplitude, speed, tremor, fatigue, compensation, spread."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError
from estimators.simulation.arm.exercises import (
    ACTING,
    ACTING_LEG,
    ARM_COORDINATES,
    COORDINATES,
    EXERCISES,
    LEG_COORDINATES,
    OTHER,
    OTHER_LEG,
    TRUNK,
    TRUNK_COORDINATES,
    UPPER_COORDINATES,
    Exercise,
    Stop,
    hanging,
)
from estimators.simulation.arm.timeline import Sinusoids, Timeline, submovements, sway

Float = NDArray[np.float64]


@dataclass(frozen=True)
class MovementStyle:
    """How a person performs an exercise; the defaults are a healthy adult.

    Attributes
    ----------
    amplitude : float
        Fraction of the way from rest to each stop that the arm makes.
    speed : float
        1 is the exercise's own timing.
    tremor_rad, tremor_hz : float
        Amplitude at elbow, forearm and shoulder, and frequency, once the arm has left the N-pose.
    fatigue_amplitude, fatigue_speed : float
        Fraction of amplitude and of speed that is lost between the first and the last repetition.
    trunk_lean_rad, trunk_lateral_rad, trunk_rotation_rad : float
        Compensation at the far end: forward lean, lean away from the acting arm, turn that brings its
        shoulder forward.
    shoulder_hike_rad : float
        Compensation: elevation of the clavicle of the acting arm.
    submovements : int
        Pieces of each transition; 1 is one smooth bell of speed.
    amplitude_sd, duration_sd, posture_sd_rad : float
        Spread between repetitions: relative, relative, absolute per coordinate.
    """

    amplitude: float = 1.0
    speed: float = 1.0
    tremor_rad: float = 0.0
    tremor_hz: float = 5.0
    fatigue_amplitude: float = 0.0
    fatigue_speed: float = 0.0
    trunk_lean_rad: float = 0.0
    trunk_lateral_rad: float = 0.0
    trunk_rotation_rad: float = 0.0
    shoulder_hike_rad: float = 0.0
    submovements: int = 1
    amplitude_sd: float = 0.02
    duration_sd: float = 0.04
    posture_sd_rad: float = np.radians(1.2)

    def __post_init__(self) -> None:
        if not (0.0 < self.amplitude <= 1.5 and 0.1 <= self.speed <= 5.0 and 1 <= self.submovements <= 8):
            raise SetupError(f"{self}: amplitude is 0 to 1.5, speed 0.1 to 5, submovements 1 to 8")
        if not (0.0 <= self.fatigue_amplitude < 1.0 and 0.0 <= self.fatigue_speed < 1.0):
            raise SetupError(f"{self}: fatigue is the fraction lost, 0 to below 1")


def style_of_impairment(level: float) -> MovementStyle:
    """Return a typical performance of a person after stroke.

    Parameters
    ----------
    level : float
        0 is healthy, 0.35 mild, 0.7 moderate, 1 severe.

    Returns
    -------
    MovementStyle
        Less range, slower and in more pieces, tremor, fatigue, more trunk and shoulder: the directions are
        those of Cirstea and Levin (2000), Brain 123:940; the sizes are the house's.
    """
    if not 0.0 <= level <= 1.0:
        raise SetupError(f"impairment level {level} is outside 0 to 1")
    healthy = MovementStyle()
    return replace(
        healthy,
        amplitude=1.0 - 0.55 * level,
        speed=1.0 - 0.6 * level,
        tremor_rad=np.radians(1.5) * level,
        fatigue_amplitude=0.2 * level,
        fatigue_speed=0.25 * level,
        trunk_lean_rad=np.radians(22) * level,
        trunk_lateral_rad=np.radians(10) * level,
        trunk_rotation_rad=np.radians(12) * level,
        shoulder_hike_rad=np.radians(14) * level,
        submovements=1 + round(4 * level),
        amplitude_sd=0.02 + 0.06 * level,
        duration_sd=0.04 + 0.12 * level,
        posture_sd_rad=np.radians(1.2 + 2.5 * level),
    )


@dataclass(frozen=True)
class PlannedRepetition:
    """What is particular about one repetition; the defaults are nothing.

    Attributes
    ----------
    size, pace : float
        Factors on the amplitude and the speed of the style.
    pause_s : float, optional
        Rest after it; the schedule's unless given.
    stop_share, stop_s : float
        Share of the way to the first stop at which somebody stays, and for how long; 0 s not at all.
    lean_rad, lateral_rad, hike_rad, plane_rad : float
        Faults at the far end: trunk forward and away from the acting arm, clavicle, plane of elevation.
    instead : str
        Another exercise whose stops are made instead: a wrong movement.
    """

    size: float = 1.0
    pace: float = 1.0
    pause_s: float | None = None
    stop_share: float = 0.5
    stop_s: float = 0.0
    lean_rad: float = 0.0
    lateral_rad: float = 0.0
    hike_rad: float = 0.0
    plane_rad: float = 0.0
    instead: str = ""

    def __post_init__(self) -> None:
        if self.instead and self.instead not in EXERCISES:
            raise SetupError(f"no exercise is named {self.instead!r}; known: {', '.join(EXERCISES)}")
        if not (0.05 <= self.size <= 1.5 and 0.1 <= self.pace <= 5.0 and 0.05 <= self.stop_share <= 0.95):
            raise SetupError(f"{self}: size is 0.05 to 1.5, pace 0.1 to 5, stop_share 0.05 to 0.95")

    def add_faults(self, posture: Float) -> None:
        """Add the faults to a reached posture, in place."""
        posture[0] += self.lean_rad
        posture[1] -= self.lateral_rad
        posture[ACTING][ARM_COORDINATES.index("hike")] += self.hike_rad
        posture[ACTING][ARM_COORDINATES.index("plane")] += self.plane_rad


@dataclass(frozen=True)
class Performance:
    """A whole performed exercise.

    Attributes
    ----------
    timeline : Timeline
        Columns are `COORDINATES`.
    repetitions_s : ndarray, shape (R, 2)
        From leaving the rest posture to being back in it.
    place : ndarray, shape (M,)
        How far in the cycle at each knot of the timeline, in pieces: moves and holds of the exercise by turns, the
        return last. NaN outside repetitions and in those that are another movement.
    """

    timeline: Timeline
    repetitions_s: Float
    end_s: float
    place: Float

    def progress(self, time_s: Float) -> Float:
        """Return how far in the cycle at any times, shape (N,): of moves the share of the way, of holds of the time."""
        line = self.timeline
        index = np.clip(np.searchsorted(line.knot_s, time_s, side="right") - 1, 0, len(line.knot_s) - 2)
        share = (time_s - line.knot_s[index]) / np.diff(line.knot_s)[index]
        first, last = self.place[index], self.place[index + 1]
        is_hold = np.floor(first) % 2 == 1
        way = submovements(share, line.submovement_count[index]).value
        found = first + (last - first) * np.where(is_hold, share, way)
        # From the end of one repetition to the beginning of the next is a rest.
        return np.asarray(np.where(last >= first, found, np.nan))


@dataclass(frozen=True)
class Schedule:
    """When things happen: N-pose, a short transition to the rest posture, repetitions with pauses.

    Either `repetitions` is given, or `duration_s`, into which as many as fit are put.
    """

    n_pose_s: float = 10.0
    transition_s: float = 1.5
    pause_s: float = 1.5
    repetitions: int | None = 5
    duration_s: float | None = None
    settle_s: float = 1.0
    """Rest before the first and after the last repetition, beside the pause."""
    plan: tuple[PlannedRepetition, ...] = ()
    """Each repetition by itself, on top of the style; then `repetitions` is None and they are as many."""


@dataclass
class _Score:
    """Postures reached one after the other: when, by how many submovements, and where in its repetition each is."""

    knots: list[float]
    postures: list[Float]
    counts: list[int]
    places: list[float]

    def go(self, posture: Float, seconds: float, pieces: int = 1, place: float = np.nan) -> None:
        self.knots.append(self.knots[-1] + max(seconds, 1e-3))
        self.postures.append(posture)
        self.counts.append(pieces)
        self.places.append(place)

    def reach(
        self,
        reached: Float,
        stop: Stop,
        piece: int,
        pace: float,
        pieces: int,
        one: PlannedRepetition,
        of_other: float,
    ) -> None:
        """Move to a stop, with the pause that is planned on the way to the first, and hold it."""
        left_s = stop.move_s / pace
        if piece == 0 and one.stop_s > 0.0:
            half = self.postures[-1] + one.stop_share * (reached - self.postures[-1])
            self.go(half, one.stop_share * left_s, pieces, one.stop_share + of_other)
            self.go(half, one.stop_s, 1, one.stop_share + of_other)
            left_s *= 1.0 - one.stop_share
        self.go(reached, left_s, pieces, 2.0 * piece + 1.0 + of_other)
        self.go(reached, stop.hold_s, 1, 2.0 * piece + 2.0 + of_other)


def _planned(exercise: Exercise, style: MovementStyle, schedule: Schedule, begun_s: float) -> int:
    """Return how many repetitions there are to be."""
    if schedule.duration_s is None:
        planned = len(schedule.plan) or int(schedule.repetitions or 0)
    else:
        expected = sum(stop.move_s / style.speed + stop.hold_s for stop in exercise.stops)
        expected += exercise.return_s / style.speed + schedule.pause_s
        planned = int((schedule.duration_s - begun_s - schedule.settle_s) / expected)
    if planned < 1:
        raise SetupError(f"no repetition fits: {schedule}")
    return planned


def _reached(
    stop: Stop,
    rest: Float,
    amplitude: float,
    draw: Float,
    leg_draw: Float,
    style: MovementStyle,
    one: PlannedRepetition,
    both_arms: bool,
) -> Float:
    """Return the posture that is reached where a stop is meant, with the style and the faults of the repetition."""
    target = _posture(stop.posture_deg, both_arms)
    reached = rest + amplitude * (target - rest)
    reached[ACTING] += draw[3:]
    reached[TRUNK] += 0.3 * draw[:3]
    reached[ACTING_LEG] += leg_draw
    reached[OTHER_LEG] = rest[OTHER_LEG]
    _compensate(reached, style)
    one.add_faults(reached)
    reached[OTHER] = reached[ACTING] if both_arms else reached[OTHER]
    return reached


def perform(
    exercise: Exercise,
    style: MovementStyle,
    schedule: Schedule,
    *,
    both_arms: bool,
    sway_rad: float,
    n_pose_error_rad: float,
    seed: int,
) -> Performance:
    """Lay an exercise out in time.

    Parameters
    ----------
    both_arms : bool
        The other arm mirrors the acting one instead of hanging.
    sway_rad : float
        RMS of the slow wander of every coordinate, also during the N-pose.
    n_pose_error_rad : float
        Standard deviation of how far each coordinate is off the exact N-pose.

    Raises
    ------
    SetupError
        If not just one of repetitions, duration and plan is given, or nothing fits the duration.
    """
    given = (schedule.repetitions is not None, schedule.duration_s is not None, bool(schedule.plan))
    if sum(given) != 1:
        raise SetupError("give just one of repetitions, duration_s and plan")
    rng, leg_rng = np.random.default_rng([seed, 1]), np.random.default_rng([seed, 6])
    rest = _posture(exercise.rest_deg, both_arms)
    n_pose = _n_pose(exercise, both_arms)
    n_pose = n_pose + np.random.default_rng([seed, 2]).normal(0.0, 1.0, n_pose.size) * n_pose_error_rad
    laid = _Score([0.0, schedule.n_pose_s], [n_pose, n_pose], [1], [np.nan, np.nan])
    laid.go(rest, schedule.transition_s)
    laid.go(rest, schedule.settle_s + schedule.pause_s)
    planned = _planned(exercise, style, schedule, laid.knots[-1])
    intervals, stop_at = [], np.inf if schedule.duration_s is None else schedule.duration_s - 0.5
    for number in range(planned):
        worn_out = number / max(planned - 1, 1)
        amplitude = style.amplitude * (1.0 - style.fatigue_amplitude * worn_out)
        amplitude *= 1.0 + style.amplitude_sd * rng.normal()
        pace = style.speed * (1.0 - style.fatigue_speed * worn_out) * np.exp(style.duration_sd * rng.normal())
        draws = rng.normal(size=(len(exercise.stops) + 1, 13)) * style.posture_sd_rad
        leg_draws = np.zeros((len(draws), len(LEG_COORDINATES)))
        if exercise.moves_leg:
            leg_draws = leg_rng.normal(size=leg_draws.shape) * style.posture_sd_rad
        one = schedule.plan[number] if schedule.plan else PlannedRepetition()
        amplitude, pace = amplitude * one.size, pace * one.pace
        stops = EXERCISES[one.instead].stops if one.instead else exercise.stops
        needed = sum(stop.move_s / pace + stop.hold_s for stop in stops) + exercise.return_s / pace
        if laid.knots[-1] + needed > stop_at:
            break
        start = laid.knots[-1]
        laid.places[-1] = of_other = np.nan if one.instead else 0.0
        for piece, stop in enumerate(stops):
            drawn = min(piece, len(draws) - 2)
            reached = _reached(stop, rest, amplitude, draws[drawn], leg_draws[drawn], style, one, both_arms)
            laid.reach(reached, stop, piece, pace, style.submovements, one, of_other)
        back = rest.copy()
        back[ACTING] += 0.3 * draws[-1, 3:]
        back[ACTING_LEG] += 0.3 * leg_draws[-1]
        back[OTHER] = back[ACTING] if both_arms else back[OTHER]
        laid.go(back, exercise.return_s / pace, style.submovements, 2.0 * len(stops) + 1.0 + of_other)
        intervals.append((start, laid.knots[-1]))
        laid.go(back, schedule.pause_s if one.pause_s is None else one.pause_s)
    laid.go(laid.postures[-1], schedule.settle_s)
    end_s = laid.knots[-1] if schedule.duration_s is None else schedule.duration_s
    # Legs sway as segments, see `MovingBody`.
    upper = tuple(range(len(UPPER_COORDINATES)))
    wander = [sway(upper, sway_rad, np.random.default_rng([seed, 3]))]
    if style.tremor_rad > 0.0:
        wander.append(_tremor(style, schedule.n_pose_s, both_arms, np.random.default_rng([seed, 4])))
    counts = np.array(laid.counts, dtype=np.int64)
    timeline = Timeline(np.array(laid.knots), np.array(laid.postures), counts, tuple(wander))
    return Performance(timeline, np.array(intervals).reshape(-1, 2), end_s, np.array(laid.places))


def _posture(named_deg: Mapping[str, float], both_arms: bool) -> Float:
    trunk = [named_deg.get(name, 0.0) for name in TRUNK_COORDINATES]
    acting = [named_deg.get(name, 0.0) for name in ARM_COORDINATES]
    relaxed = hanging(30.0) | {"elevation": 9}
    other = acting if both_arms else [relaxed.get(name, 0.0) for name in ARM_COORDINATES]
    leg = [named_deg.get(name, 0.0) for name in LEG_COORDINATES]
    return np.radians(np.array([*trunk, *acting, *other, *leg, *leg], dtype=np.float64))


def _n_pose(exercise: Exercise, both_arms: bool) -> Float:
    """Upper arms exactly vertical, with the plane of elevation of the coming rest posture."""
    posture = np.zeros(len(COORDINATES))
    rest = _posture(exercise.rest_deg, both_arms)
    plane, axial = ARM_COORDINATES.index("plane"), ARM_COORDINATES.index("axial")
    for arm in (ACTING, OTHER):
        posture[arm][plane] = rest[arm][plane]
        posture[arm][axial] = -rest[arm][plane]
        posture[arm][ARM_COORDINATES.index("pronation")] = 0.5 * np.pi
    return posture


def _compensate(posture: Float, style: MovementStyle) -> None:
    posture[0] += style.trunk_lean_rad
    posture[1] -= style.trunk_lateral_rad
    posture[2] += style.trunk_rotation_rad
    posture[ACTING][ARM_COORDINATES.index("hike")] += style.shoulder_hike_rad


def _tremor(style: MovementStyle, start_s: float, both_arms: bool, rng: np.random.Generator) -> Sinusoids:
    names = ("elevation", "axial", "flexion", "pronation")
    share = np.array([0.4, 0.6, 0.7, 1.0])
    columns = [COORDINATES.index(f"acting_{name}") for name in names]
    phase = rng.uniform(0.0, 2.0 * np.pi, (len(names), 2))
    amplitude = style.tremor_rad * share[:, None] * np.array([0.7, 0.3])
    # Two close frequencies beat, as real tremor waxes and wanes.
    frequency = np.broadcast_to(style.tremor_hz * np.array([1.0, 1.13]), phase.shape)
    if both_arms:
        columns += [COORDINATES.index(f"other_{name}") for name in names]
        amplitude, phase, frequency = (np.concatenate((x, x)) for x in (amplitude, phase, frequency))
    return Sinusoids(tuple(columns), amplitude, frequency, phase, fade_start_s=start_s)
