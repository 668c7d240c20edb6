"""A device that is switched on behind the beginning of a table is a sensor as well."""

import numpy as np
import pytest

from app import readers
from app.errors import RecordingFormatError
from app.readers.tables.schemas import CsvMapping
from tests.app.readers.odd_tables import FORCE, GYROSCOPE, NINE, numbers
from tests.said import codes

N = len(GYROSCOPE)
VALUES = numbers(np.column_stack([GYROSCOPE, FORCE]))
LONG = 6000


def guess_of(path):
    return readers.preview_text(path.name, readers.start_of(path), None, None, readers.later_of(path)).guess


def rows_of(device, begins, ends=LONG, later_s=0.0):
    return [
        [f"{k / 100 + later_s:.3f}", device, *VALUES[(k + 7 * len(device)) % N]] for k in range(begins, ends)
    ]


def written(folder, rows, encoding="utf-8"):
    path = folder / "table.csv"
    head = ["time", "DeviceName", *NINE[:6]]
    path.write_text("\n".join(",".join(row) for row in [head, *rows]) + "\n", encoding)
    return path


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-le"])
@pytest.mark.parametrize("begins", [3500, 5700])
def test_rows_of_a_device_that_begins_later(tmp_path, begins, encoding):
    rows = sorted([*rows_of("one", 0), *rows_of("second", begins)], key=lambda row: float(row[0]))
    path = written(tmp_path, rows, encoding)
    guess = guess_of(path)
    assert codes(guess.missing) == []
    found = readers.read(path, "csv", CsvMapping.model_validate(guess.mapping))
    assert set(found.sensors) == {"one", "second"}
    there = np.isfinite(found.sensors["second"].gyroscope_radps).all(axis=1)
    assert there.sum() in (LONG - begins, LONG - begins + 1)
    assert np.isfinite(found.sensors["one"].gyroscope_radps).all()


def test_a_file_that_ends_early_has_no_rest(tmp_path):
    path = written(tmp_path, rows_of("one", 0, 100))
    assert readers.later_of(path) == ()
    assert len(readers.later_of(written(tmp_path, rows_of("one", 0, 4200)))) in (1, 2, 3)


def test_pieces_are_whole_lines_up_to_the_end(tmp_path):
    path = written(tmp_path, rows_of("one", 0, 20_000))
    pieces = readers.later_of(path)
    assert len(pieces) == 12
    assert pieces[-1].endswith(path.read_bytes()[-100:])


def read(path):
    return readers.read(path, "csv", CsvMapping.model_validate(guess_of(path).mapping))


@pytest.mark.parametrize("column", ["DeviceName", "location", "side"])
@pytest.mark.parametrize("head", ["wide", "tall"])
def test_one_device_below_the_other_begins_with_it(tmp_path, head, column):
    names = ("one", "second") if column == "DeviceName" else ("left_wrist", "right_wrist")
    rows = [*rows_of(names[0], 0, 6000), *rows_of(names[1], 0, 6000)]
    if head == "tall":
        rows = [[*row[:2], name, one] for row in rows for name, one in zip(NINE[:6], row[2:], strict=True)]
    path = written(tmp_path, rows)
    if head == "tall":
        path.write_text(f"time,{column},channel,value\n" + path.read_text().split("\n", 1)[1])
    path.write_text(path.read_text().replace("DeviceName", column, 1))
    found = read(path)
    assert codes(found.notes) == []
    for name, signals in found.sensors.items():
        written_name = {"forearm_left": names[0], "forearm_right": names[1]}.get(name, name)
        at = (np.arange(6000) + 7 * len(written_name)) % N
        np.testing.assert_allclose(signals.time_s, np.arange(6000) / 100, atol=1e-9)
        np.testing.assert_allclose(signals.gyroscope_radps, GYROSCOPE[at], atol=1e-5)
    assert len(found.sensors) == 2


@pytest.mark.parametrize(
    ("column", "mark"),
    [
        ("sensor", lambda k: int(100 < k % 1000 < 140)),
        ("imu", lambda k: f"{24 + k // 1200 / 10:.1f}"),
        ("Sensor Nr", lambda k: 1 + k // 50 % 3),
        ("serial", lambda k: k // 500),
        ("sensor id", lambda k: "1" if k < 2000 else "01"),
    ],
)
def test_a_column_of_numbers_called_as_devices_are_splits_no_sensor(tmp_path, column, mark):
    rows = [[row[0], str(mark(k)), *row[2:]] for k, row in enumerate(rows_of("one", 0, 6000))]
    path = written(tmp_path, rows)
    path.write_text(path.read_text().replace("DeviceName", column, 1))
    (signals,) = read(path).sensors.values()
    np.testing.assert_allclose(signals.gyroscope_radps, GYROSCOPE[(np.arange(6000) + 21) % N], atol=1e-5)


def test_a_button_between_what_was_looked_at_leaves_no_hole(tmp_path):
    rows = [
        [row[0], str(int(15_000 <= k < 15_040)), *row[2:]] for k, row in enumerate(rows_of("one", 0, 40_000))
    ]
    path = written(tmp_path, rows)
    path.write_text(path.read_text().replace("DeviceName", "sensor", 1))
    (signals,) = read(path).sensors.values()
    assert signals.time_s.size == 40_000


def test_eighteen_devices_of_one_value_a_row_are_eighteen(tmp_path):
    rows = [
        [row[0], row[1], name, one]
        for rows in zip(*(rows_of(f"d{k:02d}", 0, 400) for k in range(18)), strict=True)
        for row in rows
        for name, one in zip(NINE[:6], row[2:], strict=True)
    ]
    path = written(tmp_path, rows)
    path.write_text("time,device,channel,value\n" + path.read_text().split("\n", 1)[1])
    assert len(read(path).sensors) == 18


def test_a_false_reading_in_a_piece_does_not_change_the_unit_of_all(tmp_path):
    generator = np.random.default_rng(1)
    rows = []
    for k in range(1500):
        for device in range(16):
            rate = 0.01 * generator.normal(size=3)
            rate[0] = 80.0 if (k, device) == (1490, 0) else rate[0]
            force = [0.0, 0.0, 9.81] + 0.02 * generator.normal(size=3)
            rows.append([f"{k / 100:.2f}", f"d{device}", *(f"{one:.5f}" for one in (*rate, *force))])
    mapping = guess_of(written(tmp_path, rows)).mapping
    assert {one["unit"] for one in mapping["signals"] if one["quantity"] == "gyroscope"} == {"rad/s"}


def test_devices_that_were_never_on_at_once_are_not_taken_for_one(tmp_path):
    # Whoever changes one for the other takes longer than from one sample to the next.
    path = written(tmp_path, [*rows_of("one", 0, 3000), *rows_of("second", 3000, 6000, later_s=2.0)])
    with pytest.raises(RecordingFormatError) as refused:
        read(path)
    assert refused.value.message.code == "table.clocks_apart"


def test_rows_of_a_device_between_what_was_looked_at_are_none_of_the_other(tmp_path):
    rows = rows_of("one", 0, 40_000)
    rows[15_000:15_000] = rows_of("second", 15_000, 15_040)
    found = read(written(tmp_path, rows))
    (signals,) = found.sensors.values()
    np.testing.assert_allclose(signals.gyroscope_radps, GYROSCOPE[(np.arange(40_000) + 21) % N], atol=1e-5)
    (said,) = [one for one in found.notes if one.code == "table.rows_of_none"]
    assert (said.parameters["count"], said.parameters["values"]) == (40, ["second"])


def test_a_button_of_a_device_names_no_device(tmp_path):
    rows = [[row[0], str(int(k > 3000)), *row[2:]] for k, row in enumerate(rows_of("one", 0, 6000))]
    path = written(tmp_path, rows)
    path.write_text(path.read_text().replace("DeviceName", "imu3 button"))
    (signals,) = read(path).sensors.values()
    np.testing.assert_allclose(signals.gyroscope_radps, GYROSCOPE[(np.arange(6000) + 21) % N], atol=1e-5)


def test_what_a_mapping_of_the_beginning_alone_leaves_out_is_said(tmp_path):
    rows = [
        [row[0], row[1], name, one]
        for row in sorted([*rows_of("left_wrist", 0, 6000), *rows_of("right_wrist", 4000, 6000)])
        for name, one in zip(NINE[:6], row[2:], strict=True)
    ]
    path = written(tmp_path, rows)
    path.write_text("time,location,channel,value\n" + path.read_text().split("\n", 1)[1])
    start = path.read_bytes()[: readers.HEAD_BYTES]
    mapping = readers.preview_text(path.name, start).guess.mapping
    found = readers.read(path, "csv", CsvMapping.model_validate(mapping))
    assert list(found.sensors) == ["forearm_left"]
    (said,) = [one for one in found.notes if one.code == "table.rows_of_no_signal"]
    assert said.parameters["count"] == 12_000
