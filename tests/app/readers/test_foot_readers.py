import csv

import numpy as np
import pytest

from app import readers
from app.errors import RecordingFormatError
from tests.app.readers.recording_files import FEET, G, gaitmap, gaitmap_rows, pyshoe, xio
from tests.said import codes


def test_a_pyshoe_walk(tmp_path):
    path = pyshoe(tmp_path / "walk.mat")
    assert readers.guess(path) == "pyshoe"
    found = readers.read(path)
    content = np.load(FEET / "pyshoe_walk.npz")
    sensor = found.sensors["foot_right"]
    assert sensor.time_s[0] == 0.0
    np.testing.assert_allclose(sensor.gyroscope_radps, content["gyroscope_radps"])
    np.testing.assert_allclose(sensor.accelerometer_mps2, content["accelerometer_mps2"])
    np.testing.assert_allclose(found.reference["position_xy_m"], content["position_xy_m"])
    assert found.nominal_rate_hz == 200.0
    assert float(found.metadata["gyroscope_clip_radps"]) < 9.1
    assert readers.read(pyshoe(tmp_path / "b.mat", gt=None)).reference == {}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"timestamps_all": np.arange(5.0) / 200.0}, "time stamps"),
        ({"imu_data": np.zeros((3310, 4))}, "shape"),
        ({"gt": np.zeros((7, 2))}, "differ in length"),
        ({"imu_data": None}, "no imu_data"),
        ({"imu_data": np.full((3310, 6), 980.0)}, "980 rad/s, faster than any sensor"),
    ],
)
def test_what_is_no_pyshoe_walk(tmp_path, changes, message):
    with pytest.raises(RecordingFormatError, match=message):
        readers.read(pyshoe(tmp_path / "a.mat", **changes), "pyshoe")


def test_an_xio_walk_keeps_its_stamps(tmp_path):
    def repeat(table):
        table[100:103, 0] = table[100, 0]
        # Written twice, as in its own files: no sample of its own.
        table[150] = table[149]

    path = xio(tmp_path / "short_walk.csv", repeat)
    assert readers.guess(path) == "gait_tracking"
    found = readers.read(path)
    sensor = found.sensors["foot_right"]
    steps = np.diff(sensor.time_s)
    # Their stamps are gone, and there is room for them.
    np.testing.assert_allclose(steps[99:103], np.median(steps), rtol=0.01)
    content = np.load(FEET / "xio_short_walk.npz")
    once = np.delete(np.arange(3000), 150)
    # A sample goes no farther than its neighbours let it, and comes no closer to them than half an interval.
    usual = np.median(steps)
    np.testing.assert_allclose(sensor.time_s, content["time_s"][once], atol=1.01 * usual)
    assert steps.min() > 0.49 * usual
    np.testing.assert_allclose(sensor.gyroscope_radps, content["gyroscope_radps"][once], atol=1e-6)
    assert codes(found.notes) == ["time.row_twice", "time.repeated"]
    np.testing.assert_allclose(np.median(np.linalg.norm(sensor.accelerometer_mps2, axis=1)), G, rtol=0.05)


def test_other_recordings_of_the_device_are_no_walks(tmp_path):
    names = (
        ["Time (s)"] + [f"Gyroscope {a} (deg/s)" for a in "XYZ"] + [f"Magnetometer {a} (uT)" for a in "XYZ"]
    )
    path = xio(tmp_path / "sensor.csv", header=names)
    assert readers.guess(path) == "csv"
    with pytest.raises(RecordingFormatError, match="no column"):
        readers.read(path, "gait_tracking")


def test_an_xio_walk_that_runs_backwards_or_has_holes(tmp_path):
    def late(table):
        table[50, 0] = 0.0

    said = codes(readers.read(xio(tmp_path / "late.csv", late)).notes)
    assert said == ["time.out_of_order", "time.repeated"], "its own samples often arrived together"

    def backwards(table):
        table[:, 0] = table[::-1, 0]

    with pytest.raises(RecordingFormatError, match="does not advance"):
        readers.read(xio(tmp_path / "a.csv", backwards))

    def hole(table):
        table[7, 4] = np.nan

    with pytest.raises(RecordingFormatError, match="Row 9 is not complete"):
        readers.read(xio(tmp_path / "b.csv", hole))


def test_both_feet_of_gaitmap_with_what_lies_beside(tmp_path):
    path = gaitmap(tmp_path / "set")
    assert readers.guess(path) == "gaitmap"
    found = readers.read(path)
    assert found.placements == ("foot_left", "foot_right")
    assert found.nominal_rate_hz == 204.8
    for side in ("left", "right"):
        rows = gaitmap_rows(side)
        sensor = found.sensors[f"foot_{side}"]
        np.testing.assert_allclose(sensor.accelerometer_mps2, rows[:, :3], atol=1e-5)
        np.testing.assert_allclose(sensor.gyroscope_radps, np.deg2rad(rows[:, 3:]), atol=1e-6)
        assert found.reference[f"strides_{side}"].shape == (1, 4)
    np.testing.assert_allclose(found.reference["heel_left_m"][0], [0.003, 0.004, 0.005])
    np.testing.assert_allclose(found.reference["toe_right_m"][0], [0.009, 0.010, 0.011])
    assert readers.read(gaitmap(tmp_path / "bare", truth=False)).reference == {}


def test_one_foot_of_gaitmap_by_its_name(tmp_path):
    def write(name):
        path = tmp_path / name
        with path.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["", "index", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"])
            writer.writerows([i, i + 23000, *row] for i, row in enumerate(gaitmap_rows("left", 500).tolist()))
        return path

    found = readers.read(write("imu_ms_left.csv"))
    assert found.placements == ("foot_left",)
    assert found.nominal_rate_hz == 102.4
    with pytest.raises(RecordingFormatError, match="left` or `right"):
        readers.read(write("imu.csv"), "gaitmap")
    assert readers.guess(tmp_path / "imu.csv") == "csv"


def test_what_is_no_gaitmap_file(tmp_path):
    for text, message in (
        ("a,b\n", "needs a header"),
        ("x,acc_x\n0,1\n1,hello\n", "not a number"),
        ("x,acc_x\n0,1\n1,2,3\n", "incomplete"),
        ("x,acc_x\n0,1\n1,2\n", "not a recording of the gaitmap"),
    ):
        path = tmp_path / "left.csv"
        path.write_text(text)
        with pytest.raises(RecordingFormatError, match=message):
            readers.read(path, "gaitmap")


def test_a_foot_in_radians_where_degrees_are_said_is_refused(tmp_path):
    def radians(table):
        table[:, 1:4] = np.deg2rad(table[:, 1:4])

    with pytest.raises(RecordingFormatError, match=r"shows steps.*look like rad/s"):
        readers.read(xio(tmp_path / "walk.csv", radians, count=None), "gait_tracking")

    def standing(table):
        radians(table)
        table[:, 4:] = table[0, 4:] / np.linalg.norm(table[0, 4:])

    assert readers.read(xio(tmp_path / "standing.csv", standing), "gait_tracking").sensors


def test_a_rate_that_the_file_does_not_tell_is_said(tmp_path):
    found = readers.read(gaitmap(tmp_path / "bare", truth=False))
    assert found.metadata["assumed_rate_hz"] == "204.8"
    assert "204.8 Hz assumed" in found.origin
