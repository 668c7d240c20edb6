"""Movements of a body with a magnetic source: pose of source and sensor over time (method page on relative pose, 7.1).

World frame: x forward, y left, z up. Every movement blends in from rest between 4 s and 5 s.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.spatial.transform import Rotation, RotationSpline

from estimators.errors import SetupError
from estimators.recording import Float

Poses = tuple[Rotation, Float, Rotation, Float]
"""Source attitude and place, sensor attitude and place, in the world."""

_GRID_S = 0.02
_PI2 = 2.0 * np.pi


def smoothstep(x: Float) -> Float:
    """Return the quintic step from 0 to 1 with two vanishing derivatives at both ends."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x * x))


def _turned(rotations: Rotation, vector: Float | list[float]) -> Float:
    return np.asarray(rotations.apply(np.tile(vector, (len(rotations), 1))))


def _about(axis: str, angle: Float) -> Rotation:
    return Rotation.from_euler(axis, angle[:, None])


def _sway(phases: Float, t: Float, g: Float) -> Float:
    """Return a centimetre rms of slow sway."""
    rates = np.array([0.21, 0.27, 0.17])
    return np.asarray(0.01 * np.sqrt(2.0) * g[:, None] * np.sin(_PI2 * rates * t[:, None] + phases))


def _random(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    a, b, d, c = rng.uniform(0.0, _PI2, 4)
    r = 0.38 + 0.14 * g * np.sin(_PI2 * 0.11 * t + a)
    azimuth = c + 1.6 * g * np.sin(_PI2 * 0.13 * t + b)
    elevation = 0.6 + 0.45 * g * np.sin(_PI2 * 0.17 * t + d)
    place = r[:, None] * np.stack(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)], axis=1
    )
    rates, phases = rng.uniform(0.05, 0.5, (6, 3)), rng.uniform(0.0, _PI2, (6, 3))
    vector = np.sin(_PI2 * rates * t[:, None, None] + phases).sum(axis=1)
    vector *= 0.5 / np.sqrt(9.0) * g[:, None]
    fixed = Rotation.identity(len(t))
    return fixed, np.zeros((len(t), 3)), Rotation.from_rotvec(vector), place


def _trunk(t: Float, g: Float, axis: str, angle: Float, share: float) -> Poses:
    pelvis, trunk = _about(axis, share * angle), _about(axis, angle)
    middle = _about(axis, 0.7 * angle)
    source = _turned(pelvis, [-0.08, 0.0, 0.12])
    return pelvis, source, trunk, source + _turned(middle, [0.03, 0.02, 0.43])


def _flexion(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    w = _PI2 * 0.25 * t + rng.uniform(0.0, 0.3)
    return _trunk(t, g, "y", np.radians(35.0) * (1.0 - np.cos(w)) * g, 0.4)


def _rotation(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    w = _PI2 * 0.25 * t + rng.uniform(0.0, 0.3)
    return _trunk(t, g, "z", np.radians(40.0) * np.sin(w) * g, 0.35)


def _hip(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    w = _PI2 * 0.3 * t + rng.uniform(0.0, 0.3)
    pelvis = _about("y", np.radians(4.0) * np.sin(w) * g)
    thigh = _about("y", np.radians(-30.0) * (1.0 - np.cos(w)) * g)
    source = _sway(rng.uniform(0.0, _PI2, 3), t, g)
    sensor = source + _turned(pelvis, [0.10, 0.12, -0.10]) + _turned(thigh, [0.06, 0.02, -0.33])
    return pelvis, source, thigh, sensor


def _shoulder(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    w = _PI2 * 0.3 * t + rng.uniform(0.0, 0.3)
    trunk = _about("x", np.radians(3.0) * np.sin(w) * g)
    arm = _about("x", np.radians(40.0) * (1.0 - np.cos(w)) * g)
    source = _sway(rng.uniform(0.0, _PI2, 3), t, g)
    sensor = source + _turned(trunk, [0.08, 0.20, 0.40]) + _turned(arm, [0.0, 0.04, -0.15])
    return trunk, source, arm, sensor


def _pelvis_walking(t: Float, g: Float, w: Float) -> tuple[Rotation, Float]:
    # Distance walked: the integral of the blend, close enough by a cumulative sum on the even grid.
    walked = 1.1 * np.concatenate([[0.0], np.cumsum(0.5 * (g[1:] + g[:-1]) * np.diff(t))])
    place = 0.02 * g[:, None] * np.stack([np.sin(2 * w), np.sin(w), np.cos(2 * w)], axis=1)
    place[:, 0] += walked
    angles = (
        np.radians(np.stack([5.0 * np.sin(w), 2.0 * np.sin(2 * w), 5.0 * np.cos(w)], axis=1)) * g[:, None]
    )
    return Rotation.from_euler("ZYX", angles), place


def _walk_back(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    w = _PI2 * 0.9 * t + rng.uniform(0.0, 0.3)
    pelvis, source = _pelvis_walking(t, g, w)
    angles = np.stack([-4.0 * np.sin(w), 2.0 * np.sin(2 * w + 0.5), -2.0 * np.cos(w)], axis=1)
    trunk = Rotation.from_euler("ZYX", np.radians(angles) * g[:, None])
    bent = np.stack([0.0 * w, 2.0 * np.sin(2 * w), 1.5 * np.cos(w)], axis=1)
    sensor = source + _turned(Rotation.from_euler("ZYX", np.radians(bent) * g[:, None]), [0.03, 0.02, 0.43])
    return pelvis, source, trunk, sensor


def _walk_leg(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    w = _PI2 * 0.9 * t + rng.uniform(0.0, 0.3)
    pelvis, source = _pelvis_walking(t, g, w)
    angles = np.stack([4.0 * np.sin(w), -5.0 - 22.0 * np.sin(w), 3.0 * np.cos(w)], axis=1)
    thigh = Rotation.from_euler("ZYX", np.radians(angles) * g[:, None])
    sensor = source + _turned(pelvis, [0.10, 0.12, -0.10]) + _turned(thigh, [0.06, 0.02, -0.33])
    return pelvis, source, thigh, sensor


def _foot(t: Float, g: Float, phase: float, side: float, rest: float) -> tuple[Rotation, Float]:
    """One foot of a walker: stance 62 %, quintic swing, clearance 7 cm, pitch at push-off and strike (page 7.4)."""
    begun = 5.0
    cycle = np.maximum(0.0, (t - begun) / 1.1 + phase)
    number, part = np.floor(cycle), cycle - np.floor(cycle)
    swing = np.clip((part - 0.62) / 0.38, 0.0, 1.0)
    x = 1.2 * (number + smoothstep(swing) - rest)
    z = 0.07 * 64.0 * (swing * (1.0 - swing)) ** 3
    # Heel off from 45 % of the cycle on, strike flattened in the first 10 % of stance.
    rise = smoothstep((part - 0.45) / 0.2)
    fall = smoothstep((part - 0.65) / 0.3)
    pitch = 55.0 * rise - 75.0 * fall + 20.0 * smoothstep((part - 0.95) / 0.1)
    landed = np.where(number >= 1.0, -20.0 + 20.0 * smoothstep((part + 0.05) / 0.1), 0.0)
    pitch = np.where(part < 0.05, np.where(number >= 1.0, landed, 0.0), pitch)
    active = (cycle > 0.0) & (t > begun)
    # The foot that begins within its stance is not thrown into its pitch.
    pitch, z = np.where(active, pitch * smoothstep((t - begun) / 0.6), 0.0), np.where(active, z, 0.0)
    rotation = Rotation.from_euler(
        "ZY", np.stack([np.full_like(t, np.radians(7.0 * side)), np.radians(pitch)], 1)
    )
    return rotation, np.stack([x, np.full_like(t, 0.09 * side), z], axis=1)


def _feet(t: Float, g: Float, rng: np.random.Generator) -> Poses:
    left, place_left = _foot(t, g, 0.0, 1.0, 0.0)
    right, place_right = _foot(t, g, 0.5, -1.0, 0.0)
    return left, place_left, right, place_right


MOVEMENTS: dict[str, Callable[[Float, Float, np.random.Generator], Poses]] = {
    "random": _random,
    "flexion": _flexion,
    "rotation": _rotation,
    "hip": _hip,
    "shoulder": _shoulder,
    "walk_back": _walk_back,
    "walk_leg": _walk_leg,
    "feet": _feet,
}


@dataclass(frozen=True)
class RelativeMotion:
    """Smooth poses of source and sensor, at any time."""

    source_attitude: RotationSpline
    source_place: BSpline
    sensor_attitude: RotationSpline
    sensor_place: BSpline


def relative_motion(
    movement: str,
    duration_s: float,
    seed: int,
    pause_s: tuple[float, float] | None = None,
    begin_s: float = 4.0,
    end_s: float | None = None,
) -> RelativeMotion:
    """Return a movement of the method page.

    Parameters
    ----------
    movement : str
        Key of `MOVEMENTS`.
    seed : int
        Draws phases, and paths of the random movement.
    pause_s : (float, float), optional
        Time stands still between these: the movement slows down within a second, rests, and goes on.
    begin_s : float
        When the movement begins to blend in; it takes a second.
    end_s : float, optional
        When it begins to blend out; five seconds later the pose of the beginning is reached, at rest.
    """
    if movement not in MOVEMENTS:
        raise SetupError(f"no movement {movement}; known are {', '.join(MOVEMENTS)}")
    grid = np.arange(0.0, duration_s + 0.2, _GRID_S)
    g = smoothstep(grid - begin_s)
    if end_s is not None:
        g *= 1.0 - smoothstep((grid - end_s) / 5.0)
    warped = grid
    if pause_s is not None:
        speed = 1.0 - smoothstep(grid - pause_s[0]) + smoothstep(grid - pause_s[1])
        warped = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * _GRID_S)])
    source, source_place, sensor, sensor_place = MOVEMENTS[movement](
        warped, g, np.random.default_rng([seed, 61])
    )
    return RelativeMotion(
        RotationSpline(grid, source),
        make_interp_spline(grid, source_place, k=5),
        RotationSpline(grid, sensor),
        make_interp_spline(grid, sensor_place, k=5),
    )
