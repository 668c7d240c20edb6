"""From the orientation and specific force of a trunk sensor to lean and horizontal acceleration."""

import math
from typing import Final

import numpy as np
import scipy

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

CROSSOVER_HZ: Final = 0.2
"""Above it the gyroscope says how somebody leans, below the accelerometer."""
_UP = np.array([0.0, 0.0, 1.0])
_FORWARD = np.array([1.0, 0.0, 0.0])


def posture(q_room_segment: Float, specific_force_segment_mps2: Float) -> tuple[Float, Float]:
    """Return how far a segment leans and how it accelerates horizontally, in axes that turn with the person.

    Parameters
    ----------
    q_room_segment : ndarray, shape (..., 4)
        Segment axes: x forward, y left, z up in upright stance. Its heading does not matter.
    specific_force_segment_mps2 : ndarray, shape (..., 3)
        What the accelerometer reads, turned into segment axes, m/s^2.

    Returns
    -------
    lean_rad : ndarray, shape (..., 2)
        Inclination in the sagittal plane (forward positive) and the frontal plane (left positive), rad:
        `atan2(-u_x, u_z)` and `atan2(-u_y, u_z)` of the vertical u in segment axes.
    acceleration_mps2 : ndarray, shape (..., 2)
        Horizontal acceleration freed of gravity, `R f - g z`, along where the segment faces and to its left, m/s^2.
    """
    up = rotation.rotate(rotation.conjugate(q_room_segment), _UP)
    lean = np.stack(
        [np.arctan2(-up[..., 0], up[..., 2]), np.arctan2(-up[..., 1], up[..., 2])],
        axis=-1,
    )
    moved = rotation.rotate(q_room_segment, specific_force_segment_mps2)
    faces = rotation.rotate(q_room_segment, _FORWARD)[..., :2]
    ahead = faces / np.linalg.norm(faces, axis=-1, keepdims=True)
    forward = np.sum(ahead * moved[..., :2], axis=-1)
    left = ahead[..., 0] * moved[..., 1] - ahead[..., 1] * moved[..., 0]
    return lean, np.stack([forward, left], axis=-1)


def sway_acceleration(lean_rad: Float, acceleration_mps2: Float) -> Float:
    """Return the acceleration that studies of sway report, shape (N, 2), m/s^2, mean removed.

    Parameters
    ----------
    lean_rad, acceleration_mps2 : ndarray, shape (N, 2)
        Of one trial, from `posture`.

    Notes
    -----
    Moe-Nilssen (1998), used by Mancini et al. (2012, ISway): the accelerometer's axes are levelled by their *mean*
    inclination over the trial, so that gravity enters as the person leans, `a - g sin(lean - mean lean)`. An error of
    the orientation cancels in this difference, to first order.
    """
    leaning = lean_rad - lean_rad.mean(axis=0)
    found = acceleration_mps2 - GRAVITY_MPS2 * np.sin(leaning)
    return np.asarray(found - found.mean(axis=0))


def sway_lean(acceleration_mps2: Float, rate_radps: Float, rate_hz: float, height_m: float) -> Float:
    """Return the lean over a trial of quiet standing, shape (N, 2), rad, mean removed.

    Parameters
    ----------
    acceleration_mps2 : ndarray, shape (N, 2)
        From `sway_acceleration`.
    rate_radps : ndarray, shape (N, 2)
        How fast the segment leans forward and left, as the gyroscope reads it, its constant error included.
    height_m : float
        Of the sensor above the ankles.

    Notes
    -----
    The orientation of a filter for all movements is not used: it takes part of the sway for errors of the gyroscope
    and shows a tenth too little of it. Here the gyroscope's integral counts above 0.2 Hz, and below what the
    accelerometer says of a stiff link on the ankles (inverted pendulum, Winter et al. 1998), `-a / (g + h w^2)`:
    the shares are `(w / w_c)^2 / (1 + (w / w_c)^2)` and the rest to 1, all without delay. Below 0.2 Hz `h w^2` is less
    than a sixth of g, so that who bends at the hips, or whose height is not known well, is hardly seen wrongly.
    """
    hanging = _without_delay(acceleration_mps2, math.sqrt(GRAVITY_MPS2 / height_m) / (2.0 * math.pi), rate_hz)
    turned = scipy.integrate.cumulative_trapezoid(
        rate_radps - rate_radps.mean(axis=0), dx=1.0 / rate_hz, axis=0
    )
    turned = np.concatenate([np.zeros((1, 2)), turned])
    slow = _without_delay(-hanging / GRAVITY_MPS2 - turned, CROSSOVER_HZ, rate_hz)
    found = turned + slow
    return np.asarray(found - found.mean(axis=0))


def lean_noise(frequency_hz: Float, height_m: float, acceleration_floor: Float, rate_floor: Float) -> Float:
    """Return the density of noise that white noise of both sensors leaves in `sway_lean`, shape (F, 2), rad^2/Hz.

    Parameters
    ----------
    frequency_hz : ndarray, shape (F,)
        Above 0.
    acceleration_floor, rate_floor : ndarray, shape (2,)
        Densities, (m/s^2)^2/Hz and (rad/s)^2/Hz.
    """
    omega = 2.0 * np.pi * frequency_hz[:, None]
    share = omega**2 / (omega**2 + (2.0 * np.pi * CROSSOVER_HZ) ** 2)
    turned = share**2 * rate_floor / omega**2
    hanging = (1.0 - share) ** 2 * acceleration_floor / (GRAVITY_MPS2 + height_m * omega**2) ** 2
    return np.asarray(turned + hanging)


def _without_delay(values: Float, corner_hz: float, rate_hz: float) -> Float:
    """Return values times `1 / (1 + (f / corner)^2)`: a first-order low-pass forwards and backwards."""
    sections = scipy.signal.butter(1, corner_hz, fs=rate_hz, output="sos")
    length = min(len(values) - 1, round(2.0 * rate_hz / corner_hz))
    return np.asarray(scipy.signal.sosfiltfilt(sections, values, axis=0, padlen=length))
