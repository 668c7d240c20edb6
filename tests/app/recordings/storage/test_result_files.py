"""Files of a result: every column has unit and meaning, and how it was made is beside it."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest
from typer.testing import CliRunner

from app.cli import cli
from app.live.blocks import encode_block
from app.recordings.column_words import FLAGS
from app.recordings.columns import dictionary, frames_table
from app.version import service_version
from estimators import pipelines
from estimators.orientation import OrientationFlag
from estimators.pipelines import FrameLayout, Frames, SessionSetup
from tests.app.readers.odd_tables import odd_tables


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    (folder / "box.csv").write_bytes(odd_tables()["letters"].content)
    done = CliRunner().invoke(
        cli, ["process", str(folder / "box.csv"), "--guess", "--force", "--out", str(folder)]
    )
    assert done.exit_code == 0, done.output
    return folder


def test_each_column_says_unit_and_meaning_in_both_places(results):
    schema = pyarrow.parquet.read_schema(results / "frames.parquet")
    columns = json.loads((results / "columns.json").read_text())
    assert [one["name"] for one in columns] == schema.names
    assert pyarrow.csv.read_csv(results / "frames.csv").column_names == schema.names
    for one, field in zip(columns, schema, strict=True):
        said = {key.decode(): value.decode() for key, value in field.metadata.items()}
        assert said == {key: value for key, value in one.items() if key != "name"}
        assert one["meaning"]
    by_name = {one["name"]: one for one in columns}
    assert by_name["imu_sigma_z_rad"]["unit"] == "rad"
    assert by_name["imu_q_w"]["unit"] == "1"
    assert "z up" in by_name["imu_q_w"]["frame"]


def test_how_it_was_made_is_beside_it_and_nothing_that_does_not_apply(results):
    setup = json.loads((results / "setup.json").read_text())
    content = (results / "box.csv").read_bytes()
    assert setup["software"] == {"name": "telemotion", "version": service_version()}
    assert setup["input"] == {
        "name": "box.csv",
        "bytes": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
        "format": "csv",
    }
    assert not {"body", "feet_apart_m", "constrain_joint_headings", "devices"} & set(setup)
    about = json.loads(pyarrow.parquet.read_schema(results / "frames.parquet").metadata[b"telemotion"])
    assert about["setup"]["orientation"] == setup["orientation"]


def test_every_flag_and_angle_has_words():
    assert set(FLAGS) == {flag for flag in OrientationFlag if flag}
    layout = pipelines.create(
        SessionSetup("arm", ("sternum", "upper_arm_right", "forearm_right"), 100.0)
    ).layout
    counts = {"segments": len(layout.segments), "points": len(layout.points), "angles": len(layout.angles)}
    frames = Frames(
        layout,
        0,
        0.01,
        np.ones((2, counts["segments"], 4)),
        np.ones((2, counts["points"], 3)),
        np.ones((2, counts["angles"])),
        np.ones((2, counts["angles"])),
        np.ones((2, len(layout.scalars))),
        np.zeros((2, counts["segments"]), np.uint8),
        np.zeros((2, counts["angles"]), np.uint8),
    )
    columns = {one["name"]: one for one in dictionary(frames_table(frames, pipeline="arm"))}
    elevation = columns["thorax_humerus_right_yxy_elevation_rad"]
    assert (elevation["unit"], elevation["sequence"]) == ("rad", "yxy")
    assert elevation["meaning"] == "elevation of thorax to humerus on the right"
    for name in layout.angles:
        assert columns[f"{name}_rad"]["meaning"]
        assert columns[f"{name}_flags"]["unit"] == "1"


def test_a_turned_sensor_has_a_flag_of_its_own_in_files_and_blocks():
    layout = FrameLayout(("forearm_right",), ("wrist_right",), ("elbow_flexion", "elbow_pronation"))
    slipped = np.array([[False, False, False, False], [True, False, True, False]])
    frames = Frames(
        layout,
        0,
        0.01,
        np.ones((2, 1, 4)),
        np.ones((2, 1, 3)),
        np.ones((2, 2)),
        np.ones((2, 2)),
        np.ones((2, 0)),
        np.full((2, 1), 4, np.uint8),
        np.full((2, 2), 36, np.uint8),
        slipped=slipped,
    )
    table = frames_table(frames)
    assert table["forearm_right_flags"].to_pylist() == [4, 260]
    assert table["elbow_flexion_flags"].to_pylist() == [36, 36]
    assert table["elbow_pronation_flags"].to_pylist() == [36, 292]
    assert "256: the sensor has turned" in str(table.schema.field("elbow_flexion_flags").metadata)
    rows = np.frombuffer(encode_block(frames), "<f4", offset=40).reshape(2, -1)
    assert rows[:, -3:].tolist() == [[4, 36, 36], [260, 36, 292]]
    sound = frames_table(replace(frames, slipped=None))
    assert sound["elbow_pronation_flags"].to_pylist() == [36, 36]
