"""Unit quaternions (w, x, y, z) and their relatives, over any leading axes.

`q_a_b` rotates vectors given in b into a; `multiply(q_a_b, q_b_c)` is `q_a_c`. q and -q are the same
rotation. All functions broadcast, leave their inputs alone and do not check for unit norm: call
`normalize` where a norm may have drifted. `to_scipy` and `from_scipy` are the only places where the
other component order (x, y, z, w) occurs.
"""

from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

Float = NDArray[np.float64]

_SMALL_ANGLE_RAD = 1e-4


def identity(shape: tuple[int, ...] = ()) -> Float:
    """Return identity quaternions, shape `(*shape, 4)`."""
    q = np.zeros((*shape, 4))
    q[..., 0] = 1.0
    return q


def normalize(q: ArrayLike) -> Float:
    """Scale to unit norm, shape (..., 4); a zero quaternion becomes the identity."""
    q = np.asarray(q, dtype=np.float64)
    norm = np.linalg.norm(q, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(norm == 0.0, identity(), q / norm)


def multiply(p: ArrayLike, q: ArrayLike) -> Float:
    """Return the Hamilton product, shape (..., 4): first q, then p."""
    p, q = np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64)
    pw, px, py, pz = (p[..., i] for i in range(4))
    qw, qx, qy, qz = (q[..., i] for i in range(4))
    return np.stack(
        (
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ),
        axis=-1,
    )


def running_product(q: ArrayLike) -> Float:
    """Return for each quaternion the product of those up to it along the last axis but one, shape (..., N, 4)."""
    product = np.array(q, dtype=np.float64)
    reach = 1
    while reach < product.shape[-2]:
        product[..., reach:, :] = multiply(product[..., :-reach, :], product[..., reach:, :])
        reach *= 2
    return product


def conjugate(q: ArrayLike) -> Float:
    """Return the inverse rotation of unit quaternions, shape (..., 4)."""
    return np.multiply(np.asarray(q, dtype=np.float64), [1.0, -1.0, -1.0, -1.0])


def rotate(q: ArrayLike, vector: ArrayLike) -> Float:
    """Rotate vectors, shape (..., 3), by unit quaternions, shape (..., 4)."""
    q, vector = np.asarray(q, dtype=np.float64), np.asarray(vector, dtype=np.float64)
    w, x, y, z = (q[..., i] for i in range(4))
    vx, vy, vz = (vector[..., i] for i in range(3))
    # By components: numpy's cross product costs ten times as much on the few samples of a live chunk.
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return np.stack(
        (
            vx + w * tx + (y * tz - z * ty),
            vy + w * ty + (z * tx - x * tz),
            vz + w * tz + (x * ty - y * tx),
        ),
        axis=-1,
    )


def exp(rotation_vector_rad: ArrayLike) -> Float:
    """Return quaternions of rotation vectors (axis times angle), shape (..., 3) to (..., 4)."""
    vector = np.asarray(rotation_vector_rad, dtype=np.float64)
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    small = angle < _SMALL_ANGLE_RAD
    safe = np.where(small, 1.0, angle)
    scale = np.where(small, 0.5 - angle * angle / 48.0, np.sin(0.5 * safe) / safe)
    return np.concatenate((np.cos(0.5 * angle), scale * vector), axis=-1)


def log(q: ArrayLike) -> Float:
    """Return the shortest rotation vectors, shape (..., 3), angle within [0, pi], of unit quaternions.

    At exactly pi the axis has the sign that the quaternion stores.
    """
    q = np.asarray(q, dtype=np.float64)
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    small = sine < _SMALL_ANGLE_RAD
    safe = np.where(small, 1.0, sine)
    # 2 asin(s)/s around zero: 2 + s^2/3
    return np.asarray(np.where(small, 2.0 + sine * sine / 3.0, angle / safe) * q[..., 1:])


def angle_between(p: ArrayLike, q: ArrayLike) -> Float:
    """Return the angle of the rotation from p to q, in [0, pi], shape (...)."""
    relative = multiply(conjugate(p), q)
    sine = np.linalg.norm(relative[..., 1:], axis=-1)
    return np.asarray(2.0 * np.arctan2(sine, np.abs(relative[..., 0])))


def slerp(p: ArrayLike, q: ArrayLike, fraction: ArrayLike) -> Float:
    """Turn from p (fraction 0) to q (fraction 1) at constant rate, by the shorter way.

    Parameters
    ----------
    p, q : array_like, shape (..., 4)
    fraction : array_like, shape (...)

    Returns
    -------
    ndarray, shape (..., 4)
    """
    vector = log(multiply(conjugate(p), q))
    return normalize(multiply(p, exp(np.asarray(fraction, dtype=np.float64)[..., None] * vector)))


def to_matrix(q: ArrayLike) -> Float:
    """Return rotation matrices, shape (..., 3, 3); `matrix @ v` equals `rotate(q, v)`."""
    q = np.asarray(q, dtype=np.float64)
    w, x, y, z = (q[..., i] for i in range(4))
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(matrix: ArrayLike) -> Float:
    """Return quaternions with w >= 0, shape (..., 4), of rotation matrices, shape (..., 3, 3).

    Notes
    -----
    Shepperd's method: the largest of the four squared components is found first, so that no small
    number is divided by.
    """
    m = np.asarray(matrix, dtype=np.float64)
    trace = np.trace(m, axis1=-2, axis2=-1)
    squares = np.stack((trace, m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]), axis=-1)
    largest = np.argmax(squares, axis=-1)
    wx, wy, wz = (m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1])
    xy, xz, yz = (m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1])
    own = [1.0 + trace] + [1.0 + 2.0 * m[..., i, i] - trace for i in range(3)]
    candidates = np.stack(
        [
            np.stack(parts, axis=-1)
            for parts in (
                (own[0], wx, wy, wz),
                (wx, own[1], xy, xz),
                (wy, xy, own[2], yz),
                (wz, xz, yz, own[3]),
            )
        ],
        axis=-2,
    )
    q = np.take_along_axis(candidates, largest[..., None, None], axis=-2)[..., 0, :]
    return positive(normalize(q))


def positive(q: ArrayLike) -> Float:
    """Return the same rotations with w >= 0."""
    q = np.asarray(q, dtype=np.float64)
    return np.where(q[..., :1] < 0.0, -q, q)


def continuous(q: ArrayLike) -> Float:
    """Choose signs along axis -2 so that neighbours lie on one half sphere, shape (..., K, 4)."""
    q = np.array(q, dtype=np.float64)
    flips = np.sum(q[..., 1:, :] * q[..., :-1, :], axis=-1) < 0.0
    q[..., 1:, :] *= np.where(np.cumsum(flips, axis=-1) % 2 == 1, -1.0, 1.0)[..., None]
    return q


def mean(q: ArrayLike, weights: ArrayLike | None = None) -> Float:
    """Average rotations over axis -2: the chordal mean, blind to the sign of each quaternion.

    Parameters
    ----------
    q : array_like, shape (..., K, 4)
    weights : array_like, shape (..., K), optional
        Not negative; need not sum to one.

    Returns
    -------
    ndarray, shape (..., 4)
        With w >= 0.

    Notes
    -----
    Largest eigenvector of sum(weight q q^T): Markley, Cheng, Crassidis, Oshman (2007).
    """
    q = np.asarray(q, dtype=np.float64)
    weighted = q if weights is None else q * np.asarray(weights, dtype=np.float64)[..., None]
    _, vectors = np.linalg.eigh(np.swapaxes(weighted, -1, -2) @ q)
    return positive(vectors[..., :, -1])


def about_x(angle_rad: ArrayLike) -> Float:
    """Return the rotation about x, shape (..., 4)."""
    return _about(angle_rad, 1)


def about_y(angle_rad: ArrayLike) -> Float:
    """Return the rotation about y, shape (..., 4)."""
    return _about(angle_rad, 2)


def about_z(angle_rad: ArrayLike) -> Float:
    """Return the rotation about z, shape (..., 4)."""
    return _about(angle_rad, 3)


def _about(angle_rad: ArrayLike, component: int) -> Float:
    half = 0.5 * np.asarray(angle_rad, dtype=np.float64)
    q = np.zeros((*half.shape, 4))
    q[..., 0], q[..., component] = np.cos(half), np.sin(half)
    return q


def split_heading(q: ArrayLike) -> tuple[Float, Float]:
    """Take a rotation apart into a turn about the outer z axis and the inclination before it.

    Parameters
    ----------
    q : array_like, shape (..., 4)

    Returns
    -------
    heading_rad : ndarray, shape (...)
        In (-pi, pi]. Zero where it is undefined: half a turn about a horizontal axis.
    q_inclination : ndarray, shape (..., 4)
        Has no z component; `q = about_z(heading) * q_inclination`.
    """
    q = positive(q)
    heading = 2.0 * np.arctan2(q[..., 3], q[..., 0])
    return heading, multiply(about_z(-heading), q)


def shortest(from_vector: ArrayLike, to_vector: ArrayLike) -> Float:
    """Return the smallest rotation that turns one direction into another, shape (..., 4).

    Parameters
    ----------
    from_vector, to_vector : array_like, shape (..., 3)
        Any length but zero. For opposite directions the axis is some perpendicular one.
    """
    a = np.asarray(from_vector, dtype=np.float64)
    b = np.asarray(to_vector, dtype=np.float64)
    a, b = np.broadcast_arrays(
        a / np.linalg.norm(a, axis=-1, keepdims=True), b / np.linalg.norm(b, axis=-1, keepdims=True)
    )
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    q = np.concatenate((1.0 + cosine, np.cross(a, b)), axis=-1)
    least = np.eye(3)[np.argmin(np.abs(a), axis=-1)]
    opposite = np.concatenate((np.zeros_like(cosine), np.cross(a, least)), axis=-1)
    # Below 1e-14 the sum above has lost the direction of the axis to rounding.
    return normalize(np.where(cosine < -1.0 + 1e-14, opposite, q))


def to_scipy(q: ArrayLike) -> "scipy.spatial.transform.Rotation":
    """Return a scipy Rotation of quaternions, shape (4,) or (N, 4)."""
    return scipy.spatial.transform.Rotation.from_quat(np.asarray(q, dtype=np.float64)[..., [1, 2, 3, 0]])


def from_scipy(rotation: "scipy.spatial.transform.Rotation") -> Float:
    """Return quaternions with w >= 0 of a scipy Rotation, shape (4,) or (N, 4)."""
    xyzw: NDArray[Any] = rotation.as_quat()
    return positive(xyzw[..., [3, 0, 1, 2]])
