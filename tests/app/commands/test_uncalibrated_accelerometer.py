"""`telemotion process` of a device as delivered: its accelerometer is corrected, and what that leaves is stated."""

from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from app.cli import cli

RATE_HZ = 100.0
G = 9.80665
SCALE, OFFSET_G = np.array([1.03, 0.97, 1.03]), np.array([0.05, -0.04, 0.08])
REGION = 7.81
"""Holds 95 % of chi-square with three degrees of freedom."""


def write(path: Path, *, has_field: bool, lasts_s: float = 20.0) -> Rotation:
    """Write a sensor that rests for 4 s and is then turned about all axes; return its attitudes."""
    at_s = np.arange(round(lasts_s * RATE_HZ)) / RATE_HZ
    generator = np.random.default_rng(7)
    waves = np.sin(np.outer(at_s, [1.1, 1.7, 2.3]) + np.array([0.3, 1.0, 2.0])) * [1.2, 1.0, 0.8]
    rate = waves * (at_s > 4.0)[:, None]
    turn, turns = Rotation.from_euler("xyz", [20.0, -15.0, 40.0], degrees=True), []
    for step in rate / RATE_HZ:
        turn = turn * Rotation.from_rotvec(step)
        turns.append(turn.as_quat())
    attitude = Rotation.from_quat(turns)
    push = 0.4 * np.sin(np.outer(at_s, [4.0, 5.0, 6.0])) * (at_s > 4.0)[:, None]
    force = attitude.inv().apply(push + np.array([0.0, 0.0, G])) * SCALE + OFFSET_G * G
    noise = generator.normal(size=(3, len(at_s), 3))
    columns = [at_s[:, None], rate + 0.005 + 0.003 * noise[0], force + 0.03 * noise[1]]
    names = ["time_s", *(f"gyr_{a} (rad/s)" for a in "xyz"), *(f"acc_{a} (m/s^2)" for a in "xyz")]
    if has_field:
        columns.append(attitude.inv().apply([0.0, 20.0, -44.0]) + 0.4 * noise[2])
        names += [f"mag_{a} (uT)" for a in "xyz"]
    np.savetxt(path, np.hstack(columns), "%.5f", ",", header=",".join(names), comments="")
    return attitude


@pytest.mark.parametrize("has_field", [True, False])
def test_a_device_as_delivered_is_corrected_told_and_inside_what_is_stated(
    tmp_path: Path, has_field: bool
) -> None:
    true = write(tmp_path / "table.csv", has_field=has_field)
    out = tmp_path / "out"
    done = CliRunner().invoke(cli, ["process", str(tmp_path / "table.csv"), "--guess", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "offset and scale error of the accelerometer were found from the movement" in done.stderr
    frames = pyarrow.parquet.read_table(out / "frames.parquet").to_pydict()
    late = slice(round(6.0 * RATE_HZ), None)
    (name,) = {column[:-4] for column in frames if column.endswith("_q_w")}
    found = Rotation.from_quat(np.stack([frames[f"{name}_q_{a}"] for a in "xyzw"], axis=1)[late])
    error = (found * true[late].inv()).as_rotvec()
    if not has_field:
        # Where it faced at first nobody knows.
        heading = Rotation.from_rotvec([0.0, 0.0, -float(np.median(error[:50, 2]))])
        error = (heading * found * true[late].inv()).as_rotvec()
    sigma = np.stack([frames[f"{name}_sigma_{a}_rad"] for a in "xyz"], axis=1)[late]
    assert np.degrees(np.sqrt(np.mean(np.sum(error**2, axis=1)))) < 3.0
    assert np.mean(np.sum((error / sigma) ** 2, axis=1) < REGION) > 0.8
