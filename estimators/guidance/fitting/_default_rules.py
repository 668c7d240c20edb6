"""The rules of the house to begin with, and what they say."""

from typing import Final

import numpy as np

from estimators.errors import SetupError
from estimators.guidance._contract import GuidanceTemplate
from estimators.guidance._rules import CueRule, CueSide, StopRule
from estimators.leg import lower_segment
from estimators.sentences import Sentence, say

SENTENCES: Final[dict[str, Sentence]] = {
    one.code: one
    for one in (
        say("guidance.arm_to_side"),
        say("guidance.arm_not_across"),
        say("guidance.arm_in_front"),
        say("guidance.arm_not_back"),
        say("guidance.sit_tall"),
        say("guidance.stand_tall"),
        say("guidance.shoulder_down"),
        say("guidance.further"),
        say("guidance.slower"),
        say("guidance.quicker"),
        say("guidance.well_done"),
    )
}
"""What cues say, by code; `fitting_sentence` takes the one that fits an exercise. Rules may have other codes: the
therapist's own words."""
PRAISE: Final = "guidance.well_done"


RANGE_HOLD_S: Final = 0.05
LOST: Final = StopRule("lost", hold_s=2.0)
WRONG_IN_A_ROW: Final = StopRule("wrong_in_a_row", limit=3.0)
DEFAULT_STOPS: Final = (LOST, StopRule("unsure", limit=float(np.radians(15.0)), hold_s=5.0), WRONG_IN_A_ROW)
"""No tracking for 2 s, or a sigma over 15 degrees for 5 s; three wrong ones in a row."""


def range_limits(channel: str, low: float, high: float) -> tuple[StopRule, StopRule]:
    """Return the two stop rules of a range that must not be left, rad or m; 50 ms beyond it stop."""
    if not low < high:
        raise SetupError(f"the range of {channel} goes from {low} to {high}")
    return (
        StopRule("limit", low, channel, "below", RANGE_HOLD_S),
        StopRule("limit", high, channel, "above", RANGE_HOLD_S),
    )


def default_rules(ready: GuidanceTemplate, valid_share: float = 0.8) -> tuple[CueRule, ...]:
    """Return the rules of the house for the channels of a template.

    Parameters
    ----------
    valid_share : float
        q of (9): who counts from a smaller share on hears of range from a smaller one.

    Returns
    -------
    tuple of CueRule
        In order of priority.
    """
    plane = f"thorax_humerus_{ready.side}_yxy_plane_of_elevation"
    elevation = f"thorax_humerus_{ready.side}_yxy_elevation"
    rules: list[CueRule] = []
    is_leg = bool(lower_segment(ready.main))
    # How the arms are held says nothing of an exercise of the leg.
    if not is_leg and plane in ready.channels and elevation in ready.channels:
        planes: tuple[tuple[CueSide, str], ...] = (
            ("above", "guidance.arm_to_side"),
            ("below", "guidance.arm_in_front"),
        )
        rules += [
            CueRule(
                "at_equal",
                sentence,
                plane,
                elevation,
                float(np.radians(35.0)),
                side,
                tolerance=float(np.radians(18.0)),
            )
            for side, sentence in planes
        ]
    # An arm is helped by a trunk that leans forward, a leg by one that leans back as well.
    leaning: CueSide = "both" if is_leg else "above"
    compensation: tuple[tuple[str, float, str, CueSide], ...] = (
        ("trunk_lean_forward_rad", np.radians(8.0), "guidance.sit_tall", leaning),
        ("trunk_lean_lateral_rad", np.radians(7.0), "guidance.sit_tall", "both"),
        (f"shoulder_hike_{ready.side}_m", 0.025, "guidance.shoulder_down", "above"),
    )
    for priority, (channel, tolerance, sentence, side) in enumerate(compensation, start=2):
        if channel in ready.channels and not (is_leg and channel.startswith("shoulder_hike")):
            rules.append(
                CueRule(
                    "deviation", sentence, channel, side=side, tolerance=float(tolerance), priority=priority
                )
            )
    return (
        *rules,
        CueRule("range", "guidance.further", tolerance=1.0625 * valid_share, hold_s=0.15, priority=5),
        CueRule("fast", "guidance.slower", tolerance=1.45, hold_s=0.0, priority=6),
        CueRule("slow", "guidance.quicker", tolerance=1.5, hold_s=0.0, priority=7),
    )
