"""Sets of any exercise with the bounds of every repetition known: what a repetition finder is judged on.

What a repetition is was laid down here before any finder was run on it:

- Home is the posture in which the set rests between repetitions, or rests before the first or after the last.
- A repetition leaves home, goes through all of the movement (at least 80 % of its usual size) and is home again. It
  begins when the posture leaves home and ends when it has come back; rest at home belongs to none, a hold inside does.
- A partial try turns round before 60 % of the usual size and goes home the way it came. It is no repetition.
- A movement whose beginning or end the recording does not show is no repetition: such a recording begins or ends in a
  posture at least 0.4 sizes from home.
- Where a recording shows no home (no rest at either end, and none between or holds that last as long), any phase of the
  cycle may stand for home: `phase` gives the bounds for each, and as many repetitions count as whole cycles are shown.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.ndimage import gaussian_filter1d

from estimators.recording import Float
from estimators.simulation.arm.repeated_shapes import POINTS, SHAPES, Random, Shape

_BODIES: Final[dict[str, tuple[str, ...]]] = {
    "arm": (
        "thorax_humerus_right_yxy_elevation",
        "humerus_forearm_right_zxy_flexion",
        "humerus_forearm_right_zxy_pronation",
        "forearm_hand_right_zxy_flexion",
        "wrist_right.x",
        "wrist_right.y",
        "wrist_right.z",
    ),
    "leg": (
        "pelvis_thigh_right_zxy_flexion",
        "thigh_shank_right_zxy_flexion",
        "shank_foot_right_zxy_flexion",
        "pelvis_thigh_right_zxy_abduction",
        "foot_right.x",
        "foot_right.z",
    ),
    "trunk": (
        "trunk_lean_forward_rad",
        "trunk_lean_lateral_rad",
        "trunk_axial_rotation_rad",
        "pelvis.x",
        "pelvis.y",
        "pelvis.z",
    ),
    "hand": (
        "wrist_right.x",
        "wrist_right.y",
        "wrist_right.z",
        "hand_right.x",
        "hand_right.y",
        "hand_right.z",
    ),
}
_SHOULDER: Final = ("shoulder_right.x", "shoulder_right.y", "shoulder_right.z")
_CUT_AWAY: Final = 0.4
_SHOWN_REST_S: Final = 0.3
_LONGEST_S: Final = 150.0


@dataclass(frozen=True)
class RepeatedMovement:
    """One set and the truth about it.

    Attributes
    ----------
    family : str
        Key of the shapes.
    time_s : ndarray, shape (N,)
    channels : tuple of str
        As in `estimators.comparison.Trajectory`: those that take part and idle ones.
    values : ndarray, shape (N, C)
        rad and m.
    cycles_s, partial_s : ndarray, shape (K, 2)
        Half-open bounds of the repetitions and of the partial tries.
    phase : ndarray, shape (N,)
        Cycles done so far, of which one may have begun before the recording: never decreases.
    has_home : bool
        Whether the recording shows where a repetition begins.
    """

    family: str
    time_s: Float
    channels: tuple[str, ...]
    values: Float
    cycles_s: Float
    partial_s: Float
    phase: Float
    has_home: bool


@dataclass(frozen=True)
class _Habits:
    """How this person does this set."""

    pace: float
    pause_s: tuple[float, float]
    hold_s: tuple[float, float]
    hold_share: float
    lead_s: float
    trail_s: float
    begins_inside: bool
    ends_inside: bool


@dataclass
class _Course:
    """Offsets from home, phase and kind (0 rest, 1 cycle, 2 partial), joined sample by sample."""

    step_s: float
    pieces: list[Float]
    phases: list[Float]
    bounds: list[tuple[int, int, int]]
    samples: int = 0
    done: float = 0.0

    def add(self, offset: Float, kind: int, phase: Float | None = None) -> None:
        """Append a piece; of a cycle its phase from 0 to 1."""
        count = len(offset)
        self.pieces.append(offset)
        self.phases.append(self.done + (np.zeros(count) if phase is None else phase))
        if kind:
            self.bounds.append((self.samples, self.samples + count, kind))
        self.samples += count
        self.done += kind == 1

    def rest(self, duration_s: float, dimensions: int) -> None:
        """Stay at home."""
        self.add(np.zeros((round(duration_s / self.step_s), dimensions)), 0)


def simulate_repetitions(seed: int, family: str) -> RepeatedMovement:
    """Make one set of one family of movements.

    Parameters
    ----------
    family : str
        Key of the shapes: stops, spline, jump, orbit, swing or effort.

    Returns
    -------
    RepeatedMovement
        Three to fifteen repetitions at 0.3 to 3 times the shape's own pace, in one or several channels of an arm, a
        leg, the trunk or the path of the hand; with pauses or none, holds, partial tries, tremor of 4 to 8 Hz, drift,
        getting ready, and recordings that begin or end inside a movement.
    """
    random = np.random.default_rng([seed, *family.encode()])
    shape = SHAPES[family](random)
    habits = _habits(shape, random)
    course = _course(shape, habits, 1.0 / float(random.choice([50.0, 60.0, 100.0])), random)
    offset, phase = np.concatenate(course.pieces), np.concatenate(course.phases)
    # A body has mass: it neither starts nor turns at once.
    inertia_s = 0.02 * shape.duration_s / habits.pace
    offset = gaussian_filter1d(offset, inertia_s / course.step_s, axis=0, mode="nearest")
    first, last = _shown(offset, course, habits, random)
    offset = offset[first:last]
    time_s: Float = np.arange(len(offset), dtype=np.float64) * course.step_s
    bounds = [(a - first, b - first, kind) for a, b, kind in course.bounds if a >= first and b <= last]
    shown = [habits.lead_s * (not habits.begins_inside), habits.trail_s * (not habits.ends_inside)]
    between_s = 0.0 if habits.hold_share else habits.pause_s[0]
    channels, values = _worn(offset, time_s, random)
    return RepeatedMovement(
        family=family,
        time_s=time_s,
        channels=channels,
        values=values,
        cycles_s=np.array([(a, b) for a, b, kind in bounds if kind == 1]).reshape(-1, 2) * course.step_s,
        partial_s=np.array([(a, b) for a, b, kind in bounds if kind == 2]).reshape(-1, 2) * course.step_s,
        phase=phase[first:last] - phase[first],
        has_home=max(*shown, between_s) >= _SHOWN_REST_S,
    )


def _habits(shape: Shape, random: Random) -> _Habits:
    low, high = shape.pace
    pauses = ((0.0, 0.0), (0.1, 0.5), (0.5, 3.0))[int(random.choice(3, p=(0.35, 0.25, 0.4)))]
    holds = random.random() < 0.4 and len(shape.holds) > 0
    return _Habits(
        pace=float(np.exp(random.uniform(np.log(low), np.log(high)))),
        pause_s=pauses,
        hold_s=(0.3, float(random.uniform(0.5, 2.5))),
        hold_share=float(random.uniform(0.5, 1.0)) if holds else 0.0,
        lead_s=float(random.uniform(0.5, 4.0)),
        trail_s=float(random.uniform(0.5, 4.0)),
        begins_inside=bool(random.random() < 0.25),
        ends_inside=bool(random.random() < 0.25),
    )


def _course(shape: Shape, habits: _Habits, step_s: float, random: Random) -> _Course:
    """Play the set through: cycles, pauses, partial tries, from one rest to the other."""
    longest = int(_LONGEST_S * habits.pace / (shape.duration_s + habits.pace * (habits.pause_s[1] + 1.0)))
    count = int(random.integers(3, max(4, min(16, longest + 1))))
    inside = habits.begins_inside + habits.ends_inside
    # A partial try is one from home: where no home is shown, there is none.
    shows_home = inside < 2 or (habits.pause_s[0] >= _SHOWN_REST_S and not habits.hold_share)
    partials = int(random.integers(1, 4)) if random.random() < 0.4 and shows_home else 0
    kinds = np.array([1] * count + [2] * min(partials, count // 2))
    random.shuffle(kinds)
    if inside:
        kinds = np.concatenate([[1] * habits.begins_inside, kinds, [1] * habits.ends_inside]).astype(int)
    tiring = random.uniform(-0.15, 0.05)
    quicker = random.uniform(-0.3, 0.3)
    course = _Course(step_s, [], [], [])
    if random.random() < 0.25 and not habits.begins_inside:
        _get_ready(course, shape, random)
    course.rest(habits.lead_s, shape.dimensions)
    for number, kind in enumerate(kinds):
        share = number / len(kinds)
        pace = habits.pace * (1 + quicker * share) * float(np.clip(np.exp(random.normal(0, 0.1)), 0.75, 1.33))
        size = float(np.clip((1 + tiring * share) * (1 + random.normal(0, 0.05)), 0.82, 1.2))
        if kind == 1:
            course.add(*_cycle(shape, habits, pace, size, step_s, random))
        else:
            course.add(_partial(shape, pace, step_s, random), 2)
        if number < len(kinds) - 1:
            course.rest(random.uniform(*habits.pause_s), shape.dimensions)
    course.rest(habits.trail_s, shape.dimensions)
    return course


def _get_ready(course: _Course, shape: Shape, random: Random) -> None:
    """Come home from some other posture, once."""
    away = random.normal(size=shape.dimensions)
    away *= random.uniform(0.5, 1.5) / np.linalg.norm(away)
    share = np.arange(0.0, 1.0, course.step_s / random.uniform(1.0, 2.5))[:, None]
    course.add((1.0 - share**3 * (10 - 15 * share + 6 * share**2)) * away, 0)


def _cycle(
    shape: Shape, habits: _Habits, pace: float, size: float, step_s: float, random: Random
) -> tuple[Float, int, Float]:
    """Return one cycle with its own pace, size, small deviations and holds."""
    moving = np.arange(0.0, 1.0, step_s * pace / shape.duration_s)
    phase = moving
    for place in shape.holds:
        if random.random() < habits.hold_share:
            held = round(random.uniform(*habits.hold_s) / step_s)
            phase = np.insert(phase, np.searchsorted(phase, place), np.full(held, place))
    waves = random.normal(0.0, 0.02, (3, shape.dimensions))
    stray = np.sin(np.pi * np.outer(phase, (1, 2, 3))) @ waves
    grid = np.linspace(0.0, 1.0, POINTS)
    offset = np.stack([np.interp(phase, grid, column) for column in shape.offset.T], axis=1)
    return size * offset + stray, 1, phase


def _partial(shape: Shape, pace: float, step_s: float, random: Random) -> Float:
    """Return a try that turns round early and goes home the way it came."""
    away = np.linalg.norm(shape.offset, axis=1)
    turn = int(np.flatnonzero(away > random.uniform(0.25, 0.6))[0])
    duration_s = max(2.0 * turn / POINTS * shape.duration_s / pace, 0.3)
    share = np.arange(0.0, 1.0, step_s / duration_s)
    place = turn * (1.0 - np.abs(2.0 * share - 1.0))
    # Turning round takes time: the corner is rounded over a tenth of the try.
    place = gaussian_filter1d(place, max(0.05 * len(share), 1.0), mode="nearest")
    place -= np.linspace(place[0], place[-1], len(place))
    return np.stack([np.interp(place, np.arange(POINTS), column) for column in shape.offset.T], axis=1)


def _shown(offset: Float, course: _Course, habits: _Habits, random: Random) -> tuple[int, int]:
    """Cut into the first or the last cycle, far from home, where the recording begins or ends inside."""
    away = np.linalg.norm(offset, axis=1)

    def cut(start: int, end: int) -> int:
        far = start + np.flatnonzero(away[start:end] > _CUT_AWAY)
        return int(random.choice(far))

    first = cut(*course.bounds[0][:2]) if habits.begins_inside else 0
    last = cut(*course.bounds[-1][:2]) if habits.ends_inside else course.samples
    return first, last


def _worn(offset: Float, time_s: Float, random: Random) -> tuple[tuple[str, ...], Float]:
    """Give the coordinates to channels of a body part, add idle channels, tremor, drift and noise."""
    channels = _BODIES[str(random.choice(list(_BODIES)))]
    taking_part = random.permutation(len(channels))[: offset.shape[1]]
    unit = np.array([random.uniform(0.12, 0.5) if "." in name else 1.0 for name in channels])
    # One scale for all angles and one for the path: coordinates are shares of one movement.
    unit = np.where(["." in name for name in channels], unit.min(), random.uniform(0.3, 1.5))
    values = np.zeros((len(time_s), len(channels)))
    values[:, taking_part] = offset
    if random.random() < 0.5:
        pitch = random.uniform(4.0, 8.0) * (
            1.0 + 0.05 * gaussian_filter1d(random.normal(size=len(time_s)), 50)
        )
        shake = np.sin(2.0 * np.pi * np.cumsum(pitch) * (time_s[1] - time_s[0]))
        sway = 1.0 + 0.5 * np.sin(2.0 * np.pi * random.uniform(0.05, 0.3) * time_s)
        values += random.uniform(0.005, 0.04) * np.outer(shake * sway, random.normal(size=len(channels)))
    if random.random() < 0.5:
        values += np.outer(time_s / time_s[-1], random.uniform(-0.25, 0.25, len(channels)))
    values += random.normal(0.0, 0.004, values.shape)
    values = random.uniform(-0.5, 0.5, len(channels)) + unit * values
    if "wrist_right.x" not in channels:
        return channels, values
    # Points of the arm are read relative to its shoulder.
    return (*channels, *_SHOULDER), np.column_stack([values, np.zeros((len(time_s), 3))])
