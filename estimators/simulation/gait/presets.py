"""Named walks: those of the published protocols, and impaired ones."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from estimators.conventions import SIDES, Side
from estimators.errors import SetupError
from estimators.simulation.gait.course import Bout, FootStyle, Leg, WalkStyle, other
from estimators.simulation.gait.scenario import GaitScenario
from estimators.simulation.gait.upper import BodyStyle


def _ankle() -> GaitScenario:
    return GaitScenario(
        WalkStyle(1.3, 1.29, 0.12, stride_length_sd_m=0.02, lateral_sd_m=0.01),
        BodyStyle(68.0, com_height_m=0.95, bob_m=0.006),
        (Bout((Leg(10),)),),
        rate_hz=50.0,
    )


def _placement() -> GaitScenario:
    return GaitScenario(
        WalkStyle(1.15, 1.25, 0.10, stride_length_sd_m=0.035, lateral_sd_m=0.020),
        BodyStyle(68.0, com_height_m=0.95, bob_m=0.015),
        (Bout((Leg(16),)),),
        rate_hz=50.0,
    )


def _mass_centre() -> GaitScenario:
    feet = {side: FootStyle(toe_out_rad=float(np.radians(10.0))) for side in SIDES}
    return GaitScenario(
        WalkStyle(1.5, 0.95, 0.18, stride_length_sd_m=0.04, lateral_sd_m=0.02, feet=feet),
        BodyStyle(86.6, com_height_m=0.99, bob_m=0.012),
        (Bout((Leg(18),)),),
        rate_hz=50.0,
    )


def stroke_feet(paretic: Side) -> dict[Side, FootStyle]:
    """Return legs after a stroke: short late steps of an outward, dropped and circumducted paretic foot."""
    affected = FootStyle(
        pitch_scale=0.6,
        landing_pitch_rad=float(np.radians(8.0)),
        toe_out_rad=float(np.radians(25.0)),
        clearance_m=0.03,
        circumduction_m=0.06,
        length_scale=0.8,
        step_time_scale=1.2,
    )
    sound = FootStyle(toe_out_rad=float(np.radians(10.0)), step_time_scale=0.8)
    return {paretic: affected, other(paretic): sound}


def _stroke() -> GaitScenario:
    base = _mass_centre()
    return replace(base, walk=replace(base.walk, standing_left_share=0.38, feet=stroke_feet("left")))


def _shuffling() -> GaitScenario:
    foot = FootStyle(pitch_scale=0.25, landing_pitch_rad=float(np.radians(-3.0)), clearance_m=0.02)
    walk = WalkStyle(1.3, 0.5, 0.10, feet={"left": foot, "right": foot})
    return GaitScenario(walk, BodyStyle(75.0, bob_m=0.004), (Bout((Leg(24),)),))


def _stairs() -> GaitScenario:
    up = Bout((Leg(4), Leg(8, rise_m=0.17, length_scale=0.5), Leg(6)), 2.0)
    down = Bout((Leg(4), Leg(8, rise_m=-0.17, length_scale=0.5), Leg(6)))
    return GaitScenario(WalkStyle(1.3, 1.2), BodyStyle(70.0), (up, down))


def _turns() -> GaitScenario:
    there = Leg(5, turn_rad=float(np.pi), length_scale=0.4)
    return GaitScenario(course=(Bout((Leg(8), there, Leg(8), replace(there, turn_rad=-float(np.pi)))),))


_PRESETS: Final[dict[str, Callable[[], GaitScenario]]] = {
    "ankle": _ankle,
    "placement": _placement,
    "centre_of_mass": _mass_centre,
    "stroke": _stroke,
    "shuffling": _shuffling,
    "stairs": _stairs,
    "turns": _turns,
}
GAIT_PRESETS: Final = tuple(_PRESETS)


def gait_preset(name: str, seed: int = 0) -> GaitScenario:
    """Return a named walk; change it with `dataclasses.replace`.

    Parameters
    ----------
    name : str
        `ankle`, `placement` and `centre_of_mass` are the presets CH2, CH3 and CH4 of the instrumented-shoe
        protocols; `stroke`, `shuffling`, `stairs` and `turns` are ours.

    Raises
    ------
    SetupError
        If no preset has that name.
    """
    if name not in _PRESETS:
        raise SetupError(f"no walk is named {name!r}; known: {', '.join(_PRESETS)}")
    return replace(_PRESETS[name](), seed=seed)


def eyes_closed(scenario: GaitScenario, lateral_sd_m: float, length_change_m: float) -> GaitScenario:
    """Return the same person walking with closed eyes: slower, shorter and more variable steps.

    Parameters
    ----------
    scenario : GaitScenario
        With open eyes.
    lateral_sd_m : float
        Added to that of the footholds.
    length_change_m : float
        Added to the stride length, negative as a rule.
    """
    walk = scenario.walk
    return replace(
        scenario,
        walk=replace(
            walk,
            stride_time_s=1.03 * walk.stride_time_s,
            stride_length_m=walk.stride_length_m + length_change_m,
            stride_length_sd_m=walk.stride_length_sd_m * 9.0 / 7.0,
            lateral_sd_m=walk.lateral_sd_m + lateral_sd_m,
        ),
    )
