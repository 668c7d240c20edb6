"""Names and fixed order of everything the arm model knows; the kernels and their twin share the order."""

from typing import Final, Literal

from estimators.conventions import SIDES, Placement

Joint = Literal["thorax_humerus", "humerus_forearm", "forearm_hand"]

MODEL_SEGMENTS: Final[tuple[Placement, ...]] = (
    "sternum",
    "head",
    *(
        placement
        for arm in (
            ("shoulder_left", "upper_arm_left", "forearm_left", "hand_left"),
            ("shoulder_right", "upper_arm_right", "forearm_right", "hand_right"),
        )
        for placement in arm
    ),
)
"""Segments of the model; the sternum moves the thorax, a shoulder sensor the clavicle of its side."""

SHOULDER, UPPER_ARM, FOREARM, HAND = 0, 1, 2, 3
"""Offsets within one arm; the left arm starts at index 2 of `MODEL_SEGMENTS`, the right at 6."""

MODEL_POINTS: Final[tuple[str, ...]] = (
    "pelvis",
    "neck",
    "head",
    *(f"{joint}_{side}" for side in SIDES for joint in ("shoulder", "elbow", "wrist", "hand")),
)

ANGLE_PARTS: Final[tuple[tuple[str, str], ...]] = (
    ("thorax_humerus", "yxy_plane_of_elevation"),
    ("thorax_humerus", "yxy_elevation"),
    ("thorax_humerus", "yxy_axial_rotation"),
    ("humerus_forearm", "zxy_flexion"),
    ("humerus_forearm", "zxy_carrying"),
    ("humerus_forearm", "zxy_pronation"),
    ("forearm_hand", "zxy_flexion"),
    ("forearm_hand", "zxy_deviation"),
    ("forearm_hand", "zxy_rotation"),
)

MODEL_ANGLES: Final[tuple[str, ...]] = tuple(
    f"{joint}_{side}_{meaning}" for side in SIDES for joint, meaning in ANGLE_PARTS
)

MODEL_SCALARS: Final[tuple[str, ...]] = (
    "trunk_lean_forward_rad",
    "trunk_lean_lateral_rad",
    "trunk_axial_rotation_rad",
    "shoulder_hike_left_m",
    "shoulder_hike_right_m",
    "hand_speed_left_mps",
    "hand_speed_right_mps",
)


def angle_name(joint: str, side: str, meaning: str) -> str:
    """Return the column name of one joint angle, e.g. `humerus_forearm_left_zxy_flexion`."""
    name = f"{joint}_{side}_{meaning}"
    if name not in MODEL_ANGLES:
        raise KeyError(f"no joint angle is named {name}")
    return name
