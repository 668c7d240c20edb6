"""No cue contradicts its exercise: its posture, its side, the direction of its arm, its limb; in every language."""

import re
from typing import get_args

import numpy as np
import pytest

from app.assessment.design.rules import whole_design
from app.demo.people import EXERCISES
from app.exercises.design import CueDesign, TemplateDesign
from app.exercises.models import Posture
from estimators.comparison import Template
from estimators.guidance import SENTENCES
from messages import messages_in

SITTING = re.compile(
    r"\b(sit|sits|sitting|seat|seated|chair|lap)\b|\b(sitzen|sitzt|hinsetzen|setzen sie sich)|stuhl|lehne",
    re.IGNORECASE,
)
STANDING = re.compile(r"\bstand|\b(steh|stellen sie sich)", re.IGNORECASE)
TO_THE_SIDE = re.compile(r"keep the arm to the side|seitlich lassen", re.IGNORECASE)
IN_FRONT = re.compile(r"keep the arm in front|vorn lassen", re.IGNORECASE)
OF_AN_ARM = re.compile(r"\b(arm|shoulder|hand|elbow|schulter|ellbogen)", re.IGNORECASE)

DIRECTIONS = {"reaching": 80.0, "drinking": 70.0, "flexion": 90.0, "abduction": 0.0, "pronation": 10.0}
"""Plane of elevation of an arm, degrees: 0 to the side, 90 forward."""
KNEE = "thigh_shank_{side}_zxy_flexion"
CASES = [
    (one.movement, one.primary_angle.replace("_left_", "_{side}_").replace("_right_", "_{side}_"))
    for one in EXERCISES
    if one.primary_angle
] + [("other", KNEE)]


def template_of(movement: str, angle: str, side: str) -> Template:
    """A repetition with everything that can be measured: arm, trunk and shoulder, raised to 90 degrees and back."""
    primary = angle.format(side=side)
    out = np.sin(np.linspace(0.0, np.pi, 101))
    curves = {
        primary: np.radians(20.0 + 70.0 * out),
        f"thorax_humerus_{side}_yxy_elevation": np.radians(10.0 + 80.0 * out),
        f"thorax_humerus_{side}_yxy_plane_of_elevation": np.full(
            101, np.radians(DIRECTIONS.get(movement, 0.0))
        ),
        "trunk_lean_forward_rad": np.radians(2.0 * out),
        "trunk_lean_lateral_rad": np.radians(1.0 * out),
        f"shoulder_hike_{side}_m": 0.005 * out,
    }
    channels = tuple(curves)
    return Template(
        channels=channels,
        mean=np.stack([curves[name] for name in channels], axis=1),
        tolerance=np.full((101, len(channels)), np.radians(6.0)),
        duration_s=3.0,
        duration_sd_s=0.2,
        repetition_count=5,
        primary_channel=primary,
        side=side,
        reach_m=0.55,
        measures={},
        measure_sd={},
    )


@pytest.mark.parametrize("words", [messages_in("en"), messages_in("de")], ids=["en", "de"])
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("posture", get_args(Posture))
@pytest.mark.parametrize(("movement", "angle"), CASES, ids=[f"{one[0]}-{one[1][:12]}" for one in CASES])
def test_no_cue_contradicts_its_exercise(movement, angle, posture, side, words):
    template = template_of(movement, angle, side)
    # As the house proposes them, and every sentence that was ever stored for a rule of this exercise.
    stored = [
        CueDesign(quantity="deviation", sentence=code, channel="trunk_lean_forward_rad") for code in SENTENCES
    ]
    of_house = whole_design(TemplateDesign(), template, posture).cues
    kept = whole_design(TemplateDesign(cues=stored), template, posture).cues
    assert of_house
    assert len(kept) == len(SENTENCES)
    said = [words[one.sentence] for one in (*of_house, *kept)]
    forbidden = {"standing": SITTING, "seated": STANDING}[posture]
    assert not [one for one in said if forbidden.search(one)]
    if movement != "other":
        wrong_way = IN_FRONT if DIRECTIONS[movement] < 45.0 else TO_THE_SIDE
        assert not [one for one in said if wrong_way.search(one)]
        # There is still one sentence for each way in which the arm leaves its direction.
        assert len({one.sentence for one in of_house if one.quantity == "at_equal"}) == 2
    else:
        assert not [one for one in (words[cue.sentence] for cue in of_house) if OF_AN_ARM.search(one)]


@pytest.mark.parametrize("words", [messages_in("en"), messages_in("de")], ids=["en", "de"])
def test_what_stops_an_exercise_speaks_of_no_posture(words):
    said = [entry for code, entry in words.items() if code.startswith("guided.")]
    assert len(said) > 10
    assert not [one for one in said if SITTING.search(one) or STANDING.search(one)]
