"""Velocities and accelerations of the points of interest (Marzouk 2009, F6; A19 of its method page).

Velocity of a point is the sum over the links of its chain of w x r, w the turning rate of the segment that
carries r; acceleration is the derivative of velocity by local polynomials of third order over half a second.
Accelerometers are never integrated.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators import rotation, signals
from estimators.arm._model import model_lengths
from estimators.arm._points import arm_points, point_chain
from estimators.body import BodyDimensions
from estimators.errors import ShapeError

Float = NDArray[np.float64]

RATE_WINDOW_S = 0.11
ACCELERATION_WINDOW_S = 0.5
_ORDER = 3


class PointMotion(NamedTuple):
    """How points move; each array shape (K, P, 3), room axes, NaN in gaps.

    `points` are the names of the columns; position is from the middle of the hips' place on the floor.
    """

    points: tuple[str, ...]
    position_m: Float
    velocity_mps: Float
    acceleration_mps2: Float


def angular_velocity(q_room_segment: Float, time_step_s: float, window_s: float = RATE_WINDOW_S) -> Float:
    """Return turning rates in room axes from orientations alone, as stored frames have them.

    Parameters
    ----------
    q_room_segment : ndarray, shape (K, ..., 4)
        Consecutive ticks; NaN in gaps.
    window_s : float
        Length of the local polynomials of the quaternion.

    Returns
    -------
    ndarray, shape (K, ..., 3)
        NaN in gaps and in stretches too short for a derivative.

    Notes
    -----
    w = 2 dq/dt conj(q), for q with neighbours on one half sphere.
    """
    q = np.asarray(q_room_segment, dtype=np.float64)
    columns = q.reshape(q.shape[0], -1, 4)
    result = np.full((*columns.shape[:2], 3), np.nan)
    for c in range(columns.shape[1]):
        for start, stop in _runs(columns[:, c]):
            if stop - start > _ORDER + 1:
                piece = rotation.continuous(columns[start:stop, c])
                change = signals.derivative(piece, 1.0 / time_step_s, window_s, _ORDER, axis=0)
                result[start:stop, c] = 2.0 * rotation.multiply(change, rotation.conjugate(piece))[..., 1:]
    return result.reshape(*q.shape[:-1], 3)


def point_motion(
    q_room_segment: Float,
    segments: Sequence[str],
    body: BodyDimensions,
    time_step_s: float,
    angular_velocity_room_radps: Float | None = None,
    *,
    points: Sequence[str] | None = None,
    acceleration_window_s: float = ACCELERATION_WINDOW_S,
) -> PointMotion:
    """Return position, velocity and acceleration of points over a recording.

    Parameters
    ----------
    q_room_segment : ndarray, shape (K, G, 4)
        `Frames.q_room_segment`, consecutive ticks.
    segments : sequence of str
        `Frames.layout.segments`, the G columns.
    body : BodyDimensions
        Of the session's setup.
    angular_velocity_room_radps : ndarray, shape (K, G, 3), optional
        From the gyroscopes; without it the rates are those of the orientations.
    points : sequence of str, optional
        Names of `MODEL_POINTS`; elbow, wrist and hand of each side by default.
    acceleration_window_s : float
        Of the third-order polynomials: 0.5 s as in A19, which takes off tremor of 5 Hz almost whole; shorter
        follows quick movements and passes more noise.

    Raises
    ------
    ShapeError
        If the arrays do not fit each other.
    SetupError
        If a point cannot be distinguished from these segments.
    """
    q = np.asarray(q_room_segment, dtype=np.float64)
    if q.ndim != 3 or q.shape[1:] != (len(segments), 4):
        raise ShapeError(
            f"orientations have shape {q.shape}; these segments need (ticks, {len(segments)}, 4)"
        )
    if angular_velocity_room_radps is None:
        rate = angular_velocity(q, time_step_s)
    else:
        rate = np.asarray(angular_velocity_room_radps, dtype=np.float64)
        if rate.shape != (*q.shape[:2], 3):
            raise ShapeError(f"turning rates have shape {rate.shape}, not {(*q.shape[:2], 3)}")
    names = tuple(points) if points is not None else arm_points(segments)
    lengths = model_lengths(body)
    position = np.zeros((q.shape[0], len(names), 3))
    position[..., 2] = lengths[0]
    velocity = np.zeros_like(position)
    acceleration = np.full_like(position, np.nan)
    for p, name in enumerate(names):
        for link in point_chain(name, segments):
            vector = lengths[link.length] * np.array(link.direction)
            if link.carrier >= 0:
                vector = rotation.rotate(q[:, link.carrier], vector)
                velocity[:, p] += np.cross(rate[:, link.carrier], vector)
            position[:, p] += vector
        for start, stop in _runs(velocity[:, p]):
            if stop - start > _ORDER + 1:
                piece = velocity[start:stop, p]
                acceleration[start:stop, p] = signals.derivative(
                    piece, 1.0 / time_step_s, acceleration_window_s, _ORDER, axis=0
                )
    return PointMotion(names, position, velocity, acceleration)


def _runs(values: Float) -> list[tuple[int, int]]:
    """Return the half-open stretches in which every component is present."""
    present = np.atleast_1d(np.isfinite(values).all(axis=-1))
    edges = np.flatnonzero(np.diff(np.concatenate(([False], present, [False])).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
