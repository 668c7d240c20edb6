"""`telemotion process --pipeline gait` on a real walk, and on one that cannot be used."""

import csv
import json
from pathlib import Path

import numpy as np
import scipy.io
from typer.testing import CliRunner

from app.cli import cli

FEET = Path(__file__).parents[2] / "data" / "feet"


def test_a_walk_becomes_frames_strides_and_numbers(tmp_path):
    content = np.load(FEET / "pyshoe_walk.npz")
    path = tmp_path / "walk.mat"
    scipy.io.savemat(
        path,
        {
            "imu_data": np.concatenate([content["accelerometer_mps2"], content["gyroscope_radps"]], axis=1),
            "timestamps_all": content["time_s"][None, :],
        },
    )
    out = tmp_path / "out"
    done = CliRunner().invoke(cli, ["process", str(path), "--out", str(out), "--pipeline", "gait"])
    assert done.exit_code == 0, done.output
    with (out / "strides.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 5
    assert {row["foot"] for row in rows} == {"right"}
    lengths = np.array([float(row["length_m"]) for row in rows])
    assert 0.5 < np.median(lengths) < 2.5
    walk = json.loads((out / "walk.json").read_text())
    assert walk["feet"]["right"]["stride_length"]["unit"] == "m"
    assert walk["reasons"]
    assert (out / "frames.csv").exists()
    assert "stride_length" in done.output
