"""The arm: segment orientations in, joint centres and joint angles out.

`ArmModel.evaluate` is the live path (compiled, one call a chunk). The other functions are its plain
numpy parts, for tests, simulation and work on whole recordings; `evaluate_reference` is its twin.
"""

from estimators.arm._heading_constraint import (
    HeadingConstraintParameters,
    HeadingConstraintResult,
    HingeJoint,
    JointHeadingConstraint,
)
from estimators.arm._joint_angles import segments_from_angles
from estimators.arm._model import ArmModel, ArmResult, model_lengths
from estimators.arm._motion import ACCELERATION_WINDOW_S, PointMotion, point_motion
from estimators.arm._names import MODEL_ANGLES, Joint
from estimators.arm._points import LengthSigma, PointCovariance, arm_points, point_covariance
from estimators.arm._sequences import Sequence, SequenceAngles, frames_in_sequence, sequence_names
from estimators.body import BodyDimensions

__all__ = [
    "ACCELERATION_WINDOW_S",
    "MODEL_ANGLES",
    "ArmModel",
    "ArmResult",
    "BodyDimensions",
    "HeadingConstraintParameters",
    "HeadingConstraintResult",
    "HingeJoint",
    "Joint",
    "JointHeadingConstraint",
    "LengthSigma",
    "PointCovariance",
    "PointMotion",
    "Sequence",
    "SequenceAngles",
    "arm_points",
    "frames_in_sequence",
    "model_lengths",
    "point_covariance",
    "point_motion",
    "segments_from_angles",
    "sequence_names",
]
