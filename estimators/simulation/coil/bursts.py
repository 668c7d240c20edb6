"""A source that fires in fixed bursts, and the movements of Roetenberg's chapters 5 and 6 (page ch. 6, 4.2)."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation, RotationSpline

from estimators.errors import SetupError
from estimators.recording import Float
from estimators.simulation.coil.motion import RelativeMotion, smoothstep
from estimators.simulation.coil.scene import RelativeScene

BURST_MOVEMENTS = (
    "bench",
    "flexion",
    "lateral",
    "rotation",
    "walk_back",
    "arm",
    "arm_flexion",
    "walk_arm",
    "walk_leg",
)
_PI2 = 2.0 * np.pi


def burst_motion(movement: str, duration_s: float, seed: int) -> RelativeMotion:
    """Return a movement of chapter 6 of the thesis; it ramps in between 2 s and 3 s."""
    if movement not in BURST_MOVEMENTS:
        raise SetupError(f"no movement {movement}; known are {', '.join(BURST_MOVEMENTS)}")
    t = np.arange(0.0, duration_s + 0.2, 0.02)
    g = smoothstep(t - 2.0)
    rng = np.random.default_rng([seed, 107])
    phase = rng.uniform(0.0, 0.5)
    zero = np.zeros_like(t)
    source, place_source = Rotation.identity(len(t)), np.zeros((len(t), 3))
    if movement == "bench":
        r = 0.375 - 0.225 * np.cos(_PI2 * 0.06 * t + phase * g) * g - 0.1 * (1.0 - g)
        azimuth, elevation = 0.6 * np.sin(_PI2 * 0.07 * t) * g, 0.9 + 0.3 * np.sin(_PI2 * 0.08 * t) * g
        place = r[:, None] * np.stack(
            [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)], 1
        )
        rates, phases = rng.uniform(0.03, 0.15, (4, 3)), rng.uniform(0.0, _PI2, (4, 3))
        turns = np.sin(_PI2 * rates * t[:, None, None] + phases).sum(axis=1) * 0.4 / np.sqrt(2.0)
        sensor = Rotation.from_rotvec(turns * g[:, None])
    elif movement in ("flexion", "lateral", "rotation"):
        axis = {"flexion": "y", "lateral": "x", "rotation": "z"}[movement]
        angle = np.radians(45.0) * (1.0 - np.cos(_PI2 * 0.15 * t + phase)) * g
        sensor, source = (Rotation.from_euler(axis, (k * angle)[:, None]) for k in (1.0, 0.55))
        place_source = 0.05 * np.stack([np.sin(0.5 * angle), zero, np.cos(0.5 * angle) - 1.0], axis=1)
        along = sensor.apply(np.tile([0.06, -0.05, 0.45], (len(t), 1)))
        place = place_source + along * (1.0 + 0.04 * np.sin(angle))[:, None]
    elif movement in ("arm", "arm_flexion"):
        # Abduction about the forward axis, flexion about the axis to the left.
        angle = np.radians(45.0) * (1.0 - np.cos(_PI2 * 0.2 * t + phase)) * g
        sway = _PI2 * 0.25 * t
        source = Rotation.from_euler("x", (np.radians(3.0) * np.sin(sway) * g)[:, None])
        place_source = 0.01 * (g * np.sin(sway))[:, None] * np.array([1.0, 1.0, 0.5])
        away, down = 0.13 * np.sin(angle), 0.42 - 0.13 * np.cos(angle)
        if movement == "arm":
            offset = np.stack([0.05 + zero, 0.20 + away, down], axis=1)
            sensor = source * Rotation.from_euler("x", angle[:, None])
        else:
            offset = np.stack([0.05 + away, 0.20 + zero, down], axis=1)
            sensor = source * Rotation.from_euler("y", -angle[:, None])
        place = place_source + source.apply(offset)
    else:
        w = _PI2 * 0.9 * t + phase
        turns = np.radians(np.stack([4.0 * np.sin(w), 3.0 * np.sin(2 * w), 6.0 * np.cos(w)], 1)) * g[:, None]
        source = Rotation.from_euler("ZYX", turns[:, ::-1])
        walked = 1.2 * np.concatenate([[0.0], np.cumsum(0.5 * (g[1:] + g[:-1]) * 0.02)])
        place_source = np.stack([walked, zero, 0.025 * np.sin(2 * w) * g], axis=1)
        sensor, offset = _walking(movement, w, g, source)
        place = place_source + offset
    return RelativeMotion(
        RotationSpline(t, source),
        make_interp_spline(t, place_source, k=5),
        RotationSpline(t, sensor),
        make_interp_spline(t, place, k=5),
    )


def _walking(movement: str, w: Float, g: Float, source: Rotation) -> tuple[Rotation, Float]:
    """Return attitude of the sensor and where it is from the source, in the world, at phases `w` of the stride."""
    zero = np.zeros_like(w)
    if movement == "walk_leg":
        angle = np.radians(22.0) * np.sin(w) * g
        offset = np.stack([0.12 + 0.38 * np.sin(angle), -0.12 + zero, -0.12 - 0.38 * np.cos(angle)], axis=1)
        return Rotation.from_euler("y", (-angle)[:, None]), offset
    if movement == "walk_back":
        # The trunk turns against the pelvis and nods twice a stride.
        angles = np.stack([-4.0 * np.sin(w), 2.0 * np.sin(2 * w + 0.5), -2.0 * np.cos(w)], axis=1)
        trunk = Rotation.from_euler("ZYX", np.radians(angles) * g[:, None])
        return trunk, trunk.apply(np.tile([0.06, -0.05, 0.45], (len(w), 1)))
    arm = Rotation.from_euler("y", (np.radians(-25.0) * np.sin(w) * g)[:, None])
    shoulder = source.apply(np.tile([0.05, 0.20, 0.42], (len(w), 1)))
    return arm, shoulder + arm.apply(np.tile([0.0, 0.0, -0.13], (len(w), 1)))


def fire_bursts(
    scene: RelativeScene,
    current_a: float = 1.5,
    first_s: float = 1.0,
    pulse_s: float = 0.06,
    slot_s: float = 0.0625,
    cycle_s: float = 0.6,
    full_scale_t: float = np.inf,
) -> tuple[Float, NDArray[np.int64]]:
    """Let a source fire X, Y, Z in fixed cycles.

    Returns
    -------
    magnetometer_t : ndarray, shape (K, 3)
        Of the sensor, pulses included.
    coil_state : ndarray of int, shape (K,)
    """
    if not 0.0 < pulse_s <= slot_s or cycle_s < 3.0 * slot_s:
        raise SetupError("a pulse must fit into its slot and three slots into a cycle")
    within = np.where(scene.time_s >= first_s - 1e-9, np.mod(scene.time_s - first_s + 1e-9, cycle_s), np.inf)
    state = np.zeros(len(within), dtype=np.int64)
    for coil in range(3):
        begin = coil * slot_s
        state[(within >= begin) & (within < begin + pulse_s)] = coil + 1
    on = np.flatnonzero(state)
    field = scene.ambient_t.copy()
    field[on] += current_a * scene.per_ampere_t[on, state[on] - 1]
    return np.clip(field, -full_scale_t, full_scale_t), state
