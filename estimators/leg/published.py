"""The numpy parts of the leg, for tests and simulation."""

from estimators.leg._joint_angles import from_angles, joint_angle_sigma, joint_angles
from estimators.leg._names import JOINTS, LegJoint

__all__ = ["JOINTS", "LegJoint", "from_angles", "joint_angle_sigma", "joint_angles"]
