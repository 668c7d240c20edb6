"""Forward kinematics by dual quaternions: unit dual quaternions, and the vector form of the thesis.

A dual quaternion is `q_r + eps q_d`, shape (..., 8): orientation (w, x, y, z), then the dual part
`q_d = 1/2 t q_r` that carries the translation t. Products compose like transforms.

Marzouk (2009) section 4.4, A15 of its method page, with erratum E-21: dual angles pair the joint angle with the
offset along the joint axis, and the twist with the length along the common normal.
"""

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._model import model_lengths
from estimators.arm.chains.chain_kernel import DUAL, walk_axes, walk_dual
from estimators.arm.chains.denavit_hartenberg import LinkChain, prepared
from estimators.body import BodyDimensions
from estimators.conventions import SIDES
from estimators.errors import SetupError

Float = NDArray[np.float64]


def dual_quaternion(q_parent_child: ArrayLike, origin_parent_m: ArrayLike) -> Float:
    """Return the unit dual quaternion of an orientation, shape (..., 4), and an origin, shape (..., 3)."""
    q = np.asarray(q_parent_child, dtype=np.float64)
    origin = np.asarray(origin_parent_m, dtype=np.float64)
    shape = np.broadcast_shapes(q.shape[:-1], origin.shape[:-1])
    pure = np.zeros((*shape, 4))
    pure[..., 1:] = origin
    real = np.broadcast_to(q, (*shape, 4))
    return np.concatenate((real, 0.5 * rotation.multiply(pure, real)), axis=-1)


def dual_multiply(first: ArrayLike, second: ArrayLike) -> Float:
    """Return the product, shape (..., 8): the pose of `second` given in `first`."""
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    real = rotation.multiply(a[..., :DUAL], b[..., :DUAL])
    dual = rotation.multiply(a[..., :DUAL], b[..., DUAL:]) + rotation.multiply(a[..., DUAL:], b[..., :DUAL])
    return np.concatenate((real, dual), axis=-1)


def dual_inverse(unit: ArrayLike) -> Float:
    """Return the inverse pose of unit dual quaternions, shape (..., 8)."""
    return np.multiply(np.asarray(unit, dtype=np.float64), [1.0, -1.0, -1.0, -1.0] * 2)


def dual_normalize(dual: ArrayLike) -> Float:
    """Return the nearest unit dual quaternion: `|q_r| = 1` and `q_r . q_d = 0`."""
    given = np.asarray(dual, dtype=np.float64)
    given = given / np.linalg.norm(given[..., :DUAL], axis=-1, keepdims=True)
    real, part = given[..., :DUAL], given[..., DUAL:]
    part = part - np.sum(real * part, axis=-1, keepdims=True) * real
    return np.concatenate((real, part), axis=-1)


def dual_position(unit: ArrayLike) -> Float:
    """Return the origin, shape (..., 3): vector part of `2 q_d conj(q_r)`."""
    given = np.asarray(unit, dtype=np.float64)
    return 2.0 * rotation.multiply(given[..., DUAL:], rotation.conjugate(given[..., :DUAL]))[..., 1:]


def dual_transform_point(unit: ArrayLike, point_child_m: ArrayLike) -> Float:
    """Return points, shape (..., 3), in the parent frame."""
    return np.asarray(rotation.rotate(np.asarray(unit)[..., :DUAL], point_child_m) + dual_position(unit))


def screw(axis: ArrayLike, angle_rad: ArrayLike, shift_m: ArrayLike) -> Float:
    """Return the motion about and along a unit axis through the origin, shape (..., 8).

    Notes
    -----
    `(cos, u sin) + eps (-d/2 sin, d/2 u cos)` of half the angle: A15 (b).
    """
    unit = np.asarray(axis, dtype=np.float64)
    half = 0.5 * np.asarray(angle_rad, dtype=np.float64)[..., None]
    shift = 0.5 * np.asarray(shift_m, dtype=np.float64)[..., None]
    parts = (np.cos(half), unit * np.sin(half), -shift * np.sin(half), shift * unit * np.cos(half))
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1)


def chain_dual_quaternions(
    chain: LinkChain, joint_rad: ArrayLike, ends: Sequence[int] | None = None
) -> Float:
    """Return link ends as unit dual quaternions, shape (..., F, 8); arguments as `chain_transforms`.

    Notes
    -----
    A15 (b): each link is `Screw(z, joint, offset) Screw(x, twist, length)`.
    """
    joints, keep, shape = prepared(chain, joint_rad, ends)
    half = 0.5 * np.asarray(chain.twist_rad)
    links = np.column_stack((chain.offset_m, chain.length_m, np.cos(half), np.sin(half)))
    out = np.empty((joints.shape[0], int(keep.max()) + 1, 8))
    walk_dual(joints, np.ascontiguousarray(links), keep, out)
    return out.reshape(*shape, -1, 8)


def chain_screw_axes(chain: LinkChain, joint_rad: ArrayLike, ends: Sequence[int] | None = None) -> Float:
    """Return link ends by the vector form of the thesis, shape (..., F, 4, 4); arguments as `chain_transforms`.

    Notes
    -----
    A15 (a), (4.27) to (4.37): joint axis s and common normal a are carried along; the end has the axes
    (a, s x a, s). One-sided products with the full angle suffice because s and a stay perpendicular.
    """
    joints, keep, shape = prepared(chain, joint_rad, ends)
    links = np.column_stack(
        (chain.offset_m, chain.length_m, np.cos(chain.twist_rad), np.sin(chain.twist_rad))
    )
    out = np.empty((joints.shape[0], int(keep.max()) + 1, 4, 4))
    walk_axes(joints, np.ascontiguousarray(links), keep, out)
    return out.reshape(*shape, -1, 4, 4)


def arm_dual_quaternions(q_room_segment: Mapping[str, ArrayLike], body: BodyDimensions) -> dict[str, Float]:
    """Return the poses of thorax and arm segments in the room, shape (..., 8), as `segment_transforms` does.

    The same chain by other means: worn segments only, thorax upright without a sternum sensor, clavicles with
    the thorax unless a shoulder sensor is worn, a hand without a sensor with its forearm.
    """
    hip_height, trunk, half_width, _, *reaches = (float(length) for length in model_lengths(body))
    shape = np.broadcast_shapes(*(np.shape(q)[:-1] for q in q_room_segment.values()))
    thorax = np.asarray(q_room_segment.get("sternum", rotation.identity(shape)), dtype=np.float64)
    lift = screw((0.0, 0.0, 1.0), np.zeros(shape), hip_height)
    result = {"sternum": dual_multiply(lift, dual_quaternion(thorax, np.zeros(3)))}
    for side in SIDES:
        outward = half_width if side == "left" else -half_width
        place, held = screw((0.0, 0.0, 1.0), 0.0, trunk), thorax
        parent = result["sternum"]
        for segment, reach in zip(
            ("shoulder", "upper_arm", "forearm", "hand"), (outward, *(-r for r in reaches)), strict=True
        ):
            name = f"{segment}_{side}"
            if name not in q_room_segment and segment in ("upper_arm", "forearm"):
                break
            q = np.asarray(q_room_segment.get(name, held), dtype=np.float64)
            turn = rotation.multiply(rotation.conjugate(held), q)
            parent = dual_multiply(dual_multiply(parent, place), dual_quaternion(turn, np.zeros(3)))
            result[name], held = parent, q
            place = screw((0.0, 1.0, 0.0) if segment == "shoulder" else (0.0, 0.0, 1.0), 0.0, reach)
    return result


KinematicMethod = Literal["homogeneous_4x4", "homogeneous_affine", "dual_quaternion", "screw_axes"]
KINEMATIC_METHODS: tuple[KinematicMethod, ...] = get_args(KinematicMethod)


class OperationCount(NamedTuple):
    """Floating point multiplications and additions (subtractions among them); sines and cosines apart."""

    multiplications: int
    additions: int


_PER_LINK: dict[KinematicMethod, OperationCount] = {
    "homogeneous_4x4": OperationCount(6 + 64, 48),
    "homogeneous_affine": OperationCount(6 + 36, 27),
    "dual_quaternion": OperationCount(4 + 2 * 48, 2 * 40),
    "screw_axes": OperationCount(30, 18),
}


def operation_count(method: KinematicMethod, link_count: int) -> OperationCount:
    """Return what a general chain costs, per pose, with every link multiplied out.

    Parameters
    ----------
    method : KinematicMethod
        `homogeneous_4x4`: six products build a link, a full 4x4 product has 64 / 48 multiplications / additions.
        `homogeneous_affine`: the same without the constant last row, 36 / 27 a product.
        `dual_quaternion`: four products build two screws, two products of 48 / 40 a link.
        `screw_axes`: the vector form, 30 / 18 a link, the only one cheaper than affine matrices.
    link_count : int
        At least 1.

    Raises
    ------
    SetupError
        For an unknown method or no links.

    Notes
    -----
    Erratum E-25: the thesis says dual quaternions are cheaper (T4.4, F4.9, F4.10); only its vector form is.
    The tests count the operations of the functions that run.
    """
    if method not in KINEMATIC_METHODS:
        raise SetupError(f"no kinematic method {method!r}; known are {', '.join(KINEMATIC_METHODS)}")
    if link_count < 1:
        raise SetupError(f"a chain of {link_count} links; it needs at least one")
    each = _PER_LINK[method]
    return OperationCount(link_count * each.multiplications, link_count * each.additions)
