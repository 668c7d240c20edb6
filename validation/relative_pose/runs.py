"""Simulated sessions of the relative-pose filter and their scores, shared by its protocols."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2

from estimators import rotation
from estimators.magnetic import RelativePoseFilter, RelativeResult, Source, perpendicular_source
from estimators.magnetic.relative import layout as at
from estimators.recording import Float
from estimators.simulation.coils import (
    Iron,
    ModuleErrors,
    RelativeScene,
    SourceFaults,
    relative_motion,
    relative_scene,
    run_closed_loop,
)

SOURCE = perpendicular_source(0.06)
"""Coils of the thesis, each 6 cm out along its own axis."""
SCORED_FROM_S = 4.0


@dataclass(frozen=True)
class Run:
    """A session with truth: position error (K, 3), orientation error (K, 3) in sensor axes, ticks that count."""

    scene: RelativeScene
    result: RelativeResult
    samples: Float
    relative: RelativePoseFilter
    position_error_m: Float
    attitude_error_rad: Float
    scored: Any

    @property
    def position_rms_m(self) -> float:
        """Three-dimensional position error."""
        return rms(self.position_error_m[self.scored])

    @property
    def attitude_rms_deg(self) -> float:
        """Angle of the orientation error."""
        return float(np.degrees(rms(self.attitude_error_rad[self.scored])))

    @property
    def nees(self) -> float:
        """Mean normalised error squared per state of position and orientation."""
        errors = np.concatenate([self.position_error_m, self.attitude_error_rad], axis=1)[self.scored]
        return mean_nees(errors, self.result.covariance[self.scored])

    @property
    def inside(self) -> Any:
        """Whether the place is within the ellipsoid that should hold it in 95 % of cases, shape (K,)."""
        error = self.position_error_m
        solved = np.linalg.solve(self.result.covariance[:, :3, :3] + 1e-18 * np.eye(3), error[..., None])[
            ..., 0
        ]
        return np.sum(error * solved, axis=1) < chi2.ppf(0.95, 3)

    @property
    def interval_s(self) -> float:
        """Mean time between actuations."""
        count = int(np.sum(self.result.fire_coil[self.scored] > 0))
        return float(np.sum(self.scored)) * self.scene.time_step_s / max(count, 1)

    @property
    def energy_a2s(self) -> float:
        """Squared current over time while scored."""
        return float(np.sum(self.samples[self.scored, at.CURRENT] ** 2) * self.scene.time_step_s)


def rms(errors: Float) -> float:
    """Root mean square length of vectors, shape (N, 3)."""
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


def mean_nees(errors: Float, covariance: Float) -> float:
    """Mean of e^T P^-1 e over the number of states."""
    solved = np.linalg.solve(covariance, errors[..., None])[..., 0]
    return float(np.mean(np.sum(errors * solved, axis=1)) / errors.shape[1])


def session(
    movement: str,
    seed: int,
    duration_s: float = 30.0,
    parameters: Mapping[str, Any] | None = None,
    faults: SourceFaults | None = None,
    iron: Sequence[Iron] = (),
    source: Source = SOURCE,
    believed: Source | None = None,
    pause_s: tuple[float, float] | None = None,
    errors: ModuleErrors | None = None,
    known_start: bool = False,
    altered: Callable[[RelativeScene], RelativeScene] | None = None,
) -> Run:
    """Run one session of the method page (7.1): 2 s of standstill, first burst, movement from 4 s on.

    `parameters` are what differs from the filter's own defaults; `altered` changes what is measured.
    """
    motion = relative_motion(movement, duration_s, seed, pause_s)
    scene = relative_scene(source, motion, duration_s, seed=seed, iron=iron, errors=errors)
    scene = scene if altered is None else altered(scene)
    # The coils are exactly as believed, as after a calibration: gain_sigma is that of calibrated coils, unlike the 3 %
    # that the product assumes of nominal ones.
    own: dict[str, Any] = {
        "mounting_direction": tuple(scene.position_m[0].tolist()),
        "gain_sigma": 0.002,
    }
    relative = RelativePoseFilter(believed or source, scene.time_step_s, own | dict(parameters or {}))
    if known_start:
        # 1 cm and 2 degrees beside the truth, as the method page starts.
        rng = np.random.default_rng([seed, 97])
        sigmas = np.repeat([0.01, np.radians(2.0)], 3)
        off = rng.normal(0.0, sigmas)
        relative.set_pose(
            scene.position_m[0] + off[:3],
            rotation.multiply(scene.q_source_sensor[0], rotation.exp(off[3:])),
            np.diag(sigmas**2),
        )
    result, samples = run_closed_loop(scene, relative, faults, seed)
    return score(scene, result, samples, relative)


def score(scene: RelativeScene, result: RelativeResult, samples: Float, relative: RelativePoseFilter) -> Run:
    """Put errors beside a result."""
    return Run(
        scene,
        result,
        samples,
        relative,
        result.position_m - scene.position_m,
        attitude_error(scene.q_source_sensor, result.q_source_sensor),
        scene.time_s >= SCORED_FROM_S,
    )


def attitude_error(truth: Float, estimate: Float) -> Float:
    """Return the errors in sensor axes as rotation vectors."""
    return rotation.log(rotation.multiply(rotation.conjugate(truth), estimate))
