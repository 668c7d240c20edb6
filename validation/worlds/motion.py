"""Motions of a worn sensor: attitude and place along one path, in fine steps.

Each motion is a function of its own time, which stands still in rests: turning and place belong together.
"""

from collections.abc import Callable
from typing import Final

import numpy as np
from scipy import signal

from estimators import rotation
from estimators.recording import Float
from validation.worlds.conditions import Conditions
from validation.worlds.curves import noise, own_time, smooth_step, targets, vibration
from validation.worlds.gait import foot, pelvis, shank

Moved = tuple[Float, Float]
"""Attitude of the segment, shape (N, 4), and place, shape (N, 3), metres."""
_LEAVES_S: Final = (2.0, 4.0)


def moved(conditions: Conditions, time_s: Float, generator: np.random.Generator) -> Moved:
    """Return attitude and place of the sensor in earth axes (x east, y north, z up).

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Even fine steps; the recording begins at zero.

    Returns
    -------
    q_earth_sensor : ndarray, shape (N, 4)
    place_m : ndarray, shape (N, 3)
    """
    if conditions.motion == "none":
        held = rotation.normalize(generator.normal(size=4))
        return np.tile(held, (len(time_s), 1)), np.zeros((len(time_s), 3))
    own_s = own_time(time_s, generator, conditions.rest_s)
    q, place = _MOTIONS[conditions.motion](own_s, generator)
    heading = rotation.about_z(generator.uniform(-np.pi, np.pi))
    q, place = rotation.multiply(heading, q), rotation.rotate(heading, place)
    if conditions.field == "iron at the start" and conditions.motion not in ("foot", "shank", "pelvis"):
        place = place + _leaving(time_s, generator, conditions.rest_s)
    q = rotation.multiply(q, rotation.normalize(generator.normal(size=4)))
    if conditions.has_soft_tissue:
        q, place = _on_tissue(q, place, float(time_s[1] - time_s[0]), generator)
    return q, place


def acceleration(place_m: Float, step_s: float) -> Float:
    """Return the second derivative of a place by central differences, shape (N, 3); the ends are held."""
    inner = (place_m[2:] - 2.0 * place_m[1:-1] + place_m[:-2]) / step_s**2
    return np.concatenate((inner[:1], inner, inner[-1:]))


def _free_turning(own_s: Float, generator: np.random.Generator) -> Float:
    """Turn about all axes around an attitude that changes slowly."""
    knot_s = generator.choice([0.25, 0.4, 0.7, 1.2])
    size_rad = generator.uniform(0.15, 1.0)
    posture = rotation.normalize(noise(own_s, generator, 4, 8.0))
    return rotation.multiply(posture, rotation.exp(size_rad * noise(own_s, generator, 3, knot_s)))


def _hand(own_s: Float, generator: np.random.Generator) -> Moved:
    q = _free_turning(own_s, generator)
    knot_s = generator.uniform(0.35, 0.9)
    size_m = generator.uniform(0.5, 5.0) * (knot_s / 2.5) ** 2
    return q, size_m * noise(own_s, generator, 3, knot_s)


def _reaching(own_s: Float, generator: np.random.Generator) -> Moved:
    """Reach from target to target; the wrist turns along with the way."""
    points = np.hstack(
        (generator.uniform(-0.35, 0.35, size=(12, 3)), generator.uniform(-0.8, 0.8, size=(12, 3)))
    )
    way = targets(own_s, generator, points, generator.uniform(0.5, 1.0))
    return rotation.exp(way[:, 3:]), way[:, :3]


def _turning(own_s: Float, generator: np.random.Generator) -> Moved:
    return _free_turning(own_s, generator), np.zeros((len(own_s), 3))


def _pendulum(own_s: Float, generator: np.random.Generator) -> Moved:
    """Swing about a fixed place at constant length; some swing in circles, some with a size that comes and goes."""
    turn = 2.0 * np.pi * generator.uniform(0.4, 1.3)
    sway = generator.choice([0.0, 0.4]) * np.sin(2.0 * np.pi * generator.uniform(0.03, 0.08) * own_s)
    size = np.radians(generator.uniform(20.0, 60.0)) * (1.0 + sway)
    swing = size * np.sin(turn * own_s)
    aside = generator.choice([0.0, 0.2, 1.0]) * size * np.cos(turn * own_s)
    limb = rotation.multiply(rotation.about_x(aside), rotation.about_y(swing))
    return limb, rotation.rotate(limb, [0.0, 0.0, -generator.uniform(0.25, 0.9)])


def _trunk(own_s: Float, generator: np.random.Generator) -> Moved:
    """Bend and turn above the hips."""
    angles = noise(own_s, generator, 3, generator.uniform(0.8, 2.0)) * [0.15, 0.3, 0.4]
    q = rotation.about_z(angles[:, 2])
    q = rotation.multiply(
        q, rotation.multiply(rotation.about_y(angles[:, 1]), rotation.about_x(angles[:, 0]))
    )
    return q, rotation.rotate(q, [0.08, 0.0, generator.uniform(0.25, 0.5)])


def _impacts(own_s: Float, generator: np.random.Generator) -> Moved:
    """Move a hand that knocks, claps and sets things down."""
    q, place = _hand(own_s, generator)
    starts = np.cumsum(generator.uniform(0.5, 3.0, int(own_s[-1] / 0.5) + 1))
    peaks = generator.uniform(20.0, 120.0, len(starts))
    stroke = vibration(own_s, starts, peaks, generator.uniform(12.0, 25.0))
    way = rotation.normalize(generator.normal(size=4))
    place = place + stroke[:, None] * rotation.rotate(way, [0.0, 0.0, 1.0])
    jolt = 8.0 * stroke[:, None] * generator.normal(size=3)
    return rotation.multiply(q, rotation.exp(jolt)), place


_MOTIONS: Final[dict[str, Callable[[Float, np.random.Generator], Moved]]] = {
    "hand": _hand,
    "reaching": _reaching,
    "foot": foot,
    "shank": shank,
    "pelvis": pelvis,
    "trunk": _trunk,
    "turning": _turning,
    "pendulum": _pendulum,
    "impacts": _impacts,
}


def _leaving(time_s: Float, generator: np.random.Generator, rest_s: float) -> Float:
    """Return the way of a wearer who goes away from the place of the start, soon after the rest."""
    angle = generator.uniform(-np.pi, np.pi)
    way_m = generator.uniform(1.0, 2.5) * np.array([np.cos(angle), np.sin(angle), 0.0])
    start_s = rest_s + generator.uniform(0.0, 4.0)
    share = smooth_step((time_s - start_s) / generator.uniform(*_LEAVES_S))
    return np.asarray(share[:, None] * way_m)


def _on_tissue(q_bone: Float, place_m: Float, step_s: float, generator: np.random.Generator) -> Moved:
    """Return the sensor on soft tissue: a damped mass on springs that the acceleration of the bone drives.

    Notes
    -----
    In bone axes ``u'' + 2 z w u' + w^2 u = -a``; the sensor shifts by u along the skin and tilts by u over the depth
    of the tissue.
    """
    turn = 2.0 * np.pi * generator.uniform(5.0, 12.0)
    damping = generator.uniform(0.15, 0.5)
    top, bottom = signal.bilinear([-1.0], [1.0, 2.0 * damping * turn, turn**2], 1.0 / step_s)
    push = rotation.rotate(rotation.conjugate(q_bone), acceleration(place_m, step_s))
    normal = rotation.rotate(rotation.normalize(generator.normal(size=4)), [0.0, 0.0, 1.0])
    push -= np.outer(push @ normal, normal)
    shift = signal.lfilter(top, bottom, push, axis=0)
    tilt = np.cross(normal, shift) / generator.uniform(0.04, 0.15)
    q = rotation.multiply(q_bone, rotation.exp(tilt))
    return q, place_m + rotation.rotate(q_bone, shift)
