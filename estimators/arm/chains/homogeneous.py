"""Forward kinematics by homogeneous transforms: trunk and arms, one tick or many.

`T_parent_child` maps points given in the child frame into the parent frame; chains are plain matrix
products over any leading axes. Marzouk (2009) section 4.2 is the two-link special case (`_two_link`).
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._model import model_lengths
from estimators.body import BodyDimensions
from estimators.conventions import SIDES

Float = NDArray[np.float64]


def transform(q_parent_child: ArrayLike, origin_parent_m: ArrayLike) -> Float:
    """Return `T_parent_child`, shape (..., 4, 4), of orientations (..., 4) and origins (..., 3)."""
    matrix = rotation.to_matrix(q_parent_child)
    origin = np.asarray(origin_parent_m, dtype=np.float64)
    shape = np.broadcast_shapes(matrix.shape[:-2], origin.shape[:-1])
    result = np.zeros((*shape, 4, 4))
    result[..., :3, :3] = matrix
    result[..., :3, 3] = origin
    result[..., 3, 3] = 1.0
    return result


def inverse_transform(transform_parent_child: ArrayLike) -> Float:
    """Return `T_child_parent`, shape (..., 4, 4)."""
    given = np.asarray(transform_parent_child, dtype=np.float64)
    result = np.zeros_like(given)
    turned = np.swapaxes(given[..., :3, :3], -1, -2)
    result[..., :3, :3] = turned
    result[..., :3, 3] = -np.einsum("...ij,...j->...i", turned, given[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result


def transform_point(transform_parent_child: ArrayLike, point_child_m: ArrayLike) -> Float:
    """Return points in the parent frame, shape (..., 3)."""
    given = np.asarray(transform_parent_child, dtype=np.float64)
    point = np.asarray(point_child_m, dtype=np.float64)
    return np.asarray(np.einsum("...ij,...j->...i", given[..., :3, :3], point) + given[..., :3, 3])


def segment_transforms(q_room_segment: Mapping[str, ArrayLike], body: BodyDimensions) -> dict[str, Float]:
    """Return `T_room_segment` of every segment that the given orientations allow.

    Parameters
    ----------
    q_room_segment : mapping of Placement to array, shape (..., 4)
        Worn segments. Without a sternum the thorax is upright; without a shoulder sensor the clavicle goes
        with the thorax; head and hand without a sensor go with thorax and forearm.

    Returns
    -------
    dict of name to ndarray, shape (..., 4, 4)
        Origins at the proximal joint: `sternum` at the hip centre, `head` and `shoulder_{side}` at the neck,
        `upper_arm_{side}`, `forearm_{side}`, `hand_{side}`.
    """
    hip_height, trunk, half_width, _, *reaches = model_lengths(body)
    shape = np.broadcast_shapes(*(np.shape(q)[:-1] for q in q_room_segment.values()))
    thorax = np.asarray(q_room_segment.get("sternum", rotation.identity(shape)), dtype=np.float64)
    hip = np.zeros((*shape, 3))
    hip[..., 2] = hip_height
    result = {"sternum": transform(thorax, hip)}

    def add(name: str, q_room: ArrayLike, parent: str, offset_parent_m: tuple[float, float, float]) -> None:
        q_room_parent = np.asarray(q_room_segment.get(parent, thorax), dtype=np.float64)
        q_parent_child = rotation.multiply(rotation.conjugate(q_room_parent), q_room)
        result[name] = result[parent] @ transform(q_parent_child, offset_parent_m)

    add("head", q_room_segment.get("head", thorax), "sternum", (0.0, 0.0, trunk))
    for side in SIDES:
        outward = half_width if side == "left" else -half_width
        add(f"shoulder_{side}", q_room_segment.get(f"shoulder_{side}", thorax), "sternum", (0.0, 0.0, trunk))
        parent, offset = f"shoulder_{side}", (0.0, outward, 0.0)
        for segment, reach in zip(("upper_arm", "forearm", "hand"), reaches, strict=True):
            name = f"{segment}_{side}"
            if name not in q_room_segment and segment != "hand":
                break
            add(name, q_room_segment.get(name, q_room_segment.get(parent, thorax)), parent, offset)
            parent, offset = name, (0.0, 0.0, -float(reach))
    return result


def joint_centres(q_room_segment: Mapping[str, ArrayLike], body: BodyDimensions) -> dict[str, Float]:
    """Return the positions of `ArmModel.points` in the room, each shape (..., 3), metres."""
    frames = segment_transforms(q_room_segment, body)
    _, trunk, half_width, head_up, upper_arm, forearm, hand = model_lengths(body)
    points = {
        "pelvis": frames["sternum"][..., :3, 3],
        "neck": transform_point(frames["sternum"], (0.0, 0.0, trunk)),
        "head": transform_point(frames["head"], (0.0, 0.0, head_up)),
    }
    ends = (("upper_arm", "elbow", upper_arm), ("forearm", "wrist", forearm), ("hand", "hand", hand))
    for side in SIDES:
        outward = half_width if side == "left" else -half_width
        points[f"shoulder_{side}"] = transform_point(frames[f"shoulder_{side}"], (0.0, outward, 0.0))
        for segment, point, reach in ends:
            if f"{segment}_{side}" in frames:
                points[f"{point}_{side}"] = transform_point(frames[f"{segment}_{side}"], (0.0, 0.0, -reach))
    return points
