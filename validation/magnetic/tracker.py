"""The three-coil tracker (Roetenberg 2006, chapter 5): identities, noise, coils that are no dipoles, movements."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimators import rotation
from estimators.magnetic import (
    Fix,
    TrackerFlag,
    TrackerLimits,
    bursts,
    extract_pulses,
    integrate_gyroscope,
    locate,
    perpendicular_source,
)
from estimators.magnetic.published import MU0_TM_PER_A, axial_reach_m, closed_form, dipole_covariance, predict
from estimators.recording import Float
from estimators.simulation.coils import (
    ModuleErrors,
    RelativeScene,
    burst_motion,
    fire_bursts,
    relative_scene,
)
from validation.protocol import Data, Figure, Protocol, Values

EXACT = perpendicular_source()
_DIPOLES = EXACT.with_model("dipole")
_CURRENT_A = 1.5
_PULSE_SIGMA_T = 1.6e-8
"""Five on samples less seventeen off ones of 3e-8 T."""
ERRORS = ModuleErrors(0.05, 0.01, 3e-8, 0.02, 0.003)
_MODEL_ERROR = {
    0.15: (28.1, 19.8),
    0.20: (19.0, 10.1),
    0.30: (13.5, 4.9),
    0.45: (9.4, 2.3),
    0.60: (6.9, 1.3),
    0.70: (6.1, 0.9),
}
_BOUND = {0.20: 0.25e-3, 0.30: 1.2e-3, 0.45: 6.5e-3}


def _one(value: float) -> Float:
    return np.array([value])


def _poses(rng: np.random.Generator, count: int, distance: float) -> tuple[Float, Float]:
    u = rng.normal(size=(count, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    return u * distance, rotation.normalize(rng.normal(size=(count, 4)))


def _columns(source: object, p: Float, q: Float) -> Float:
    return np.stack([predict(source, k, _CURRENT_A, p, q).field_sensor_t for k in range(3)], axis=-1)  # type: ignore[arg-type]


def _bench(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    kappa = MU0_TM_PER_A / (4 * np.pi) * EXACT.coils[0].moment_m2 * _CURRENT_A
    for seed in seeds:
        rng = np.random.default_rng([seed, 43])
        p, q = _poses(rng, 400, 1.0)
        p *= rng.uniform(0.1, 0.8, (400, 1))
        found = closed_form(_DIPOLES, _columns(_DIPOLES, p, q), _CURRENT_A)
        side = np.sign(np.sum(found.position_m * p, axis=1))[:, None]
        relative = np.linalg.norm(found.position_m * side - p, axis=1) / np.linalg.norm(p, axis=1)
        values.setdefault("identity, position", []).append(float(relative.max()))
        ratios = []
        for distance in (0.2, 0.3, 0.45):
            p, q = _poses(rng, 1000, distance)
            noisy = _columns(_DIPOLES, p, q) + rng.normal(0.0, 1e-8, (1000, 3, 3))
            found = closed_form(_DIPOLES, noisy, _CURRENT_A)
            side = np.sign(np.sum(found.position_m * p, axis=1))[:, None]
            covariance = dipole_covariance(p[0], q[0], kappa, 1e-8)
            error = np.sqrt(np.mean(np.sum((found.position_m * side - p) ** 2, axis=1)))
            turn = np.sqrt(np.mean(rotation.angle_between(found.q_source_sensor, q) ** 2))
            ratios.append(abs(error / np.sqrt(np.trace(covariance[:3, :3])) - 1.0))
            ratios.append(abs(turn / np.sqrt(np.trace(covariance[3:, 3:])) - 1.0))
        values.setdefault("noise against its covariance", []).append(100.0 * float(max(ratios)))
        off = []
        for distance, (millimetre, degree) in _MODEL_ERROR.items():
            p, q = _poses(rng, 1500, distance)
            found = closed_form(EXACT, _columns(EXACT, p, q), _CURRENT_A)
            side = np.sign(np.sum(found.position_m * p, axis=1))[:, None]
            error = 1e3 * np.sqrt(np.mean(np.sum((found.position_m * side - p) ** 2, axis=1)))
            turn = np.degrees(np.sqrt(np.mean(rotation.angle_between(found.q_source_sensor, q) ** 2)))
            off += [abs(error / millimetre - 1.0), abs(turn / degree - 1.0)]
        values.setdefault("closed form on loops, off the reference", []).append(100.0 * float(max(off)))
        clean, noisy_ratio = [], []
        limits = TrackerLimits(gain_sigma=0.0)
        for distance, bound in _BOUND.items():
            squares = []
            for p1, q1 in zip(*_poses(rng, 40, distance), strict=True):
                pulses = np.stack([predict(EXACT, k, _CURRENT_A, p1, q1).field_sensor_t for k in range(3)])
                fix = locate(EXACT, np.arange(3), _CURRENT_A, pulses, 1e-8, direction=p1, limits=limits)
                clean.append(float(np.linalg.norm(fix.position_m - p1)))
                pulses = pulses + rng.normal(0.0, 1e-8, (3, 3))
                fix = locate(EXACT, np.arange(3), _CURRENT_A, pulses, 1e-8, direction=p1, limits=limits)
                squares.append(float(np.sum((fix.position_m - p1) ** 2)))
            noisy_ratio.append(np.sqrt(np.mean(squares)) / bound)
        values.setdefault("exact solver without noise", []).append(max(clean))
        values.setdefault("exact solver over its bound", []).append(float(max(noisy_ratio)))
    centre = float(np.linalg.norm(EXACT.field(2, _CURRENT_A, [0.0, 0.0, 0.0]))) * 1e4
    return {name: np.array(found) for name, found in values.items()} | {
        "5 G contour on the axis": _one(axial_reach_m(EXACT, 5e-4)),
        "field at the centre, off 8.57 G": _one(abs(centre / 8.57 - 1.0) * 100.0),
    }


_ROWS: dict[str, tuple[float, float, float | None, float]] = {
    # movement: range mm required, published mm, orientation deg required, published deg
    "bench": (7.6, 7.6, 6.8, 5.9),
    "flexion": (5.9, 5.9, 4.9, 4.9),
    "lateral": (6.3, 6.3, 5.2, 5.2),
    "rotation": (5.9, 5.9, 5.1, 5.1),
    "walk_back": (8.6, 8.6, 6.8, 6.8),
    "arm_flexion": (7.8, 7.8, 6.6, 6.6),
    "arm": (7.2, 7.2, 6.6, 6.2),
    # At 25 degrees and 0.9 Hz the arm turns by up to nine degrees from pulse to pulse: no rigid burst tells 7.4.
    "walk_arm": (11.7, 11.7, None, 7.4),
    "walk_leg": (15.0, 15.0, 8.7, 8.7),
}
_TITLES = {
    "bench": "bench",
    "flexion": "back, flexion",
    "lateral": "back, lateral flexion",
    "rotation": "back, rotation",
    "walk_back": "back, walking",
    "arm_flexion": "arm, flexion",
    "arm": "arm, abduction",
    "walk_arm": "arm, walking",
    "walk_leg": "leg, walking",
}


def fixes(scene: RelativeScene, carried: bool = True) -> tuple[list[tuple[int, Fix]], int]:
    """Return tick and pose of every burst of a movement, solved one by one, and how many had no solution."""
    field, state = fire_bursts(scene)
    still = scene.time_s < 1.0
    rate = scene.gyroscope_radps - scene.gyroscope_radps[still].mean(axis=0)
    attitude = integrate_gyroscope(rate, scene.time_step_s)
    pulses = extract_pulses(field, state, _CURRENT_A, attitude if carried else None)
    found: list[tuple[int, Fix]] = []
    failed, last = 0, scene.position_m[0]
    for burst in bursts(pulses):
        values = np.stack([pulse.field_sensor_t for pulse in burst])
        # A moving sensor never fits to the noise: continuity chooses the hemisphere.
        fix = locate(EXACT, np.arange(3), _CURRENT_A, values, _PULSE_SIGMA_T, last_position_m=last)
        if fix.flags & TrackerFlag.NO_SOLUTION:
            failed += 1
            continue
        if np.linalg.norm(fix.position_m + last) < np.linalg.norm(fix.position_m - last):
            fix = replace(fix, position_m=-fix.position_m)
        last = fix.position_m
        found.append((burst[1].middle, fix))
    return found, failed


def track(movement: str, seed: int, carried: bool = True) -> tuple[Float, Float, Float, int]:
    """Return errors of range (m), position (m) and orientation (rad) of every burst, and how many failed."""
    scene = relative_scene(EXACT, burst_motion(movement, 24.0, seed), 24.0, 120.0, ERRORS, seed)
    found, failed = fixes(scene, carried)
    errors = burst_errors(scene, found)
    return errors[:, 0], errors[:, 1], errors[:, 2], failed


def burst_errors(scene: RelativeScene, found: Sequence[tuple[int, Fix]]) -> Float:
    """Return errors of range (m), position (m) and orientation (rad) of bursts from 3.3 s on, shape (N, 3)."""
    rows = []
    for middle, fix in found:
        if scene.time_s[middle] < 3.3:
            continue
        truth = scene.position_m[middle]
        rows.append(
            (
                np.linalg.norm(fix.position_m) - np.linalg.norm(truth),
                np.linalg.norm(fix.position_m - truth),
                rotation.angle_between(fix.q_source_sensor, scene.q_source_sensor[middle]),
            )
        )
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _rms(values: Float) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _movements(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    failed = 0
    for movement, title in _TITLES.items():
        for seed in seeds:
            distance, place, turn, missing = track(movement, seed)
            failed += missing
            values.setdefault(f"{title}, range", []).append(1e3 * _rms(distance))
            values.setdefault(f"{title}, position", []).append(1e3 * _rms(place))
            values.setdefault(f"{title}, orientation", []).append(float(np.degrees(_rms(turn))))
    worse = []
    for seed in seeds:
        plain = _rms(track("walk_leg", seed, carried=False)[1])
        worse.append(1e3 * plain / values[f"{_TITLES['walk_leg']}, position"][seeds.index(seed)])
    found = {name: _one(_rms(np.array(rows))) for name, rows in values.items()}
    return found | {
        "leg, baseline without gyroscope, times worse": _one(float(np.mean(worse))),
        "bursts without a solution": _one(float(failed)),
    }


def _movement_figures() -> tuple[Figure, ...]:
    figures = []
    for movement, title in _TITLES.items():
        most, published, angle, published_angle = _ROWS[movement]
        figures += [
            Figure(f"{title}, range", "mm", most, published),
            Figure(f"{title}, position", "mm", None, published),
            Figure(f"{title}, orientation", "deg", angle, published_angle),
        ]
    return (
        *figures,
        Figure("leg, baseline without gyroscope, times worse", "1", 5.0, at_most=False),
        Figure("bursts without a solution", "1", 0.0),
    )


MAGNETIC_TRACKER = Protocol(
    name="magnetic_tracker_bench",
    title="Closed form, exact coils, noise law, safety",
    source="Roetenberg 2006, chapter 5; method page V1 to V4, V13",
    what="Random poses: dipole data must give the pose exactly, noise must follow its covariance, loops must show the "
    "known error of the closed form, and the exact solver must reach its bound.",
    figures=(
        Figure("identity, position", "1", 1e-11),
        Figure("noise against its covariance", "%", 10.0, judged_by="median"),
        Figure("closed form on loops, off the reference", "%", 15.0, judged_by="median"),
        Figure("exact solver without noise", "m", 1e-6, judged_by="median"),
        Figure("exact solver over its bound", "1", 1.15, judged_by="median"),
        Figure("5 G contour on the axis", "m", 0.0365),
        Figure("field at the centre, off 8.57 G", "%", 0.2),
    ),
    measure=_bench,
)
MAGNETIC_MOVEMENTS = Protocol(
    name="magnetic_tracker_movements",
    title="Table 5.1: three-coil tracker on moving segments",
    source="Roetenberg 2006, table 5.1; method page V5 to V9",
    what="Bursts of 60 ms pulses every 600 ms at 120 Hz, solved one by one with the exact coils; rms over all bursts "
    "and seeds. The limit is on the range, as the page argues (E14); the error in space is shown.",
    figures=_movement_figures(),
    measure=_movements,
)
