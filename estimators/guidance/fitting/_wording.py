"""Which of the house's sentences fits an exercise: by its posture, and by the direction in which its arm goes."""

from collections.abc import Sequence
from typing import Final, Literal

import numpy as np

from estimators.recording import Float

Posture = Literal["standing", "seated"]
"""How an exercise is done."""
_UPRIGHT: Final[dict[Posture, str]] = {"standing": "guidance.stand_tall", "seated": "guidance.sit_tall"}
_TOO_FAR_IN: Final = {"side": "guidance.arm_to_side", "front": "guidance.arm_not_across"}
_TOO_FAR_OUT: Final = {"side": "guidance.arm_not_back", "front": "guidance.arm_in_front"}
_FAMILIES: Final = (_TOO_FAR_IN, _TOO_FAR_OUT)
_FRONT_RAD: Final = float(np.radians(45.0))
"""Plane of elevation from which on an arm goes forward: 0 is to the side, 90 degrees straight ahead."""


def fitting_sentence(sentence: str, posture: Posture, channels: Sequence[str], mean: Float) -> str:
    """Return the sentence of the same fault that fits an exercise; all others as they are.

    The one place that knows of posture and direction: a rule may have been stored before either changed.

    Parameters
    ----------
    sentence : str
        Code of a cue.
    channels : sequence of str
        C names.
    mean : ndarray, shape (P, C)
        The template's curves, rad and m.
    """
    if sentence in _UPRIGHT.values():
        return _UPRIGHT[posture]
    for family in _FAMILIES:
        if sentence in family.values():
            return family["front" if _goes_forward(channels, mean) else "side"]
    return sentence


def _goes_forward(channels: Sequence[str], mean: Float) -> bool:
    """Say whether the arm is raised forward: by its plane of elevation where it is raised most."""
    names = list(channels)
    for number, name in enumerate(names):
        elevation = name.replace("_plane_of_elevation", "_elevation")
        if elevation == name or elevation not in names:
            continue
        raised = np.where(np.isfinite(mean[:, number]), mean[:, names.index(elevation)], np.nan)
        if np.isfinite(raised).any():
            return bool(abs(mean[int(np.nanargmax(raised)), number]) >= _FRONT_RAD)
    return False
