"""The arm: segment orientations in, joint centres and joint angles out.

`ArmModel.evaluate` is the live path (compiled, one call a chunk). The other functions are its plain
numpy parts, for tests, simulation and work on whole recordings.
"""

from estimators.arm._model import ArmModel, ArmResult, model_lengths
from estimators.arm._names import (
    MODEL_ANGLES,
    MODEL_POINTS,
    MODEL_SCALARS,
    MODEL_SEGMENTS,
    angle_name,
)
from estimators.body import BodyDimensions, body_from_stature

__all__ = [
    "MODEL_ANGLES",
    "MODEL_POINTS",
    "MODEL_SCALARS",
    "MODEL_SEGMENTS",
    "ArmModel",
    "ArmResult",
    "BodyDimensions",
    "angle_name",
    "body_from_stature",
    "model_lengths",
]
