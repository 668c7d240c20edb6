"""The arm: segment orientations in, joint centres and joint angles out.

`ArmModel.evaluate` is the live path (compiled, one call a chunk). The other functions are its plain
numpy parts, for tests, simulation and work on whole recordings; `evaluate_reference` is its twin.
"""

from estimators.arm._homogeneous import (
    inverse_transform,
    joint_centres,
    segment_transforms,
    transform,
    transform_point,
)
from estimators.arm._joint_angles import (
    SIGN_TABLE,
    SignConvention,
    continuous_hinge_angles,
    continuous_shoulder_angles,
    elbow_angles,
    elbow_from_angles,
    is_shoulder_singular,
    mirrored,
    segments_from_angles,
    shoulder_angles,
    shoulder_from_angles,
    trunk_angles,
    trunk_from_angles,
    wrist_angles,
    wrist_from_angles,
)
from estimators.arm._kernel import SIGMA_CEILING_RAD, SINGULAR_MARGIN_RAD
from estimators.arm._model import ArmModel, ArmResult, model_lengths
from estimators.arm._names import (
    MODEL_ANGLES,
    MODEL_POINTS,
    MODEL_SCALARS,
    MODEL_SEGMENTS,
    angle_name,
)
from estimators.arm._reference import evaluate_reference
from estimators.arm._two_link import (
    TwoLinkPose,
    two_link_joint_angles,
    two_link_pose,
    two_link_velocity,
)
from estimators.arm._uncertainty import joint_angle_sigma
from estimators.body import BodyDimensions, body_from_stature

__all__ = [
    "MODEL_ANGLES",
    "MODEL_POINTS",
    "MODEL_SCALARS",
    "MODEL_SEGMENTS",
    "SIGMA_CEILING_RAD",
    "SIGN_TABLE",
    "SINGULAR_MARGIN_RAD",
    "ArmModel",
    "ArmResult",
    "BodyDimensions",
    "SignConvention",
    "TwoLinkPose",
    "angle_name",
    "body_from_stature",
    "continuous_hinge_angles",
    "continuous_shoulder_angles",
    "elbow_angles",
    "elbow_from_angles",
    "evaluate_reference",
    "inverse_transform",
    "is_shoulder_singular",
    "joint_angle_sigma",
    "joint_centres",
    "mirrored",
    "model_lengths",
    "segment_transforms",
    "segments_from_angles",
    "shoulder_angles",
    "shoulder_from_angles",
    "transform",
    "transform_point",
    "trunk_angles",
    "trunk_from_angles",
    "two_link_joint_angles",
    "two_link_pose",
    "two_link_velocity",
    "wrist_angles",
    "wrist_from_angles",
]
