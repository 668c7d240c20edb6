"""Ten minutes without magnetometers: the elbow keeps upper arm and forearm from drifting apart."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimators import rotation
from estimators.conventions import Placement
from estimators.pipelines import Frames, run
from estimators.recording import Float
from estimators.simulation import EXERCISES, ArmScenario, Schedule, SimulatedSession, simulate_arm
from validation.protocol import Curve, Data, Figure, Plot, Protocol, Values

_WORN: tuple[Placement, ...] = ("sternum", "upper_arm_right", "forearm_right")
_NAMES = sorted(EXERCISES)
_DURATION_S = 600.0
_POSE_S = (3.0, 7.0)
_FROM_S = 60.0
_LIMIT_DEG = 10.0
"""As far as two sensors put on by the rule face apart anyway."""
_WITH, _WITHOUT = "with the joint's rule", "without it"


def _session(seed: int) -> SimulatedSession:
    return simulate_arm(
        ArmScenario(
            exercise=_NAMES[seed % len(_NAMES)],
            placements=_WORN,
            schedule=Schedule(n_pose_s=8.0, repetitions=None, duration_s=_DURATION_S),
            has_magnetometer=False,
            seed=seed,
        )
    )


def relative_heading_error(found: Frames, truth: Frames) -> Float:
    """Return by how much the forearm's heading error exceeds the upper arm's, rad, shape (K,), within +-pi."""
    headings = []
    for name in _WORN[1:]:
        error = rotation.multiply(
            found.q_room_segment[:, found.layout.segments.index(name)],
            rotation.conjugate(truth.q_room_segment[:, truth.layout.segments.index(name)]),
        )
        headings.append(2.0 * np.arctan2(error[:, 3], error[:, 0]))
    return np.asarray(np.remainder(headings[1] - headings[0] + np.pi, 2.0 * np.pi) - np.pi)


def _errors(seed: int) -> tuple[Float, dict[str, Float]]:
    made = _session(seed)
    errors = {}
    for label, is_on in ((_WITH, True), (_WITHOUT, False)):
        frames = run(made.recording, replace(made.setup, constrain_joint_headings=is_on), _POSE_S)[0]
        errors[label] = relative_heading_error(frames, made.truth.frames)
    return frames.time_s, errors


def _measure(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        time_s, errors = _errors(seed)
        for label, error in errors.items():
            for part, scored in (
                ("after a minute", time_s >= _FROM_S),
                ("last minute", time_s >= _DURATION_S - 60.0),
            ):
                rms = float(np.degrees(np.sqrt(np.mean(error[scored] ** 2))))
                values.setdefault(f"{part}, {label}", []).append(rms)
    shares = np.divide(values[f"after a minute, {_WITH}"], values[f"after a minute, {_WITHOUT}"])
    return {name: np.array(found) for name, found in values.items()} | {"share that is left": shares}


def _plots(data: Data) -> tuple[Plot, ...]:
    time_s, errors = _errors(0)
    every = slice(None, None, 100)
    return (
        Plot(
            "Heading of the forearm against the upper arm",
            "time",
            "s",
            "error",
            "deg",
            tuple(Curve(label, time_s[every], np.degrees(error[every])) for label, error in errors.items()),
        ),
    )


JOINT_HEADINGS = Protocol(
    name="arm_joint_headings",
    title="Heading drift between upper arm and forearm, bounded by the elbow",
    source="House requirement: joint constraints bound heading drift without magnetometers",
    what="Ten minutes of an exercise with gyroscopes and accelerometers alone, gyroscope offsets that walk, sensors "
    "calibrated by the standing pose; RMS of the difference of both heading errors.",
    figures=(
        Figure(f"after a minute, {_WITH}", "deg", _LIMIT_DEG, judged_by="median"),
        Figure(f"last minute, {_WITH}", "deg", _LIMIT_DEG, judged_by="median"),
        Figure("share that is left", "", 1.0 / 3.0, judged_by="median"),
        Figure(f"after a minute, {_WITHOUT}", "deg"),
        Figure(f"last minute, {_WITHOUT}", "deg"),
    ),
    measure=_measure,
    plots=_plots,
)
