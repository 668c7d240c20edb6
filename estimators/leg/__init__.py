"""The leg: segment orientations in, angles of hip, knee and ankle out.

`LegModel.write` is the live path (compiled, one call a chunk); `joint_angles` and `from_angles` of `published` are its
plain numpy parts.
"""

from estimators.leg._joint_angles import leg_from_angles
from estimators.leg._model import LegModel
from estimators.leg._names import LEG_ANGLES, lower_segment

__all__ = ["LEG_ANGLES", "LegModel", "leg_from_angles", "lower_segment"]
