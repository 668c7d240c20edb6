"""Movements of a module with a marker, as the protocols of optical aid need them: a free hand and a walking foot."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation, RotationSpline

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.optical.published import OpticalChunk
from estimators.recording import Float

STEP_S, STILL_S, MARKER_SIGMA_M = 0.01, 3.0, 0.0003
PARAMETERS = {"force_sigma_mps2": 0.02, "rate_sigma_radps": 0.005, "rate_bias_sigma_radps": 0.001}
"""Of the filter, for these modules: their noise a sample."""


@dataclass(frozen=True)
class Scene:
    """Samples and the truth at their ticks."""

    chunk: OpticalChunk
    position_m: Float
    acceleration_mps2: Float
    q_room_sensor: Float
    time_s: Float

    def without(self, missing: NDArray[np.bool_]) -> OpticalChunk:
        """Hide markers."""
        marker = self.chunk.marker_m.copy()
        marker[missing] = np.nan
        return replace(self.chunk, marker_m=marker)


def free_motion(
    seed: int, duration_s: float = 25.0, highest_hz: float = 1.0, marker: float = MARKER_SIGMA_M
) -> Scene:
    """Return free hand motion after three seconds of rest, up to a highest frequency; page 4.2."""
    rng = np.random.default_rng([seed, 113])
    grid = np.arange(0.0, duration_s + 0.2, 0.02)
    x = np.clip((grid - STILL_S) / 1.0, 0.0, 1.0)
    begin = (x**3 * (10 - 15 * x + 6 * x * x))[:, None]

    def band(sizes: tuple[float, ...], count: int = 8) -> Float:
        rates = rng.uniform(0.1 * highest_hz, highest_hz, (count, 3))
        phases = rng.uniform(0.0, 2 * np.pi, (count, 3))
        wave = np.sin(2 * np.pi * rates * grid[:, None, None] + phases).sum(axis=1) / np.sqrt(count / 2.0)
        return np.asarray(wave * sizes * begin)

    return measured(rng, grid, band((0.5, 0.4, 0.3)), band((0.5, 0.5, 0.6)), duration_s, marker)


def walking_foot(seed: int, duration_s: float = 16.0) -> tuple[Scene, Float]:
    """Return a walking foot after rest, and the phase of the cycle at each tick (swing from 0.6), page 4.2."""
    rng = np.random.default_rng([seed, 131])
    grid = np.arange(0.0, duration_s + 0.2, 0.01)
    cycle = np.maximum(grid - STILL_S, 0.0) / 1.1
    number, phase = np.floor(cycle), cycle % 1.0
    s = np.clip((phase - 0.6) / 0.4, 0.0, 1.0)
    step = s**3 * (10 - 15 * s + 6 * s * s)
    lift = np.clip((phase - 0.55) / 0.45, 0.0, 1.0)

    def ramp(first: float, last: float) -> Float:
        u = np.clip((phase - first) / (last - first), 0.0, 1.0)
        return np.asarray(u**3 * (10 - 15 * u + 6 * u * u))

    path = np.column_stack(
        [1.3 * (number + step), np.zeros_like(grid), 0.12 * 64 * lift**3 * (1 - lift) ** 3]
    )
    pitch = np.radians(
        -45.0 * (ramp(0.4, 0.62) - ramp(0.62, 0.82)) + 20.0 * (ramp(0.72, 0.9) - ramp(0.9, 1.0))
    )
    turn = np.column_stack([np.zeros_like(grid), -pitch, np.zeros_like(grid)])
    scene = measured(rng, grid, path, turn, duration_s, MARKER_SIGMA_M)
    return scene, (np.maximum(scene.time_s - STILL_S, 0.0) / 1.1) % 1.0


def measured(
    rng: np.random.Generator, grid: Float, path_m: Float, turn_rad: Float, duration_s: float, marker: float
) -> Scene:
    """Return what a module and a camera measure of a path and rotation vectors, noise and offsets of page 4.2.

    Accelerometer 0.02 m/s^2, gyroscope 0.005 rad/s a sample (the page's choice for a strict pass), offsets 0.02 m/s^2
    and 0.005 rad/s a trial; the gyroscope is zeroed at rest.
    """
    path = make_interp_spline(grid, path_m, k=5)
    attitude = RotationSpline(grid, Rotation.from_rotvec(turn_rad))
    t = np.arange(round(duration_s / STEP_S), dtype=np.float64) * STEP_S
    r = attitude(t)
    acceleration = np.asarray(path(t, 2))
    felt = r.inv().apply(acceleration + np.array([0.0, 0.0, GRAVITY_MPS2]))
    early = np.maximum(t - 1e-4, 0.0)
    turned = (attitude(early).inv() * attitude(t + 1e-4)).as_rotvec() / ((t + 1e-4) - early)[:, None]
    gyroscope = turned + rng.normal(0.0, 0.005, 3) + rng.normal(0.0, 0.005, turned.shape)
    gyroscope = gyroscope - gyroscope[t < 1.5].mean(axis=0)
    accelerometer = felt + rng.normal(0.0, 0.02, 3) + rng.normal(0.0, 0.02, felt.shape)
    truth = np.asarray(path(t))
    seen = truth + rng.normal(0.0, marker, truth.shape)
    chunk = OpticalChunk(0, STEP_S, gyroscope, accelerometer, seen)
    return Scene(chunk, truth, acceleration, rotation.from_scipy(r), t)
