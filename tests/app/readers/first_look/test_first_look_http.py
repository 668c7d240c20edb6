"""The upload page, the interface and the command say the same of a table before it is read."""

from base64 import b64encode

import numpy as np
from typer.testing import CliRunner

from app.cli import cli
from app.settings import Settings
from tests.app.readers.odd_fields import field_tables
from tests.app.readers.odd_tables import odd_tables

ODD = odd_tables() | field_tables()


def previewed(client, content, **asked):
    answer = client.post(
        "/api/uploads/preview",
        json={"file_name": "a.csv", "beginning": b64encode(content).decode(), **asked},
    )
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_the_command_prints_the_sentences_of_the_interface(therapist, tmp_path):
    for name in ("german", "rows of two devices"):
        content = ODD[name].content[: 256 * 1024]
        found = previewed(therapist, content, hemisphere="north")
        sentences = [one["sentence"] for one in found["sensors"]]
        assert sentences
        (tmp_path / "a.csv").write_bytes(content)
        done = CliRunner().invoke(
            cli,
            [
                "process",
                str(tmp_path / "a.csv"),
                "--guess",
                "--orientation",
                "nobody",
                "--out",
                str(tmp_path / "out"),
            ],
        )
        lines = done.stderr.splitlines()
        assert lines[: len(sentences)] == sentences
        assert lines[len(sentences) :][: len(found["notes"])] == [f"note: {one}" for one in found["notes"]]


def test_the_first_seconds_come_as_curves_and_follow_a_change(therapist):
    content = ODD["german"].content[: 256 * 1024]
    found = previewed(therapist, content)
    (sensor,) = found["sensors"]
    assert sensor["sentences"]["sentence"]["code"].startswith("guess.sensor_")
    assert 9.9 < sensor["time_s"][-1] <= 10.0
    curves = {
        name: np.array(sensor[name]) for name in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t")
    }
    assert {one.shape for one in curves.values()} == {(3, len(sensor["time_s"]))}
    changed = found["mapping"]
    force = next(one for one in changed["signals"] if one["quantity"] == "accelerometer")
    force["sign"] = -1
    again = previewed(therapist, content, mapping=changed)
    assert again["mapping"]["signals"] == changed["signals"]
    np.testing.assert_allclose(again["sensors"][0]["accelerometer_mps2"], -curves["accelerometer_mps2"])
    assert "guess.turned" in [one["code"] for one in again["sentences"]["notes"]]


def test_the_hemisphere_of_the_service_is_said(therapist, settings: Settings):
    content = ODD["german"].content[: 256 * 1024]
    assert settings.hemisphere == "north"
    said = [one["code"] for one in previewed(therapist, content)["sentences"]["notes"]]
    assert "guess.hemisphere_north" in said
    said = [one["code"] for one in previewed(therapist, content, hemisphere="south")["sentences"]["notes"]]
    assert "guess.hemisphere_south" in said


def test_a_device_that_begins_later_is_shown(therapist):
    """By pieces of the rest of the file, as many and as large as the page sends."""
    line = "{:.2f},{},0.1,0.2,0.{},0.1,0.2,9.{}"
    rows = [
        line.format(k / 100, name, k % 7, k % 5 + 6)
        for k in range(16_000)
        for name in ("one", "two")
        if name == "one" or k > 9000
    ]
    content = "\n".join(["time,DeviceName,gx,gy,gz,ax,ay,az", *rows, ""]).encode()
    later = [b64encode(content[at : at + 32 * 1024]).decode() for at in range(300_000, len(content), 55_000)]
    alone = previewed(therapist, content[: 256 * 1024])
    found = previewed(therapist, content[: 256 * 1024], later=later[:12])
    assert [one["where"] for one in alone["sensors"]] == ["imu"]
    assert [one["where"] for one in found["sensors"]] == ["one", "two"]
    assert found["missing"] == []
