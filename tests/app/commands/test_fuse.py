"""`telemotion fuse`: our packet log with a CSV of markers, and what cannot be fused, told in words."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from app import readers
from app.cli import cli
from app.errors import TelemotionError
from app.network.packet_log import write_log
from estimators.recording import Recording, SensorSignals
from validation.optical.scenes import Scene, free_motion

APART_S = 0.75


@pytest.fixture(scope="module")
def scene() -> Scene:
    return free_motion(5, 15.0)


@pytest.fixture(scope="module")
def files(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return a packet log of two sensors and a CSV of one marker on the hand, on a later clock."""
    folder = tmp_path_factory.mktemp("fuse")
    other = free_motion(6, 15.0)
    worn = {
        name: SensorSignals(scene.time_s, one.chunk.gyroscope_radps, one.chunk.accelerometer_mps2)
        for name, one in (("forearm_right", other), ("hand_right", scene))
    }
    prepared = readers.packets_of(Recording(worn, 100.0))
    log = folder / "hand.tml"
    log.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(5))))
    rows = ["time_s,HAND_x,HAND_y,HAND_z"]
    # The cameras begin later than the sensors.
    for t, place in zip(scene.time_s[75:], scene.chunk.marker_m[75:] * 1e3, strict=True):
        is_hidden = 9.0 <= t < 10.5
        rows.append(f"{t:.4f}," + (",," if is_hidden else ",".join(f"{x:.3f}" for x in place)))
    markers = folder / "markers.csv"
    markers.write_text("\n".join(rows))
    return log, markers


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open() as file:
        rows = list(csv.reader(file))
    columns = zip(*rows[1:], strict=True)
    return {
        name: np.array([float(x) if x else np.nan for x in column])
        if name not in {"use", "withheld"}
        else column
        for name, column in zip(rows[0], columns, strict=True)
    }


def three(found: dict[str, np.ndarray], name: str, unit: str = "m") -> np.ndarray:
    return np.column_stack([found[f"{name}_{axis}_{unit}"] for axis in "xyz"])


@pytest.mark.slow
def test_motion_residuals_and_gaps_are_written(
    scene: Scene, files: tuple[Path, Path], tmp_path: Path
) -> None:
    log, markers = files
    out = tmp_path / "out"
    done = CliRunner().invoke(
        cli, ["fuse", str(log), str(markers), "--sensor", "hand_right", "--out", str(out), "--lag", "2"]
    )
    assert done.exit_code == 0, done.output
    smoothed, live = table(out / "motion.csv"), table(out / "filter.csv")
    rows = np.rint(smoothed["time_s"] * 100).astype(int)
    np.testing.assert_allclose(rows, smoothed["time_s"] * 100, atol=0.1)
    hidden = smoothed["is_gap"] > 0
    assert hidden.sum() == pytest.approx(150, abs=2)
    error, live_error = (
        np.linalg.norm(three(one, "position") - scene.position_m[rows], axis=1) for one in (smoothed, live)
    )
    known = np.isfinite(error)
    assert error[known].max() < 0.005
    # In the gap nothing but the smoother knows how it ends.
    assert error[hidden].max() < 0.5 * live_error[hidden].max()
    lagged = np.linalg.norm(three(table(out / "lagged.csv"), "position") - scene.position_m[rows], axis=1)
    assert lagged[hidden].max() < 0.6 * live_error[hidden].max()
    np.testing.assert_allclose(three(smoothed, "measured")[hidden], np.nan)
    acceleration = three(smoothed, "acceleration", "mps2") - scene.acceleration_mps2[rows]
    assert np.sqrt(np.nanmean(acceleration[known] ** 2)) < 0.05
    turned = np.column_stack([smoothed[f"q_room_sensor_{part}"] for part in "wxyz"])
    alike = np.abs(np.sum(turned * scene.q_room_sensor[rows], axis=1))[known]
    assert np.degrees(2.0 * np.arccos(np.minimum(alike, 1.0))).max() < 1.0
    report = json.loads((out / "report.json").read_text())
    # Times of the file count from its first frame.
    assert report["offset_s"] == pytest.approx(-APART_S, abs=0.001)
    assert "curves" not in report
    gaps, residuals = table(out / "gaps.csv"), table(out / "residuals.csv")
    assert gaps["start_s"] == pytest.approx([9.0], abs=0.02)
    assert gaps["length_s"] == pytest.approx([1.5], abs=0.02)
    assert report["gaps"][0]["start_s"] == pytest.approx(gaps["start_s"][0], abs=1e-3)
    assert len(residuals["time_s"]) >= report["used_count"] > 1200
    np.testing.assert_allclose(residuals["time_s"] - residuals["camera_time_s"], APART_S, atol=0.001)
    distances = residuals["distance_m"][[use == "measured" for use in residuals["use"]]]
    assert np.sqrt(np.mean(distances**2)) == pytest.approx(np.linalg.norm(report["residual_rms_m"]), rel=0.01)
    assert "1 gaps, the longest 1.50 s" in done.output
    wrong = CliRunner().invoke(
        cli, ["fuse", str(log), str(markers), "--sensor", "forearm_right", "--out", str(tmp_path / "no")]
    )
    assert "do not fit this sensor" in str(wrong.exception)


def test_what_cannot_be_fused_is_told(files: tuple[Path, Path], tmp_path: Path) -> None:
    log, markers = files
    out = ["--out", str(tmp_path / "out")]

    def refused(*words: str) -> str:
        found = CliRunner().invoke(cli, ["fuse", str(log), *words, *out]).exception
        assert isinstance(found, TelemotionError), found
        return str(found)

    assert "say with --sensor" in refused(str(markers))
    assert "has no sensor foot_left; it has forearm_right, hand_right" in refused(
        str(markers), "--sensor", "foot_left"
    )
    assert "has no marker ELBOW; it has HAND" in refused(
        str(markers), "--sensor", "hand_right", "--marker", "ELBOW"
    )
    broken = tmp_path / "broken.c3d"
    broken.write_bytes(b"no markers at all")
    assert "C3D" in refused(str(broken), "--sensor", "hand_right")
    assert not (tmp_path / "out").exists()
