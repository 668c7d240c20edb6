"""An optical reference beside a sensor: alignment from still poses, heading offset, and how good its markers are."""

import numpy as np
import scipy

from estimators import rotation
from estimators.errors import ShapeError
from estimators.recording import Float

LEAST_ANGLE_RAD = float(np.radians(45.0))
"""Two poses nearer than this leave the turn about their common vertical badly known."""


def align_marker_frame(force_sensor: Float, q_room_marker: Float) -> Float:
    """Find how the sensor sits in the frame of its markers, from still poses.

    Parameters
    ----------
    force_sensor : ndarray, shape (P, 3)
        Mean specific force of each still pose, sensor axes; only its direction counts.
    q_room_marker : ndarray, shape (P, 4)
        Orientation of the marker frame in the same poses; the room is z up.

    Returns
    -------
    ndarray, shape (4,)
        `q_marker_sensor`.

    Raises
    ------
    ShapeError
        Fewer than two poses, shapes that differ, or verticals that all lie within 45 degrees.

    Notes
    -----
    Luinge and Veltink (2005), 3.1; Roetenberg (2006), 3.2.1: the rotation that minimises the sum of
    `|R_room_marker' z - R_marker_sensor f / |f||^2` (Wahba). An accelerometer bias of 0.2 m/s^2 costs about a degree.
    """
    force, q = np.atleast_2d(force_sensor), np.atleast_2d(q_room_marker)
    if force.shape != (len(q), 3) or q.shape[1] != 4 or len(q) < 2:
        raise ShapeError(
            f"poses need forces (P, 3) and orientations (P, 4), two at least; got {force.shape}, {q.shape}"
        )
    measured = force / np.linalg.norm(force, axis=1, keepdims=True)
    seen = rotation.rotate(rotation.conjugate(q), np.broadcast_to([0.0, 0.0, 1.0], (len(q), 3)))
    if np.arccos(np.clip(measured @ measured.T, -1.0, 1.0)).max() < LEAST_ANGLE_RAD:
        raise ShapeError(
            "the still poses lean too little: tilt the sensor by 45 degrees at least between two of them"
        )
    found, _ = scipy.spatial.transform.Rotation.align_vectors(seen, measured)
    return rotation.from_scipy(found)


def heading_offset(q_reference: Float, q_estimate: Float) -> float:
    """Return the mean turn about the vertical that takes the reference to the estimate, over still samples (N, 4)."""
    apart = rotation.multiply(q_estimate, rotation.conjugate(q_reference))
    turns = 2.0 * np.arctan2(apart[..., 3], apart[..., 0])
    return float(np.angle(np.mean(np.exp(1j * turns))))


def stick_angle_errors(marker_distance_m: Float, first_stick_m: float, second_stick_m: float) -> Float:
    """Error of the right angle between two sticks, from the distance of the markers at their ends.

    Parameters
    ----------
    marker_distance_m : ndarray, shape (N,)
    first_stick_m, second_stick_m : float
        Lengths of the sticks, which stand at a right angle.

    Returns
    -------
    ndarray, shape (N,)
        `pi/2 - acos((a^2 + b^2 - m^2) / (2 a b))`, rad (Roetenberg 2006, eq. 3.2 and 3.3).
    """
    squares = first_stick_m**2 + second_stick_m**2 - np.square(marker_distance_m)
    cosine = squares / (2.0 * first_stick_m * second_stick_m)
    return np.asarray(np.pi / 2.0 - np.arccos(np.clip(cosine, -1.0, 1.0)))
