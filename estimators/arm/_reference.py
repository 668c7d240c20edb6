"""The numpy twin of the compiled kernel: the same columns from the plain functions, for any recording."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.arm._angle_kernel import SINGULAR_MARGIN_RAD
from estimators.arm._joint_angles import (
    continuous_hinge_angles,
    continuous_shoulder_angles,
    elbow_angles,
    is_shoulder_singular,
    trunk_angles,
    wrist_angles,
)
from estimators.arm._model import ArmModel, ArmResult
from estimators.arm._names import MODEL_ANGLES, MODEL_SCALARS, Joint, angle_name
from estimators.arm._uncertainty import joint_angle_sigma
from estimators.arm.chains.homogeneous import joint_centres
from estimators.conventions import SIDES, Side

Float = NDArray[np.float64]

_JOINTS: tuple[tuple[Joint, str, str], ...] = (
    ("thorax_humerus", "sternum", "upper_arm"),
    ("humerus_forearm", "upper_arm", "forearm"),
    ("forearm_hand", "forearm", "hand"),
)
_PARTS = {
    "thorax_humerus": ("yxy_plane_of_elevation", "yxy_elevation", "yxy_axial_rotation"),
    "humerus_forearm": ("zxy_flexion", "zxy_carrying", "zxy_pronation"),
    "forearm_hand": ("zxy_flexion", "zxy_deviation", "zxy_rotation"),
}
_SINGULAR = np.uint8(128)


def _by_placement(model: ArmModel, values: NDArray[Any] | None) -> dict[str, NDArray[Any]]:
    """Return values of shape (K, G, ...) by segment; none where they were not given."""
    return {} if values is None else {name: values[:, g] for g, name in enumerate(model.placements)}


def evaluate_reference(
    model: ArmModel,
    q_room_segment: Float,
    *,
    segment_flags: NDArray[np.uint8] | None = None,
    angular_velocity_room_radps: Float | None = None,
    sigma_room_rad: Float | None = None,
    previous_angle_rad: Float | None = None,
) -> ArmResult:
    """Do what `ArmModel.evaluate` does, slowly and in the open; same arguments, same result to rounding."""
    ticks = q_room_segment.shape[0]
    flags = np.zeros(q_room_segment.shape[:2], np.uint8) if segment_flags is None else segment_flags
    columns, flag_of = _by_placement(model, q_room_segment), _by_placement(model, flags)
    sigma_of, omega_of = (
        _by_placement(model, values) for values in (sigma_room_rad, angular_velocity_room_radps)
    )
    centres = joint_centres(columns, model.body)
    previous = model.initial_previous() if previous_angle_rad is None else np.array(previous_angle_rad)
    angle = np.full((ticks, len(model.angles)), np.nan)
    sigma = np.full_like(angle, np.nan)
    angle_flag = np.zeros(angle.shape, np.uint8)
    for side in SIDES:
        for joint, parent, child in _JOINTS:
            names = [angle_name(joint, side, part) for part in _PARTS[joint]]
            if names[0] not in model.angles:
                continue
            at = model.angles.index(names[0])
            memory = MODEL_ANGLES.index(names[0])
            parent_name = parent if joint == "thorax_humerus" else f"{parent}_{side}"
            child_name = f"{child}_{side}"
            q_parent = columns.get(parent_name, rotation.identity((ticks,)))
            found, singular = _angles(
                joint, side, q_parent, columns[child_name], model.time_step_s, previous[memory : memory + 3]
            )
            angle[:, at : at + 3] = found
            finite = np.flatnonzero(np.isfinite(found[:, 0]))
            if finite.size:
                previous[memory : memory + 3] = found[finite[-1]]
            joint_flag = flag_of[child_name] | flag_of.get(parent_name, np.zeros(ticks, np.uint8))
            angle_flag[:, at : at + 3] = joint_flag[:, None]
            angle_flag[singular, at] |= _SINGULAR
            angle_flag[singular, at + 2] |= _SINGULAR
            if sigma_of:
                valid = np.isfinite(found[:, 0])
                sigma[valid, at : at + 3] = joint_angle_sigma(
                    joint,
                    side,
                    q_parent[valid],
                    columns[child_name][valid],
                    sigma_of.get(parent_name, np.zeros((ticks, 3)))[valid],
                    sigma_of[child_name][valid],
                    found[valid, 0],
                )
    return ArmResult(
        np.stack([np.broadcast_to(centres[name], (ticks, 3)) for name in model.points], axis=1),
        angle,
        sigma,
        _scalars(model, columns, omega_of, centres),
        angle_flag,
        previous,
    )


def _angles(
    joint: Joint, side: Side, q_parent: Float, q_child: Float, step_s: float, previous: Float
) -> tuple[Float, NDArray[np.bool_]]:
    relative = rotation.multiply(rotation.conjugate(q_parent), q_child)
    if joint == "thorax_humerus":
        found = continuous_shoulder_angles(relative, side, step_s, previous)
        return found, is_shoulder_singular(found[:, 1])
    hinge = elbow_angles(relative, side) if joint == "humerus_forearm" else wrist_angles(relative, side)
    found = continuous_hinge_angles(hinge, previous)
    return found, np.asarray(0.5 * np.pi - np.abs(found[:, 1]) < SINGULAR_MARGIN_RAD)


def _scalars(
    model: ArmModel, q: dict[str, Float], omega: dict[str, Float], centres: dict[str, Float]
) -> Float:
    ticks = next(iter(q.values())).shape[0]
    result = np.full((ticks, len(model.scalars)), np.nan)
    thorax = q.get("sternum", rotation.identity((ticks,)))
    leans = trunk_angles(thorax)
    up = rotation.rotate(thorax, (0.0, 0.0, 1.0))
    for column, name in enumerate(model.scalars):
        side = "left" if "_left_" in name else "right"
        if name.startswith("trunk"):
            result[:, column] = leans[:, MODEL_SCALARS.index(name)]
        elif name.startswith("shoulder_hike"):
            result[:, column] = np.sum(up * (centres[f"shoulder_{side}"] - centres["neck"]), axis=-1)
        elif omega:
            still = np.zeros((ticks, 3))
            thorax_rate = omega.get("sternum", still)
            forearm_rate = omega[f"forearm_{side}"]
            chain = (
                (thorax_rate, "pelvis", "neck"),
                (omega.get(f"shoulder_{side}", thorax_rate), "neck", f"shoulder_{side}"),
                (omega[f"upper_arm_{side}"], f"shoulder_{side}", f"elbow_{side}"),
                (forearm_rate, f"elbow_{side}", f"wrist_{side}"),
                (omega.get(f"hand_{side}", forearm_rate), f"wrist_{side}", f"hand_{side}"),
            )
            velocity = sum((np.cross(w, centres[b] - centres[a]) for w, a, b in chain), still)
            result[:, column] = np.linalg.norm(velocity, axis=-1)
    return result
