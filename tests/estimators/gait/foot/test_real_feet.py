"""Recordings of real feet, one parameter set; the required figures are those of the product's issue."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import validation
from estimators.recording import Recording, SensorSignals

FEET = Path(__file__).parents[3] / "data" / "feet"


def signals(content, side=""):
    tail = f"_{side}" if side else ""
    gyroscope = content[f"gyroscope{tail}_radps"].astype(float)
    time_s = content["time_s"] if "time_s" in content else np.arange(len(gyroscope)) / 204.8
    return SensorSignals(time_s, gyroscope, content[f"accelerometer{tail}_mps2"].astype(float))


@cache
def recordings():
    walk, loop, strides = (
        np.load(FEET / f"{name}.npz") for name in ("pyshoe_walk", "xio_short_walk", "gaitmap_strides")
    )
    kept = {name: strides[name].astype(float) for name in strides.files}
    return {
        "walk": Recording(
            {"foot_right": signals(walk)},
            200.0,
            metadata={"format": "pyshoe", "gyroscope_clip_radps": "9.09"},
            reference={"position_xy_m": walk["position_xy_m"].astype(float)},
        ),
        "loop": Recording({"foot_right": signals(loop)}, 398.0, metadata={"format": "gait_tracking"}),
        "strides": Recording(
            {f"foot_{side}": signals(strides, side) for side in ("left", "right")},
            204.8,
            metadata={"format": "gaitmap", "walk": "imu_sample"},
            reference=kept,
        ),
    }


@pytest.mark.parametrize("name", ["foot_walks", "foot_strides", "foot_loops"])
def test_real_feet_keep_what_is_required(name):
    (result,) = validation.run([name], seeds=1, data=recordings())
    assert result.verdict == "pass", validation.to_table([result])


def test_all_57_strides_are_scored():
    (result,) = validation.run(["foot_strides"], seeds=1, data=recordings())
    assert result.figure("strides").median == 57
