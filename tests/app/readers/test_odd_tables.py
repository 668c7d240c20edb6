"""Odd tables are read right in one command and without editing, or refused for the true reason."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from app import readers
from app.cli import cli
from app.errors import InvalidInput, RecordingFormatError
from app.readers.tables.schemas import CsvMapping, GuessedMapping
from tests.app.readers.odd_fields import field_tables
from tests.app.readers.odd_tables import (
    ALL,
    FIELD_UT,
    FORCE,
    GYROSCOPE,
    PLAIN,
    TIME_S,
    odd_tables,
    refused_tables,
    rows_of,
    text,
)
from tests.said import codes

ODD, REFUSED = odd_tables() | field_tables(), refused_tables()


def read(folder: Path, name: str):
    odd = ODD[name]
    path = folder / odd.name
    path.write_bytes(odd.content)
    options = dict(zip(odd.options[::2], odd.options[1::2], strict=True))
    rate = options.get("--rate")
    found = readers.preview_text(
        odd.name, odd.content[: readers.HEAD_BYTES], options.get("--pipeline"), rate and float(rate)
    )
    assert found.guess.missing == ()
    return found, readers.read(path, "csv", CsvMapping.model_validate(found.guess.mapping))


@pytest.mark.parametrize("name", ODD)
def test_an_odd_table_is_read_as_it_was_measured(tmp_path, name):
    odd = ODD[name]
    found, recording = read(tmp_path, name)
    assert found.pipeline == odd.pipeline
    assert set(recording.sensors) == set(odd.sensors)
    assert odd.notes <= {*codes(recording.notes), *codes(found.guess.notes)}
    assert recording.nominal_rate_hz == 100.0
    for sensor, rows in odd.sensors.items():
        signals = recording.sensors[sensor]
        wanted = (GYROSCOPE[rows], FORCE[rows])
        # What has no number stays a row without one; the estimators bridge it.
        finite = np.isfinite(signals.gyroscope_radps).all(axis=1)
        for values, expected in zip(
            (signals.gyroscope_radps, signals.accelerometer_mps2), wanted, strict=True
        ):
            np.testing.assert_allclose(values[finite], expected, rtol=2e-6, atol=2e-6)
        if odd.has_field:
            np.testing.assert_allclose(signals.magnetometer_t[finite], 1e-6 * FIELD_UT[rows], rtol=2e-6)
        else:
            assert signals.magnetometer_t is None
        index = rows if isinstance(rows, np.ndarray) else np.arange(len(TIME_S))[: len(wanted[0])]
        time_s = TIME_S[index] if odd.time_s is None else odd.time_s
        np.testing.assert_allclose(signals.time_s[finite], time_s - time_s[0], rtol=0, atol=odd.within_s)


@pytest.mark.parametrize("name", ODD)
def test_the_command_line_reads_it_in_one_command(tmp_path, monkeypatch, name):
    odd = ODD[name]
    (tmp_path / odd.name).write_bytes(odd.content)
    asked = []
    monkeypatch.setattr(readers, "read", lambda *words: asked.append(words) or _stop())
    done = CliRunner().invoke(
        cli, ["process", str(tmp_path / odd.name), "--guess", "--out", str(tmp_path / "out"), *odd.options]
    )
    assert isinstance(done.exception, _Stopped), done.output
    ((_, format, mapping),) = asked
    assert format == "csv"
    assert {one.placement or one.sensor for one in mapping.signals} == set(odd.sensors)
    assert CsvMapping.model_validate_json((tmp_path / "out" / "mapping.json").read_text()) == mapping


class _Stopped(Exception):
    pass


def _stop() -> None:
    raise _Stopped


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_refused_for_its_reason(tmp_path, name):
    content, code = REFUSED[name]
    path = tmp_path / "table.csv"
    path.write_bytes(content)
    assert code in codes(reason(path, content))


def reason(path, content):
    """What is said against a file: that something is missing, or a refusal."""
    try:
        found = readers.preview_text(path.name, content[: readers.HEAD_BYTES])
        if found.guess.missing:
            return found.guess.missing[0]
        readers.read(path, "csv", CsvMapping.model_validate(found.guess.mapping))
    except RecordingFormatError as error:
        return error.message
    return ""


def test_the_mapping_is_written_to_be_edited(tmp_path):
    odd = ODD["letters"]
    (tmp_path / "table.csv").write_bytes(odd.content)
    done = CliRunner().invoke(
        cli, ["mapping", str(tmp_path / "table.csv"), "--out", str(tmp_path / "m.json")]
    )
    assert done.exit_code == 0, done.output
    mapping = json.loads((tmp_path / "m.json").read_text())
    assert [signal["quantity"] for signal in mapping["signals"]] == [
        "accelerometer",
        "gyroscope",
        "magnetometer",
    ]
    shown = CliRunner().invoke(cli, ["mapping", str(tmp_path / "table.csv")])
    assert json.loads(shown.stdout) == mapping
    refused = CliRunner().invoke(cli, ["mapping", str(tmp_path / "m.json")])
    assert isinstance(refused.exception, InvalidInput)


@given(st.binary(max_size=3000), st.sampled_from(sorted(ODD)), st.integers(0, 5000))
@example(b"\t    ", "a group named once", 68)
@settings(max_examples=200, deadline=None)
def test_no_bytes_break_the_preview(noise, name, at):
    content = ODD[name].content[:20_000]
    damaged = content[:at] + noise + content[at + len(noise) :]
    try:
        found = readers.preview_text("table.csv", damaged)
    except RecordingFormatError:
        return
    if found.guess is not None:
        # What is missing a person has to say.
        (GuessedMapping if found.guess.missing else CsvMapping).model_validate(found.guess.mapping)


def test_a_number_beyond_all_units_is_none():
    """Its square would be no number, and numpy would say so."""
    rows = "\n".join(f"{n / 100},{'9' * 200},0.1,9.8,0.1,0.2,0.3" for n in range(50))
    found = readers.preview_text("table.csv", f"time_s,ax,ay,az,gx,gy,gz\n{rows}\n".encode()).guess
    assert found is not None
    assert found.missing


def test_turned_signs_of_a_mapping_give_the_recording_back(tmp_path):
    """An accelerometer that gives gravity: all three axes, or one by one."""
    turned = text([PLAIN], rows_of(GYROSCOPE, -FORCE, FIELD_UT))
    path = tmp_path / "table.csv"
    path.write_text(turned)
    guess = readers.preview_text(path.name, path.read_bytes()).guess.mapping
    force = next(one for one in guess["signals"] if one["quantity"] == "accelerometer")
    for change in ({"sign": -1}, {"columns": [f"-{name}" for name in force["columns"]]}):
        signals = [{**one, **change} if one is force else one for one in guess["signals"]]
        found = readers.read(path, "csv", CsvMapping.model_validate({**guess, "signals": signals}))
        np.testing.assert_allclose(found.sensors["imu"].accelerometer_mps2, FORCE, rtol=2e-6, atol=2e-6)


def test_clocks_without_a_common_time_are_refused(tmp_path):
    odd = ODD["a clock for each sensor"]
    lines = odd.content.decode().split("\n")
    moved = [lines[0]]
    for line in filter(None, lines[1:]):
        fields = line.split(",")
        fields[7] = f"{float(fields[7]) + 5000.0:.14g}"
        moved.append(",".join(fields))
    path = tmp_path / "table.csv"
    path.write_text("\n".join(moved))
    guess = readers.preview_text(path.name, path.read_bytes()[: readers.HEAD_BYTES]).guess
    with pytest.raises(RecordingFormatError) as refused:
        readers.read(path, "csv", CsvMapping.model_validate(guess.mapping))
    assert codes(refused.value.message) == ["table.clocks_apart"]


@pytest.mark.parametrize("pause_s", [1200.0, 30.0 * 86_400.0])
def test_a_long_pause_is_said(tmp_path, pause_s):
    stamps = np.where(np.arange(len(TIME_S)) < 700, TIME_S, TIME_S + pause_s)
    path = tmp_path / "table.csv"
    path.write_text(text([PLAIN], rows_of(*ALL, time_s=stamps)))
    guess = readers.preview_text(path.name, path.read_bytes()[: readers.HEAD_BYTES]).guess
    found = readers.read(path, "csv", CsvMapping.model_validate(guess.mapping))
    assert "time.pauses" in codes(found.notes)
