"""Joint angles after calibration by movement: sensors put on askew, skin that moves over the bone."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimators import orientation, rotation, signals
from estimators.calibration import Calibration, functional, static_bias
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames, run
from estimators.simulation import (
    ARM_PLACEMENTS,
    CALIBRATION_STYLE,
    EXERCISES,
    ArmScenario,
    Mounting,
    Schedule,
    SimulatedSession,
    calibration_exercise,
    calibration_ranges_s,
    outward_mounting,
    simulate_arm,
)
from validation.protocol import Data, Figure, Protocol, Values

_PLACEMENT_ERROR_RAD = float(np.radians(10.0))
_SKIN_RAD = float(np.radians(3.0))
_POSTURE_SD_RAD = float(np.radians(2.0))
_FILTER = "telemotion"
_NAMES = sorted(EXERCISES)
_JOINTS = {
    "shoulder": ("thorax_humerus", ("yxy_plane_of_elevation", "yxy_elevation", "yxy_axial_rotation")),
    "elbow": ("humerus_forearm", ("zxy_flexion", "zxy_carrying", "zxy_pronation")),
}
_NEEDS_RAISED_ARM = ("yxy_plane_of_elevation", "yxy_axial_rotation")
_RAISED_RAD = float(np.radians(30.0))
"""Plane of elevation and axial rotation count from here on: below, a degree of skin is two degrees and more of
plane, whatever the calibration, and just above the flagged singular zone it is six."""
_LEFT_OUT = np.uint8(OrientationFlag.SINGULAR | OrientationFlag.INVALID)


def _askew(seed: int, skin_rad: float) -> Mounting:
    """Every sensor turned by exactly ten degrees about an axis of its own."""
    generator = np.random.default_rng([seed, 21])
    exact = {}
    for placement in ARM_PLACEMENTS:
        axis = generator.normal(size=3)
        off = rotation.exp(_PLACEMENT_ERROR_RAD * axis / np.linalg.norm(axis))
        w, x, y, z = (float(v) for v in rotation.multiply(outward_mounting(placement), off))
        exact[placement] = (w, x, y, z)
    return Mounting(q_segment_sensor=exact, soft_tissue_rad=skin_rad)


def _by_movement(seed: int, skin_rad: float) -> Calibration:
    """Calibrate as a guided session does: bias at rest, the filter with it, the movements."""
    schedule = Schedule(n_pose_s=5.0, repetitions=1)
    made = simulate_arm(
        ArmScenario(
            exercise=calibration_exercise(),
            both_arms=True,
            style=replace(CALIBRATION_STYLE, posture_sd_rad=_POSTURE_SD_RAD),
            schedule=schedule,
            mounting=_askew(seed, skin_rad),
            seed=seed,
        )
    )
    chunk = signals.to_common_ticks(made.recording, made.setup.rate_hz)
    movements = {}
    for name, bounds in calibration_ranges_s(schedule).items():
        start, stop = (round(bound * made.setup.rate_hz) for bound in bounds)
        for ending in ("",) if name == "rest" else ("_left", "_right"):
            movements[name + ending] = (start, stop)
    rest = slice(*movements["rest"])
    bias = static_bias(
        chunk.gyroscope_radps[:, rest],
        chunk.accelerometer_mps2[:, rest],
        chunk.time_step_s,
        require_still=False,
    )
    estimator = orientation.create(_FILTER, chunk.sensor_count, chunk.time_step_s)
    sigma = float(np.median(bias.gyroscope_standard_error_radps))
    estimator.set_gyroscope_bias(bias.gyroscope_bias_radps, max(sigma, float(np.radians(0.02))))
    found = estimator.update(chunk)
    return functional(
        found.q_earth_sensor,
        chunk.gyroscope_radps,
        chunk.accelerometer_mps2,
        made.setup.placements,
        movements,
        found.flags,
        time_step_s=chunk.time_step_s,
    ).calibration


def _exercise(seed: int, skin_rad: float) -> SimulatedSession:
    return simulate_arm(
        ArmScenario(
            exercise=_NAMES[seed % len(_NAMES)],
            both_arms=True,
            schedule=Schedule(n_pose_s=8.0, repetitions=6),
            mounting=_askew(seed, skin_rad),
            orientation=_FILTER,
            seed=seed,
        )
    )


def _errors_deg(found: Frames, truth: Frames, raised_rad: float = _RAISED_RAD) -> dict[str, float]:
    """RMS of every shoulder and elbow angle over both arms, after 10 s, outside the flagged singular zone."""
    later = found.time_s > 10.0
    result = {}
    for joint, meanings in _JOINTS.values():
        for meaning in meanings:
            squares = []
            for side in ("left", "right"):
                name = f"{joint}_{side}_{meaning}"
                column, other = found.layout.angles.index(name), truth.layout.angles.index(name)
                flagged = (found.angle_flags[:, column] | truth.angle_flags[:, other]) & _LEFT_OUT
                scored = later & (flagged == 0)
                if meaning in _NEEDS_RAISED_ARM:
                    height = truth.layout.angles.index(f"thorax_humerus_{side}_yxy_elevation")
                    scored &= truth.angle_rad[:, height] >= raised_rad
                error = found.angle_rad[scored, column] - truth.angle_rad[scored, other]
                squares.append((np.remainder(error + np.pi, 2.0 * np.pi) - np.pi) ** 2)
            together = np.concatenate(squares)
            if together.size * found.time_step_s >= 1.0:
                result[meaning] = float(np.degrees(np.sqrt(np.mean(together))))
    return result


def _pooled(errors: dict[str, float], meanings: Sequence[str]) -> float:
    values = [errors[meaning] for meaning in meanings if meaning in errors]
    return float(np.sqrt(np.mean(np.square(values)))) if values else float("nan")


def _measure(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        session = _exercise(seed, _SKIN_RAD)
        truth = session.truth.frames
        by_movement = replace(session.setup, calibration=_by_movement(seed, _SKIN_RAD))
        exact = Calibration(
            {
                p: (float(q[0]), float(q[1]), float(q[2]), float(q[3]))
                for p, q in session.truth.q_sensor_segment.items()
            },
            by_movement.calibration.gyroscope_bias_radps if by_movement.calibration else {},
            facing_rad=session.truth.facing_rad,
        )
        errors = _errors_deg(run(session.recording, by_movement)[0], truth)
        pose = _errors_deg(run(session.recording, session.setup, (3.0, 7.0))[0], truth)
        perfect = _errors_deg(run(session.recording, replace(session.setup, calibration=exact))[0], truth)
        for joint, (_, meanings) in _JOINTS.items():
            values.setdefault(f"{joint} angles", []).append(_pooled(errors, meanings))
            values.setdefault(f"{joint} angles, N-pose alone", []).append(_pooled(pose, meanings))
            values.setdefault(f"{joint} angles, mounting known exactly", []).append(
                _pooled(perfect, meanings)
            )
            for meaning in meanings:
                # An exercise that never raises the arm tells nothing about its plane.
                if meaning in errors:
                    values.setdefault(f"{joint} {_words(meaning)}", []).append(errors[meaning])
    return {name: np.array(found) for name, found in values.items()}


def _words(meaning: str) -> str:
    return meaning.removeprefix("yxy_").removeprefix("zxy_").replace("_", " ")


FUNCTIONAL_CALIBRATION = Protocol(
    name="arm_functional_calibration",
    title="Joint angles after calibration by movement",
    source="House requirement: sensor noise, 3 degrees of soft-tissue motion, sensors put on 10 degrees askew",
    what="A person bends the elbows, turns the palms and raises both arms forward and sideways; then a recording of an "
    "exercise with the same sensors is estimated.",
    figures=(
        *(Figure(f"{joint} angles", "deg", 3.0, judged_by="median") for joint in _JOINTS),
        *(
            Figure(f"{joint} {_words(meaning)}", "deg")
            for joint, (_, meanings) in _JOINTS.items()
            for meaning in meanings
        ),
        *(
            Figure(f"{joint} angles, {how}", "deg")
            for how in ("N-pose alone", "mounting known exactly")
            for joint in _JOINTS
        ),
    ),
    measure=_measure,
)
