"""A source that fires bursts by itself: simulated to a packet log, processed to poses, compared with the truth."""

import csv
import json

import numpy as np
import pytest
from typer.testing import CliRunner

from app.cli import cli
from app.commands.simulation.relative import RelativeOptions, simulated
from app.gateway.source import FixedBursts, SourceControl
from app.network.messages import AcknowledgeMessage, ActuateMessage, ActuationPlanMessage
from estimators import rotation
from estimators.pipelines import angles_with_sigma

TICK_US = 1e6 / 120.0


def plan(coils=(1, 2, 3), limit_a=1.2):
    return ActuationPlanMessage(
        coils=list(coils),
        current_a=1.0,
        on_ticks=5,
        off_ticks=5,
        cycle_ticks=72,
        after_s=1.0,
        current_limit_a=limit_a,
    )


def run(control, first, count):
    return np.array([control.tick(TICK_US * k) for k in range(first, first + count)])


def test_a_source_fires_three_coils_by_itself_and_only_with_a_plan():
    control = SourceControl(TICK_US, FixedBursts())
    assert not run(control, 0, 100).any()
    control.hear(plan())
    control.hear(
        ActuateMessage(number=1, coil=2, current_a=1.0, on_ticks=20, not_before_us=0, not_after_us=10**12)
    )
    coil, current = run(control, 100, 144).T
    # 60 ms each in slots of 62.5 ms, every 600 ms; the limit of the plan holds, what is asked does not.
    on = [np.flatnonzero(coil == k + 1).tolist() for k in range(3)]
    assert [len(ticks) for ticks in on] == [16, 14, 16]
    assert on[0] == [*range(8), *range(72, 80)]
    assert on[1][0] == 8
    assert on[2][0] == 15
    assert set(current[coil > 0]) == {1.2}
    assert control.account.by_itself == 6
    assert control.account.asked == 0
    control.hear(plan(coils=()))
    assert not run(control, 244, 144).any()
    control.hear(plan())
    control.hear(AcknowledgeMessage.model_construct(state="closing"))
    assert not run(control, 388, 144).any()


def test_angles_are_those_of_the_axes_with_their_sigmas():
    q = rotation.multiply(
        rotation.multiply(rotation.about_z(np.array([0.4])), rotation.about_y(np.array([-0.3]))),
        rotation.about_x(np.array([0.7])),
    )
    angle, sigma = angles_with_sigma(q, np.diag([1e-4, 4e-4, 9e-4])[None])
    np.testing.assert_allclose(angle, [[0.4, -0.3, 0.7]], atol=1e-12)
    rng = np.random.default_rng(1)
    draws = rotation.exp(rng.normal(0.0, [0.01, 0.02, 0.03], (4000, 3)))
    spread = angles_with_sigma(rotation.multiply(q, draws), np.zeros((4000, 3, 3)))[0].std(axis=0)
    np.testing.assert_allclose(spread, sigma[0], rtol=0.06)


def read(path):
    with path.open() as file:
        rows = list(csv.DictReader(file))
    return {
        name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0] if "flags" not in name
    }


@pytest.mark.slow
def test_from_simulate_to_process(tmp_path):
    log, out = tmp_path / "hip.tml", tmp_path / "out"
    words = [
        "simulate",
        "--relative",
        "walk_leg",
        "--bursts",
        "--seconds",
        "14",
        "--seed",
        "4",
        "--to",
        str(log),
    ]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    assert "pulses" in done.output
    words = ["process", str(log), "--pipeline", "magnetic_bursts", "--out", str(out)]
    done = CliRunner().invoke(cli, [*words, "--parameters", '{"gain_sigma": 0.002}'])
    assert done.exit_code == 0, done.output
    assert "thigh_left against pelvis" in done.output
    scene = simulated(RelativeOptions(relative="walk_leg", duration_s=14.0, seed=4, bursts=True)).scene
    poses = {name: read(out / f"thigh_left_{name}.csv") for name in ("bursts", "filter", "smoothed")}
    rms = {}
    for name, found in poses.items():
        prefix = "alone_" if name == "bursts" else ""
        ticks = np.round(found["time_s"] * 120.0).astype(int)
        keep = (found["time_s"] > 2.0) & np.isfinite(found[f"{prefix}x_m"])
        place = np.column_stack([found[f"{prefix}{axis}_m"] for axis in "xyz"])
        error = (place - scene.position_m[ticks])[keep]
        rms[name] = float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
        if name != "bursts":
            sigma = np.column_stack([found[f"{axis}_sigma_m"] for axis in "xyz"])[keep]
            assert 0.3 < np.mean((error / sigma) ** 2) < 2.0, name
            truth = np.degrees(
                angles_with_sigma(scene.q_source_sensor[ticks], np.zeros((len(ticks), 3, 3)))[0]
            )
            off = (found["flexion_deg"] - truth[:, 1])[keep]
            assert np.sqrt(np.mean(off**2)) < 1.5
    assert rms["smoothed"] < 0.7 * rms["filter"]
    assert rms["filter"] < 0.7 * rms["bursts"]
    assert rms["smoothed"] < 8e-3
    report = json.loads((out / "report.json").read_text())
    told = report["sensors"]["thigh_left"]
    assert report["source"] == "pelvis"
    assert told["used"] == told["bursts"] == len(poses["bursts"]["time_s"]) > 20
    assert (
        told["tracker_alone_from_smoothed"]["position_mm"]
        > told["tracker_carried_from_smoothed"]["position_mm"]
    )
    assert 0.5 < told["misfit"] < 1.5


def test_words_that_cannot_be_used(tmp_path):
    log = tmp_path / "walk.tml"
    done = CliRunner().invoke(cli, ["simulate", "--relative", "flexion", "--to", str(log)])
    assert "--bursts" in str(done.exception)
    log.write_bytes(b"TML1")
    words = ["process", str(log), "--pipeline", "magnetic_bursts", "--out", str(tmp_path)]
    for more, reason in (
        (["--format", "csv"], "packet logs"),
        (["--rate", "100"], "--rate"),
        (["--parameters", "[1]"], "JSON object"),
        ([], "cut off"),
    ):
        done = CliRunner().invoke(cli, [*words, *more])
        assert done.exit_code
        assert reason in str(done.exception), done.exception
