"""Axes of joints from how two segments turn against each other."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

from estimators import rotation
from estimators.errors import CalibrationError
from estimators.recording import Float
from estimators.sentences import say

SKIN_RAD: Final = math.radians(3.0)
"""How far the skin turns over the bone within a movement; a share of this over the range tilts an axis."""
_MOVING_RADPS: Final = 0.15
_LEAST_SIGMA_RAD: Final = math.radians(0.5)
_RATE_SIGMA_RADPS: Final = 1.0
_TRUST_RAD: Final = math.radians(6.0)
_INDEPENDENT_HZ: Final = 20.0
"""Skin moves with the joint, so samples of one excursion err alike: the sigma above is large for that."""


@dataclass(frozen=True)
class AxisEstimate:
    """The axis of one movement.

    Attributes
    ----------
    name : str
        Of the movement.
    axis : ndarray, shape (3,)
        Unit vector in the frame of the rates; positive in the direction of the larger excursion from the start.
    range_rad : float
        How far it turned there and back.
    sigma_rad : float
        Expected error of the direction, per axis across it: what else moved, and skin over bone.
    """

    name: str
    axis: Float
    range_rad: float
    sigma_rad: float


def principal_axis(name: str, rate: Float, time_step_s: float) -> AxisEstimate:
    """Find the axis about which most of a movement happens.

    Parameters
    ----------
    name : str
        Of the movement, with the side at its end: `elbow_flexion_right`.
    rate : ndarray, shape (N, 3)
        rad/s in the frame in which the axis is fixed; NaN is skipped.

    Raises
    ------
    CalibrationError
        If nothing moved.
    """
    rate = rate[np.isfinite(rate).all(axis=1)]
    moving = rate[np.linalg.norm(rate, axis=1) > _MOVING_RADPS] if len(rate) else rate
    if len(moving) * time_step_s < 0.5:
        kind, _, side = name.rpartition("_")
        raise CalibrationError(say("calibration.hardly_moved", side=side, kind=kind), redo=[kind])
    powers, vectors = np.linalg.eigh(moving.T @ moving)
    axis = vectors[:, -1]
    angle = np.cumsum(rate @ axis) * time_step_s
    # Where the sign is open, the larger excursion from the start is the movement that was asked for.
    if -angle.min() > angle.max():
        axis, angle = -axis, -angle
    span = float(angle.max() - angle.min())
    excursions = max(1.0, float(np.abs(rate @ axis).sum()) * time_step_s / max(span, 1e-6))
    across = math.sqrt(max(float(powers[0] + powers[1]), 0.0) / 2.0 / float(powers[2]))
    sigma = math.hypot(across / math.sqrt(excursions), SKIN_RAD / max(span, 1e-3))
    return AxisEstimate(name, np.asarray(axis), span, max(sigma, _LEAST_SIGMA_RAD))


def refine_two_axes(
    first: AxisEstimate,
    second: AxisEstimate,
    q_earth_first: Float,
    q_earth_second: Float,
    rate_earth: Float,
    time_step_s: float,
) -> tuple[AxisEstimate, AxisEstimate]:
    """Improve the two axes of a joint together: all its turning lies in the plane of both.

    Parameters
    ----------
    first, second : AxisEstimate
        Of the axis fixed in the proximal and of that fixed in the distal sensor.
    q_earth_first, q_earth_second : ndarray, shape (N, 4)
        Orientations in one common earth frame.
    rate_earth : ndarray, shape (N, 3)
        Rate of the distal against the proximal segment, earth axes.

    Returns
    -------
    tuple of AxisEstimate
        Same ranges and sigmas; a person who turns the palm while bending the elbow no longer tilts them.

    Notes
    -----
    Minimises the component of the relative rate along the normal of both axes, as for two-degree-of-freedom
    joints in Laidig, Mueller and Seel (2017); the start holds with a standard deviation of 6 degrees.
    """
    stride = max(1, round(1.0 / (_INDEPENDENT_HZ * time_step_s)))
    usable = np.isfinite(rate_earth).all(axis=1) & (np.linalg.norm(rate_earth, axis=1) > _MOVING_RADPS)
    index = np.flatnonzero(usable)[::stride]
    if len(index) < 20:
        return first, second
    turns = rotation.to_matrix(q_earth_first[index]), rotation.to_matrix(q_earth_second[index])
    rates = rate_earth[index]
    frames = [_across(axis.axis) for axis in (first, second)]

    def axes(x: Float) -> tuple[Float, Float]:
        return (
            _unit(first.axis + frames[0] @ x[:2]),
            _unit(second.axis + frames[1] @ x[2:]),
        )

    def residual(x: Float) -> Float:
        one, other = axes(x)
        normal = np.cross(turns[0] @ one, turns[1] @ other)
        out = np.sum(normal * rates, axis=1) / _RATE_SIGMA_RADPS
        return np.concatenate((out, x / _TRUST_RAD))

    found = scipy.optimize.least_squares(residual, np.zeros(4), loss="soft_l1")
    one, other = axes(found.x)
    return (
        AxisEstimate(first.name, one, first.range_rad, first.sigma_rad),
        AxisEstimate(second.name, other, second.range_rad, second.sigma_rad),
    )


def frame_from(directions: Sequence[tuple[Float, Float, float]]) -> tuple[Float, float, float]:
    """Find the segment frame in a sensor from directions known in both.

    Parameters
    ----------
    directions : sequence of (in segment, in sensor, sigma_rad)
        Unit vectors, at least two that are not parallel; weighted by 1 / sigma^2.

    Returns
    -------
    q_sensor_segment : ndarray, shape (4,)
    sigma_rad : float
        Expected error about the axis that is known least.
    disagreement_rad : float
        Weighted RMS angle between the directions and the frame found.
    """
    segment = np.stack([d[0] for d in directions])
    sensor = np.stack([d[1] for d in directions])
    weights = np.array([1.0 / d[2] ** 2 for d in directions])
    turn, _ = scipy.spatial.transform.Rotation.align_vectors(sensor, segment, weights=weights)
    angles = np.arccos(np.clip(np.sum(turn.apply(segment) * sensor, axis=1), -1.0, 1.0))
    disagreement = math.sqrt(float(np.sum(weights * angles**2) / weights.sum()))
    # A direction tells the turn about every axis but its own.
    information = np.sum(
        weights[:, None, None] * (np.eye(3) - sensor[:, :, None] * sensor[:, None, :]), axis=0
    )
    sigma = 1.0 / math.sqrt(max(float(np.linalg.eigvalsh(information)[0]), 1e-9))
    return rotation.from_scipy(turn), sigma, disagreement


def sigma_about_axes(directions: Sequence[tuple[Float, Float, float]]) -> Float:
    """Return the expected error of a frame from `frame_from` about each axis of the segment, shape (3,)."""
    information = 1e-9 * np.eye(3)
    for segment, _, sigma in directions:
        information += (np.eye(3) - np.outer(segment, segment)) / sigma**2
    return np.asarray(np.sqrt(np.diagonal(np.linalg.inv(information))))


def heading_between(first_rate: Float, second_rate: Float) -> tuple[float, float]:
    """Return the turn about the vertical from the second earth frame to the first, and its strength.

    Parameters
    ----------
    first_rate, second_rate : ndarray, shape (N, 3)
        Rates of two sensors that move as one, each in its own earth frame.

    Returns
    -------
    heading_rad : float
    coherence : float
        0 to 1: how alike the horizontal rates are after the turn.
    """
    one = first_rate[:, 0] + 1j * first_rate[:, 1]
    other = second_rate[:, 0] + 1j * second_rate[:, 1]
    good = np.isfinite(one) & np.isfinite(other)
    one, other = one[good], other[good]
    total = complex(np.sum(one * np.conj(other)))
    power = math.sqrt(float(np.sum(np.abs(one) ** 2)) * float(np.sum(np.abs(other) ** 2)))
    return math.atan2(total.imag, total.real), abs(total) / power if power > 0.0 else 0.0


def _across(axis: Float) -> Float:
    """Return two unit vectors across, shape (3, 2)."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    one = _unit(np.cross(axis, helper))
    return np.column_stack((one, np.cross(axis, one)))


def _unit(vector: Float) -> Float:
    return np.asarray(vector / np.linalg.norm(vector))
