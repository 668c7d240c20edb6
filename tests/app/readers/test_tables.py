"""Tables of other devices: preambles, header lines, delimiters and names."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from app import readers
from app.cli import cli
from app.errors import InvalidInput, RecordingFormatError
from app.readers.tables.body import read_columns, read_table
from app.readers.tables.guess import guess_of_head
from app.readers.tables.head import head_of_file, read_head
from app.readers.tables.schemas import CsvMapping
from tests.said import codes

DATA = Path(__file__).parents[2] / "data" / "tables"
EXPECTED = json.loads((DATA / "expected.json").read_text())


@pytest.mark.parametrize("name", EXPECTED)
def test_a_table_is_found_and_its_mapping_guessed(name):
    head, expected = head_of_file(DATA / name), EXPECTED[name]
    assert list(head.columns) == expected["columns"]
    assert len(set(head.columns)) == len(head.columns)
    assert head.skipped_lines == expected["skipped_lines"]
    assert list(head.rows[0]) == expected["first_row"]
    guess = guess_of_head(head, Path(name).stem)
    assert (guess.mapping, guess.pipeline) == (expected["mapping"], expected["pipeline"])
    assert codes(guess.missing) == expected["missing"]


@pytest.mark.parametrize("name", EXPECTED)
def test_the_whole_table_is_read_from_its_first_row(name):
    head = head_of_file(DATA / name)
    numeric = [c for c, value in zip(head.columns, head.rows[0], strict=True) if value not in ("", "NaN")]
    table, notes = read_table(DATA / name, numeric, head)
    assert notes == ()
    for column in numeric:
        first = head.rows[0][head.columns.index(column)].replace(",", ".")
        assert table[column][0] == pytest.approx(float(first))
    lines = [line for line in (DATA / name).read_text().split("\n")[head.skipped_lines :] if line.strip()]
    assert all(len(values) == len(lines) for values in table.values())


def worn(name: str, placements: list[str]) -> CsvMapping:
    """The guess, with the placements that the file does not tell."""
    mapping = guess_of_head(head_of_file(DATA / name)).mapping
    sensors = list(dict.fromkeys(signal["sensor"] for signal in mapping["signals"]))
    for signal in mapping["signals"]:
        signal["placement"] = placements[sensors.index(signal["sensor"]) % len(placements)]
    return CsvMapping.model_validate(mapping)


def test_an_opensense_table_is_a_recording():
    placements = ["pelvis", "upper_arm_right", "forearm_right", "hand_right"]
    recording = readers.read(DATA / "opensense_imu.csv", "csv", worn("opensense_imu.csv", placements))
    assert set(recording.placements) == set(placements)
    assert recording.nominal_rate_hz == 128.0
    static = recording.sensors["pelvis"]
    np.testing.assert_allclose(static.accelerometer_mps2[0], [0.102542184, 0.048829611, 9.804986382])
    np.testing.assert_allclose(static.magnetometer_t[0], [31.27780876e-6, 13.46964874e-6, -62.79244003e-6])


def test_a_refusal_names_the_columns():
    mapping = worn("gaitmap_two_headers.csv", ["foot_left", "foot_right"]).model_copy(
        update={"rate_hz": 204.8}
    )
    for signal in mapping.signals:
        if signal.quantity == "accelerometer":
            signal.unit = "g"
    with pytest.raises(
        RecordingFormatError, match=r"left_sensor acc_x, left_sensor acc_y and left_sensor acc_z"
    ):
        readers.read(DATA / "gaitmap_two_headers.csv", "csv", mapping)


def test_a_word_among_numbers_is_refused_by_the_name_of_its_column(tmp_path):
    path = tmp_path / "words.csv"
    path.write_text("made by: nobody\n\nt,unused,a\n0,x,1\n1,y,2\n2,z,none\n")
    with pytest.raises(RecordingFormatError, match=r"the column a is not a number"):
        read_columns(path, ["t", "a"], None)


def test_names_above_several_columns_and_repeated_names():
    head = read_head("one,,,two,,\nx,y,z,x,y,z\n1,2,3,4,5,6\n1,2,3,4,5,6\n")
    assert head.columns == ("one x", "one y", "one z", "two x", "two y", "two z")
    assert read_head("a,a,a (2),\n1,2,3,4\n").columns == ("a", "a (2)", "a (2) (2)", "column 4")


def processed(file: Path, out: Path, *more: str):
    return CliRunner().invoke(cli, ["process", str(file), "--out", str(out), *more])


def test_the_command_line_guesses_and_says_what_is_missing(tmp_path):
    refused = processed(DATA / "opensense_mt_comma.txt", tmp_path, "--guess")
    assert isinstance(refused.exception, InvalidInput)
    assert "--rate" in str(refused.exception)
    assert (
        json.loads((tmp_path / "mapping.json").read_text()) == EXPECTED["opensense_mt_comma.txt"]["mapping"]
    )
    refused = processed(
        DATA / "opensense_mt_comma.txt", tmp_path / "b", "--mapping", str(tmp_path / "mapping.json")
    )
    assert "neither a time column nor a rate" in str(refused.exception)
    refused = processed(
        DATA / "opensense_mt_comma.txt", tmp_path, "--guess", "--pipeline", "arm", "--rate", "40"
    )
    assert "Acc_X, Acc_Y, Acc_Z, Gyr_X, Gyr_Y and Gyr_Z" in str(refused.exception)
    refused = processed(DATA / "opensense_mt_orientation.txt", tmp_path, "--guess")
    assert "orientations" in str(refused.exception)


def test_a_guessed_recording_is_estimated(tmp_path):
    rows = [f"{0.01 * k:.2f};0,001;0;0,002;0,1;0,2;9,8" for k in range(400)]
    names = [
        "sternum gyr x",
        "sternum gyr y",
        "sternum gyr z",
        "sternum acc x",
        "sternum acc y",
        "sternum acc z",
    ]
    text = "\n".join([";".join(["Time", *names]), *(row.replace(".", ",") for row in rows)])
    (tmp_path / "still.csv").write_text("Device: none\n" + text + "\n")
    done = processed(
        tmp_path / "still.csv", tmp_path / "out", "--guess", "--force", "--pipeline", "orientation"
    )
    assert done.exit_code == 0, done.exception
    assert (tmp_path / "out" / "frames.parquet").exists()


def _with_field(folder, field):
    """Write a table of one sensor with a magnetometer, and return its path; `field`: what a row holds of that."""
    names = [f"{quantity}_{axis} [{unit}]" for quantity, unit in UNITS.items() for axis in "xyz"]
    rows = [
        [
            f"{k / 100}",
            *(f"{0.1 * np.sin(k / n)}" for n in (9, 10, 11)),
            "0",
            "0.1",
            f"{9.8 + k % 3}",
            *field(k),
        ]
        for k in range(400)
    ]
    path = folder / "field.csv"
    path.write_text("\n".join(",".join(row) for row in [["time", *names], *rows]) + "\n")
    return path


UNITS = {"gyr": "rad/s", "acc": "m/s^2", "mag": "uT"}


def test_a_magnetometer_without_numbers_on_an_axis_is_none_and_that_is_said(tmp_path):
    path = _with_field(tmp_path, lambda k: [f"{20 + k % 5}", "", ""])
    guess = guess_of_head(head_of_file(path))
    assert {one["quantity"] for one in guess.mapping["signals"]} == {"gyroscope", "accelerometer"}
    assert "guess.left_out" in codes(guess.notes)
    whole = guess_of_head(head_of_file(_with_field(tmp_path, lambda k: ["20", "1", f"-4{k % 5}"]))).mapping
    path = _with_field(tmp_path, lambda k: [f"{20 + k % 5}", "", ""])
    found = readers.read(path, "csv", CsvMapping.model_validate(whole))
    assert found.sensors["imu"].magnetometer_t is None
    (said,) = [one for one in found.notes if one.code == "table.no_field"]
    assert said.parameters["columns"] == ["mag_y [uT]", "mag_z [uT]"]


@pytest.mark.parametrize("lost", ["", "inf"])
def test_a_field_that_lacks_an_axis_is_stored_as_none(tmp_path, lost):
    path = _with_field(tmp_path, lambda k: ["20", "1", lost if k % 7 == 0 else f"-4{k % 5}"])
    mapping = CsvMapping.model_validate(guess_of_head(head_of_file(path)).mapping)
    stored = readers.packets_of(readers.read(path, "csv", mapping), any_name=True).as_stored()
    there = np.isfinite(stored.sensors["imu"].magnetometer_t)
    np.testing.assert_array_equal(there, np.repeat((np.arange(400) % 7 != 0)[:, None], 3, axis=1))


def test_a_gyroscope_that_rests_has_the_unit_of_the_others(tmp_path):
    """Its numbers are as small in degrees as in radians; before, radians were assumed beside degrees."""
    time_s = np.arange(600) / 100.0
    angle = 1.2 * np.sin(2.0 * np.pi * 0.5 * time_s)
    rate = np.degrees(np.gradient(angle, time_s))
    rest = [["0.03", f"0.0{k % 4}", "-0.01", "0.1", "0.2", f"9.8{k % 3}"] for k in range(600)]
    swing = [["0", f"{9.8 * np.sin(a):.4f}", f"{9.8 * np.cos(a):.4f}"] for a in angle]
    rows = [
        [f"{t:.2f}", f"{w:.3f}", "0.02", "0.01", *force, *still]
        for t, w, force, still in zip(time_s, rate, swing, rest, strict=True)
    ]
    names = [
        f"{name}_{quantity}_{a}" for name in ("one", "two") for quantity in ("gyr", "acc") for a in "xyz"
    ]
    path = tmp_path / "rests.csv"
    path.write_text("\n".join(",".join(row) for row in [["time", *names], *rows]) + "\n")
    guess = guess_of_head(head_of_file(path))
    units = {one["sensor"]: one["unit"] for one in guess.mapping["signals"] if one["quantity"] == "gyroscope"}
    assert units == {"one": "deg/s", "two": "deg/s"}
    assert "guess.unit_of_others" in codes(guess.notes)
