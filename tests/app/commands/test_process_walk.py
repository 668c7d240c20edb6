"""`telemotion process --pipeline gait` on a real walk, and on one that cannot be used."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from typer.testing import CliRunner

from app.cli import cli
from app.readers import write_instrumented_shoe
from estimators.simulation import gait_preset, simulate_gait

FEET = Path(__file__).parents[2] / "data" / "feet"


def test_a_walk_becomes_frames_strides_and_numbers(tmp_path):
    with np.load(FEET / "pyshoe_walk.npz") as content:
        scipy.io.savemat(
            path := tmp_path / "walk.mat",
            {
                "imu_data": np.concatenate(
                    [content["accelerometer_mps2"], content["gyroscope_radps"]], axis=1
                ),
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


@pytest.mark.slow
def test_forces_of_two_shoes_are_written_too_or_the_reason_why_not(tmp_path):
    sim = simulate_gait(replace(gait_preset("stroke", 1), rate_hz=100.0))
    names = [f"{part}_{side}" for side in ("left", "right") for part in ("heel", "forefoot", "shank")]
    recording = replace(sim.recording, sensors={name: sim.recording.sensors[name] for name in names})
    dead = replace(
        recording.sensors["heel_left"],
        force_n=np.zeros_like(recording.sensors["heel_left"].force_n),
        moment_nm=np.zeros_like(recording.sensors["heel_left"].moment_nm),
    )
    broken = replace(recording, sensors={**recording.sensors, "heel_left": dead})
    walks = []
    for number, one in enumerate((recording, broken)):
        path, out = tmp_path / f"shoes{number}.csv", tmp_path / f"out{number}"
        write_instrumented_shoe(one, path)
        done = CliRunner().invoke(cli, ["process", str(path), "--out", str(out), "--pipeline", "gait"])
        assert done.exit_code == 0, done.output
        walks.append((json.loads((out / "walk.json").read_text()), (out / "forces.csv").exists()))
    (whole, has_forces), (without, has_none) = walks
    assert has_forces
    assert whole["balance"]["mass_kg"] == pytest.approx(sim.truth.mass_kg, abs=0.5)
    assert whole["both"]["step_width"]["count"] > 5
    with (tmp_path / "out0" / "forces.csv").open() as file:
        rows = list(csv.DictReader(file))
    most = max(float(row["left_force_z_n"]) for row in rows)
    assert most == pytest.approx(1.1 * 9.81 * sim.truth.mass_kg, rel=0.1)
    assert not has_none
    assert "balance" not in without
    assert any(reason.lower().startswith("no forces: left shoe") for reason in without["reasons"])
