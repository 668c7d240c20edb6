"""Strides along turns, on the walk page and in the file of a walk."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from app.commands.processing.walk import write_walk
from app.kinds.walk.stored import content_of
from estimators import pipelines
from estimators.pipelines import SessionSetup
from estimators.simulation import gait_preset, simulate_gait


@pytest.mark.slow
def test_strides_along_turns_are_told_apart(tmp_path: Path) -> None:
    walked = simulate_gait(replace(gait_preset("turns", 1), rate_hz=100.0)).recording
    names = [name for name in walked.placements if name.startswith("heel")]
    feet = replace(walked, sensors={name.replace("heel", "foot"): walked.sensors[name] for name in names})
    walk = pipelines.analyse_walk(feet, SessionSetup("gait", ("foot_left", "foot_right"), 100.0))
    content = content_of(walk, None, "walk")
    write_walk(walk, tmp_path)
    written = json.loads((tmp_path / "walk.json").read_text())
    for foot in content.feet:
        told = {one.measure: one for one in foot.turning}
        assert told["stride_length"].count > 0
        own = walk.summary.turning[foot.side]["stride_length"]
        assert told["stride_length"].value == pytest.approx(own.value, abs=1e-4)
        assert written["turning"][foot.side]["stride_length"]["count"] == own.count
        straight = next(one for one in foot.measures if one.measure == "stride_length")
        assert straight.value != told["stride_length"].value
