"""Lengths of the patient's segments, measured or scaled from stature.

A module of its own, below `arm` and `pipelines`, because both need it.
"""

from dataclasses import dataclass

from estimators.errors import SetupError
from estimators.sentences import say

UPPER_ARM_PER_STATURE = 0.186
FOREARM_PER_STATURE = 0.146
HAND_PER_STATURE = 0.108
SHOULDER_HEIGHT_PER_STATURE = 0.818
HIP_HEIGHT_PER_STATURE = 0.530
ANKLE_HEIGHT_PER_STATURE = 0.039
EYE_HEIGHT_PER_STATURE = 0.936
"""Drillis and Contini (1966), printed in Winter, Biomechanics and Motor Control of Human Movement, 4.1."""

SHOULDER_WIDTH_PER_STATURE = 0.36 / 1.70
"""House value: shoulder *joint centres* lie well inside the 0.259 of stature of the biacromial breadth."""


@dataclass(frozen=True)
class BodyDimensions:
    """Lengths of the patient's segments; defaults are those of a person 1.70 m tall.

    All between joint centres, in metres. `stature_m` scales what was not measured.
    """

    stature_m: float = 1.70
    upper_arm_m: float = 0.30
    forearm_m: float = 0.25
    hand_m: float = 0.18
    shoulder_width_m: float = 0.36
    trunk_m: float = 0.50
    """From the middle of the hips to the height of the shoulders."""


def body_from_stature(stature_m: float) -> BodyDimensions:
    """Return all segment lengths scaled from stature alone.

    Parameters
    ----------
    stature_m : float
        Body height, 0.5 to 2.5 m.

    Returns
    -------
    BodyDimensions
        Drillis and Contini's fractions of stature (upper arm 0.186, forearm 0.146, hand 0.108, shoulder
        height 0.818 less hip height 0.530) and the house value for the distance of the shoulder centres.

    Raises
    ------
    SetupError
        If the stature is no human height; a likely cause is centimetres.
    """
    if not 0.5 <= stature_m <= 2.5:
        raise SetupError(say("body.stature", stature_m=stature_m))
    return BodyDimensions(
        stature_m=stature_m,
        upper_arm_m=UPPER_ARM_PER_STATURE * stature_m,
        forearm_m=FOREARM_PER_STATURE * stature_m,
        hand_m=HAND_PER_STATURE * stature_m,
        shoulder_width_m=SHOULDER_WIDTH_PER_STATURE * stature_m,
        trunk_m=(SHOULDER_HEIGHT_PER_STATURE - HIP_HEIGHT_PER_STATURE) * stature_m,
    )
