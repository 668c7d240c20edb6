"""Sessions of exercise with the truth of every repetition, through the whole chain, and a guide that follows them."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Final

import numpy as np

from estimators.comparison import Repetition, build_template, trajectory
from estimators.conventions import Placement
from estimators.guidance import GuidanceChunk, GuidanceTemplate, prepare_template, signals
from estimators.pipelines import Frames, run
from estimators.recording import Float
from estimators.simulation import (
    EXERCISES,
    ArmScenario,
    ExerciseName,
    MovementStyle,
    PlannedRepetition,
    Schedule,
    SimulatedSession,
    demonstration_scenario,
    simulate_arm,
    style_of_impairment,
)

NAMES: Final[tuple[ExerciseName, ...]] = ("abduction", "drinking", "flexion", "pronation", "reaching")
PLACEMENTS: Final[tuple[Placement, ...]] = ("sternum", "shoulder_right", "upper_arm_right", "forearm_right")
REACH_M: Final = 0.55
STEP_S: Final = 0.01
N_POSE_S, TRANSITION_S = 5.0, 1.5
_FIRST: Final = round((N_POSE_S + TRANSITION_S + 0.2) / STEP_S)
"""Tick at which the patient rests in the start posture."""
_REPETITIONS: Final = 6
_OTHER: Final = {
    "reaching": "abduction",
    "drinking": "abduction",
    "abduction": "reaching",
    "flexion": "reaching",
    "pronation": "reaching",
}
"""What a wrong repetition does instead."""
STYLES: Final = {
    "pauses": MovementStyle(tremor_rad=float(np.radians(1.0))),
    "no rest": MovementStyle(),
    "mild": style_of_impairment(0.35),
    "moderate": style_of_impairment(0.7),
    "mixed": MovementStyle(),
    "faults": MovementStyle(),
}
VALID_SHARE: Final = {"mild": 0.6, "moderate": 0.42, "faults": 0.5}
"""What a therapist would ask of these; 0.8 of the others."""
FAULTS: Final = {
    "short": "guidance.further",
    "lean": "guidance.sit_tall",
    "side": "guidance.sit_tall",
    "hike": "guidance.shoulder_down",
    "fast": "guidance.slower",
    "slow": "guidance.quicker",
    "front": "guidance.arm_to_side",
    "out": "guidance.arm_in_front",
}
"""Faults with the sentence that each should bring."""


@dataclass(frozen=True)
class GuidedSession:
    """One set of one exercise, as sensors saw it.

    Attributes
    ----------
    kind : str
        Key of `STYLES`.
    values, sigma : ndarray, shape (N, C)
        From the rest before the first repetition on.
    phase : ndarray, shape (N,)
        True phase of the template, NaN outside repetitions and in wrong ones.
    true_values : ndarray, shape (N, C)
    bounds : ndarray of int, shape (R, 2)
        Ticks at which each repetition begins and ends.
    faults : tuple of str
        Of each repetition; empty where it is sound.
    """

    kind: str
    ready: GuidanceTemplate
    values: Float
    sigma: Float
    phase: Float
    true_values: Float
    bounds: Float
    plan: tuple[PlannedRepetition, ...]
    faults: tuple[str, ...]

    def truth_of(self, number: int) -> str:
        """Return valid, partial or wrong."""
        one = self.plan[number]
        return "wrong" if one.instead else "partial" if one.size < 0.65 and self.kind == "mixed" else "valid"


def streamed(kind: str, seed: int) -> tuple[GuidanceTemplate, Frames]:
    """Return the template and the frames of such a set, from the end of the way to the start posture on."""
    done = _performed(kind, seed)
    return done.ready, done.frames.ticks(_FIRST, done.frames.tick_count)


@cache
def session(kind: str, seed: int) -> GuidedSession:
    """Return one set of the exercise whose turn it is with this seed, with its own therapist."""
    done = _performed(kind, seed)
    ready, truth = done.ready, done.made.truth
    values, sigma = signals(trajectory(done.frames), ready)
    true_values, _ = signals(trajectory(truth.frames), ready)
    return GuidedSession(
        kind=kind,
        ready=ready,
        values=values[_FIRST:],
        sigma=sigma[_FIRST:],
        phase=_true_phase(NAMES[seed % len(NAMES)], truth.progress, done.speed)[_FIRST:],
        true_values=true_values[_FIRST:],
        bounds=np.rint(truth.repetitions_s / STEP_S).astype(int) - _FIRST,
        plan=done.plan,
        faults=done.faults,
    )


@dataclass(frozen=True)
class _Performed:
    """A set as it was simulated, and the frames that the pipeline made of it."""

    made: SimulatedSession
    frames: Frames
    ready: GuidanceTemplate
    speed: float
    """The therapist's pace."""
    plan: tuple[PlannedRepetition, ...]
    faults: tuple[str, ...]


def _performed(kind: str, seed: int) -> _Performed:
    name = NAMES[seed % len(NAMES)]
    generator = np.random.default_rng([seed, *kind.encode()])
    planned = [_planned(kind, name, generator) for _ in range(_REPETITIONS)]
    plan, faults = tuple(one for one, _ in planned), tuple(fault for _, fault in planned)
    ready, speed = _template(name, seed)
    made = simulate_arm(
        ArmScenario(
            exercise=name,
            style=STYLES[kind],
            schedule=Schedule(n_pose_s=N_POSE_S, transition_s=TRANSITION_S, repetitions=None, plan=plan),
            placements=PLACEMENTS,
            seed=2 * seed + 1,
        )
    )
    frames, _ = run(made.recording, made.setup, (1.5, 4.5))
    return _Performed(made, frames, ready, speed, plan, faults)


@cache
def _template(name: ExerciseName, seed: int) -> tuple[GuidanceTemplate, float]:
    """Return what a therapist showed with this seed, and at which pace."""
    shown = demonstration_scenario("therapist_template", name, seed=2 * seed)
    made = simulate_arm(
        replace(shown, placements=PLACEMENTS, schedule=replace(shown.schedule, n_pose_s=N_POSE_S))
    )
    frames, _ = run(made.recording, made.setup, (1.5, 4.5))
    # The true bounds: what is judged here is the guidance, not how repetitions are found.
    cut = [Repetition(n, float(a), float(b)) for n, (a, b) in enumerate(made.truth.repetitions_s, start=1)]
    primary = EXERCISES[name].primary_channel.format(side="right")
    template = build_template(trajectory(frames), cut, "right", REACH_M, primary)
    return prepare_template(template, "right", REACH_M), shown.style.speed


def _true_phase(name: ExerciseName, progress: Float, speed: float) -> Float:
    """Return the phase of the therapist at whose posture the patient is, by pieces of the exercise."""
    exercise = EXERCISES[name]
    pieces = [t for stop in exercise.stops for t in (stop.move_s / speed, stop.hold_s)]
    lasts_s = np.array([*pieces, exercise.return_s / speed])
    begins_s = np.concatenate([[0.0], np.cumsum(lasts_s)])
    place = np.clip(np.nan_to_num(progress), 0.0, len(lasts_s) - 1e-9)
    piece = place.astype(int)
    share = place - piece
    time = np.linspace(0.0, 1.0, 2001)
    way = time**3 * (10.0 - 15.0 * time + 6.0 * time**2)
    share = np.where(piece % 2 == 0, np.interp(share, way, time), share)
    phase = (begins_s[piece] + share * lasts_s[piece]) / begins_s[-1]
    return np.where(np.isnan(progress), np.nan, phase)


def _planned(kind: str, name: str, random: np.random.Generator) -> tuple[PlannedRepetition, str]:
    if kind == "pauses":
        stops = random.random() < 0.25
        return PlannedRepetition(
            pace=float(np.exp(random.uniform(np.log(0.55), np.log(1.4)))),
            pause_s=float(random.uniform(0.0, 3.0)),
            stop_share=float(random.uniform(0.35, 0.65)),
            stop_s=float(random.uniform(0.3, 1.5)) if stops else 0.0,
        ), ""
    if kind == "no rest":
        return PlannedRepetition(pace=float(np.exp(random.normal(0.0, 0.15))), pause_s=0.0), ""
    if kind in ("mild", "moderate"):
        return PlannedRepetition(pause_s=float(random.uniform(0.5, 2.5))), ""
    if kind == "mixed":
        which = random.random()
        if which < 0.2:
            return PlannedRepetition(size=float(random.uniform(0.3, 0.6))), ""
        if which < 0.35:
            return PlannedRepetition(instead=_OTHER[name]), ""
        return PlannedRepetition(pace=float(np.exp(random.normal(0.0, 0.15)))), ""
    return _faulty(name, random)


def _faulty(name: str, random: np.random.Generator) -> tuple[PlannedRepetition, str]:
    """Return a sound repetition or one with a single fault, one as often as the other."""
    if random.random() < 0.5:
        return PlannedRepetition(), ""
    possible = [fault for fault in FAULTS if fault not in ("front", "out")]
    # Only where the arm is raised is there a plane; a fault goes away from the other plane.
    possible += {"abduction": ["front"], "flexion": ["out"], "reaching": ["out"]}.get(name, [])
    fault = str(random.choice(possible))
    planned = {
        "short": PlannedRepetition(size=random.uniform(0.55, 0.72)),
        "lean": PlannedRepetition(lean_rad=np.radians(random.uniform(12.0, 20.0))),
        "side": PlannedRepetition(lateral_rad=np.radians(random.uniform(11.0, 16.0))),
        "hike": PlannedRepetition(hike_rad=np.radians(random.uniform(11.0, 16.0))),
        "fast": PlannedRepetition(pace=random.uniform(1.7, 2.2)),
        "slow": PlannedRepetition(pace=random.uniform(0.4, 0.55)),
        "front": PlannedRepetition(plane_rad=np.radians(random.uniform(30.0, 45.0))),
        "out": PlannedRepetition(plane_rad=-np.radians(random.uniform(30.0, 45.0))),
    }
    return planned[fault], fault


def matched(one: GuidedSession, chunk: GuidanceChunk) -> list[str]:
    """Return how each true repetition was counted; `missed` where no attempt shares 40 % of its time."""
    free = [attempt for attempt in chunk.repetitions if attempt.kind != "ignored"]
    kinds = []
    for start, end in one.bounds:
        shared = [min(a.end_tick, end) - max(a.start_tick, start) for a in free]
        best = int(np.argmax(shared)) if free else -1
        if best < 0 or shared[best] < 0.4 * (end - start):
            kinds.append("missed")
        else:
            kinds.append(free.pop(best).kind)
    return [*kinds, *(f"extra {a.kind}" for a in free)]
