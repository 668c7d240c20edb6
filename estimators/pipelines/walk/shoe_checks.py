"""Whether what instrumented shoes say can be: loads, saturation, floors, and which foot is which."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from estimators.conventions import GRAVITY_MPS2, SIDES, Side
from estimators.errors import SetupError
from estimators.gait import Strides
from estimators.kinetics import ShoeKinetics, clipped_at
from estimators.recording import Recording
from estimators.sentences import say

_SINGLE_LOAD_N: Final = (200.0, 3000.0)
_LEAST_SINGLE_SHARE: Final = 0.5
"""With a stick a foot that stands alone may carry so little of what the other does."""
_STEP_UP_M: Final = 0.1
EXCHANGED_M: Final = -0.03
"""The left foot stands to the right of the right one by more than feet cross."""
EXCHANGED: Final = say("shoes.exchanged")


def refuse_stairs(strides: Mapping[Side, Strides]) -> None:
    """Refuse a walk with steps up or down: mass and pressure are found over one floor.

    Raises
    ------
    SetupError
        A stride rises or falls by more than 10 cm.
    """
    for side, foot in strides.items():
        if foot.count and (rise_m := np.nanmax(np.abs(foot.rise_m))) > _STEP_UP_M:
            raise SetupError(say("shoes.stairs", side=side, rise_m=rise_m))


def saturated(recording: Recording, mass_kg: float) -> list[str]:
    """Return a sentence for each load cell that stands still at a level above half the body weight."""
    said: list[str] = []
    for name, sensor in recording.sensors.items():
        level = None if sensor.force_n is None else clipped_at(sensor.force_n, 0.5 * mass_kg * GRAVITY_MPS2)
        if level is not None:
            said.append(say("shoes.clipped", where=[name], level_n=level))
    return said


def refuse_wrong_loads(shoes: Mapping[Side, ShoeKinetics]) -> None:
    """Refuse shoes of which one carries alone what nobody weighs, or far less than the other does."""
    alone: dict[Side, float] = {}
    for side in SIDES:
        other = shoes["right" if side == "left" else "left"].contact.any
        single = shoes[side].contact.any & ~other
        if single.any():
            alone[side] = float(np.median(shoes[side].reaction.force_n[single, 2]))
    if not alone:
        return
    most = max(alone.values())
    for side, load in alone.items():
        if not _SINGLE_LOAD_N[0] < load < _SINGLE_LOAD_N[1]:
            raise SetupError(say("shoes.no_weight", side=side, load_n=load))
        if load < _LEAST_SINGLE_SHARE * most:
            raise SetupError(say("shoes.loads_apart", side=side, load_n=load, other_n=most))
