"""Tables with one value a row are read as the same table with a column for each signal."""

import numpy as np
import pytest

from app import readers
from app.errors import RecordingFormatError
from app.readers.tables.schemas import CsvMapping
from tests.app.readers.odd_tables import FIELD_UT, FORCE, GYROSCOPE, TIME_S, numbers
from tests.said import codes, sentence

N = 600
VALUES = numbers(np.column_stack([GYROSCOPE, FORCE, FIELD_UT]))[:N]
STAMPS = [f"{stamp:.2f}" for stamp in TIME_S[:N]]
SIGNALS = [f"{quantity}_{axis}" for quantity in ("gyr", "acc", "mag") for axis in "xyz"]


def rows_of(values=VALUES, stamps=STAMPS, signals=SIGNALS):
    """Return the rows of a sensor: time, name of the signal, value."""
    return [
        [stamp, name, one]
        for stamp, row in zip(stamps, values, strict=True)
        for name, one in zip(signals, row, strict=False)
    ]


def written(folder, head, rows, delimiter=","):
    path = folder / "table.csv"
    path.write_text("\n".join(delimiter.join(row) for row in [head.split(","), *rows]) + "\n")
    return path


def guess_of(path, rate_hz=None):
    start, later = readers.start_of(path), readers.later_of(path)
    return readers.preview_text(path.name, start, None, rate_hz, later).guess


def read(path, rate_hz=None):
    """Return the recording of a table by its guess, and the codes of what was said."""
    guess = guess_of(path, rate_hz)
    assert codes(guess.missing) == []
    found = readers.read(path, "csv", CsvMapping.model_validate(guess.mapping))
    return found, [*codes(guess.notes), *codes(found.notes)]


def is_as_measured(signals, rows=slice(0, N)):
    np.testing.assert_allclose(signals.gyroscope_radps, GYROSCOPE[rows], rtol=2e-6, atol=2e-6)
    np.testing.assert_allclose(signals.accelerometer_mps2, FORCE[rows], rtol=2e-6, atol=2e-6)
    if signals.magnetometer_t is not None:
        np.testing.assert_allclose(1e6 * signals.magnetometer_t, FIELD_UT[rows], rtol=2e-6, atol=1e-4)


def test_example(tmp_path):
    found, said = read(written(tmp_path, "time,channel,value", rows_of()))
    (signals,) = found.sensors.values()
    is_as_measured(signals)
    np.testing.assert_allclose(signals.time_s, TIME_S[:N], atol=1e-9)
    assert signals.magnetometer_t is not None
    assert "guess.tall" in said


@pytest.mark.parametrize("delimiter", [";", "\t", "|", " "])
def test_delimiters(tmp_path, delimiter):
    found, _ = read(written(tmp_path, "time,channel,value", rows_of(), delimiter))
    is_as_measured(found.sensors["imu"])


def test_device_quantity_axis_and_unit_in_columns_of_their_own(tmp_path):
    units = {"gyr": "deg/s", "acc": "g", "mag": "µT"}
    scaled = np.column_stack([np.degrees(GYROSCOPE), FORCE / 9.80665, FIELD_UT])[:N]
    rows = [
        [stamp, device, quantity, axis, units[quantity], one]
        for k, stamp in enumerate(STAMPS)
        for device, values in (("left_wrist", scaled), ("chest", scaled[::-1]))
        for name, one in zip(SIGNALS, numbers(values[k : k + 1], 9)[0], strict=True)
        for quantity, axis in [name.split("_")]
    ]
    found, _ = read(written(tmp_path, "time,device,quantity,axis,unit,value", rows))
    assert set(found.sensors) == {"forearm_left", "sternum"}
    is_as_measured(found.sensors["forearm_left"])
    is_as_measured(found.sensors["sternum"], slice(N - 1, None, -1))


def test_devices_that_a_column_of_any_name_tells_apart(tmp_path):
    """Without it the values of one would be read as those of the other."""
    rows = [
        [one[0], who, *one[1:]]
        for two in zip(rows_of(), rows_of(VALUES[::-1]), strict=True)
        for who, one in zip(("p", "q"), two, strict=True)
    ]
    found, _ = read(written(tmp_path, "time,who,channel,value", rows))
    assert set(found.sensors) == {"p", "q"}
    is_as_measured(found.sensors["p"])
    is_as_measured(found.sensors["q"], slice(N - 1, None, -1))


def test_a_phase_of_an_exercise_makes_no_signals(tmp_path):
    rows = [[*one, ("rest", "reach", "back")[at // 900 % 3]] for at, one in enumerate(rows_of())]
    found, _ = read(written(tmp_path, "time,channel,value,phase", rows))
    is_as_measured(found.sensors["imu"])


def test_signals_one_below_the_other(tmp_path):
    """As tables are melted."""
    count = 300
    rows = sorted(rows_of(VALUES[:count], STAMPS[:count]), key=lambda one: SIGNALS.index(one[1]))
    found, _ = read(written(tmp_path, "time,variable,value", rows))
    is_as_measured(found.sensors["imu"], slice(0, count))


def test_too_long_to_stand_one_below_the_other_until_it_is_sorted_as_advised(tmp_path):
    stamps = [f"{k / 100:.2f}" for k in range(15_000)]
    values = (VALUES * 25)[:15_000]
    rows = sorted(rows_of(values, stamps, SIGNALS[:6]), key=lambda one: SIGNALS.index(one[1]))
    missing = guess_of(written(tmp_path, "time,variable,value", rows)).missing
    said = sentence(missing, "guess.tall_unsorted")
    assert said.parameters["column"] == "time"
    assert "gyr_x" in said.parameters["values"]
    rows.sort(key=lambda one: float(one[0]))
    found, _ = read(written(tmp_path, "time,variable,value", rows))
    assert len(found.sensors["imu"].time_s) == 15_000
    is_as_measured(_first(found.sensors["imu"], N))


def _first(signals, count):
    from dataclasses import replace

    return replace(
        signals,
        time_s=signals.time_s[:count],
        gyroscope_radps=signals.gyroscope_radps[:count],
        accelerometer_mps2=signals.accelerometer_mps2[:count],
    )


def test_each_value_with_a_stamp_of_its_own(tmp_path):
    """As a host writes them when they arrive: those of a sample follow each other in one order."""
    rows = [
        [f"{float(stamp) + 1e-4 * SIGNALS.index(name):.5f}", name, value] for stamp, name, value in rows_of()
    ]
    # Lost values shift nothing.
    lost = [rows[k] for k in range(len(rows)) if k not in (90, 91, 92, 400, 1004)]
    found, _ = read(written(tmp_path, "time,channel,value", lost))
    signals = found.sensors["imu"]
    np.testing.assert_allclose(signals.time_s, TIME_S[:N], atol=2e-3)
    there = np.isfinite(signals.gyroscope_radps).all(axis=1)
    assert (~there).sum() <= 3
    np.testing.assert_allclose(signals.gyroscope_radps[there], GYROSCOPE[:N][there], atol=2e-5)


def test_whole_seconds_and_counters(tmp_path):
    stamps = [f"2026-11-22 10:00:{int(stamp):02d}" for stamp in TIME_S[:N]]
    found, _ = read(written(tmp_path, "time,channel,value", rows_of(VALUES, stamps)))
    is_as_measured(found.sensors["imu"])
    counts = [str((65_300 + k) % 65_536) for k in range(N)]
    found, said = read(written(tmp_path, "counter,channel,value", rows_of(VALUES, counts)), 100.0)
    is_as_measured(found.sensors["imu"])
    assert "guess.counter" in said


def test_quantities_of_rates_of_their_own(tmp_path):
    slow = [f"{k / 50 + 0.004:.3f}" for k in range(N // 2)]
    rows = rows_of([row[:3] for row in VALUES], STAMPS, SIGNALS[:3])
    rows += rows_of([row[3:6] for row in VALUES[::2]], slow, SIGNALS[3:6])
    rows.sort(key=lambda one: float(one[0]))
    found, said = read(written(tmp_path, "time,channel,value", rows))
    signals = found.sensors["imu"]
    np.testing.assert_allclose(signals.gyroscope_radps, GYROSCOPE[:N], rtol=2e-6, atol=2e-6)
    assert np.isfinite(signals.accelerometer_mps2[2:-2]).all()
    assert "table.joined" in said


def test_what_is_no_number_is_refused_with_its_line(tmp_path):
    rows = rows_of()
    rows[700][2] = "lost"
    path = written(tmp_path, "time,channel,value", rows)
    mapping = CsvMapping.model_validate(guess_of(path).mapping)
    with pytest.raises(RecordingFormatError) as refused:
        readers.read(path, "csv", mapping)
    assert refused.value.details == {"column": "value", "line": 702}


def test_rows_of_no_signal_are_said(tmp_path):
    stamps = [f"{k / 100:.2f}" for k in range(3000)]
    rows = rows_of((VALUES * 5)[:3000], stamps)
    rows[4100][1] = ""
    # Behind the first 256 KiB.
    rows += [["30.00", "spo2", "98"], ["30.01", "spo2", "97"]]
    found, _ = read(written(tmp_path, "time,channel,value", rows))
    assert sentence(found.notes, "table.rows_of_no_signal").parameters == {
        "count": 2,
        "column": "channel",
        "values": ["spo2"],
    }
    assert sentence(found.notes, "table.rows_of_nobody").parameters["count"] == 1


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("time,channel,value", lambda k: [f"{k / 100}", ("temperature", "battery")[k % 2], str(20 + k % 2)]),
        ("time,gyr_x,value", lambda k: [f"{k / 100}", str(k % 7), str(k % 5)]),
    ],
)
def test_other_tables_are_not_taken_for_one(tmp_path, head, row):
    guess = guess_of(written(tmp_path, head, [row(k) for k in range(200)]))
    assert "guess.tall" not in codes(guess.notes)


def test_a_table_without_all_axes_says_what_it_holds(tmp_path):
    path = written(tmp_path, "time,channel,value", rows_of(VALUES, STAMPS, SIGNALS[:4]))
    (said,) = [one for one in guess_of(path).missing if one.code.startswith("guess.tall")]
    assert said.parameters["values"] == ["gyr_x", "gyr_y", "gyr_z", "acc_x"]


def lossy(share, seed=1):
    """Return rows of which each value may be lost by itself."""
    rng = np.random.default_rng(seed)
    return [row for row in rows_of() if rng.random() >= share]


@pytest.mark.parametrize("share", [0.02, 0.1])
def test_a_lost_value_moves_no_other_to_another_sample(tmp_path, share):
    found, _ = read(written(tmp_path, "time,channel,value", lossy(share)))
    signals = found.sensors["imu"]
    place = np.round(100.0 * signals.time_s).astype(int) + int(np.round(100.0 * (TIME_S[0])))
    for values, true in ((signals.gyroscope_radps, GYROSCOPE), (signals.accelerometer_mps2, FORCE)):
        there = np.isfinite(values)
        assert there.mean() > 0.9 - share
        np.testing.assert_allclose(values[there], true[place][there], atol=2e-5)


@pytest.mark.parametrize("is_apart", [False, True])
def test_first_values_with_the_stamp_of_the_one_before_are_of_their_own_sample(tmp_path, is_apart):
    """Of some samples, two of them in a row, as a driver writes them that stamps on arrival."""
    late = {40, 41, 90, 160, 300, 301, 420}
    rows = []
    for k, one in enumerate(rows_of(VALUES, STAMPS, SIGNALS[:6])):
        sample, at = divmod(k, 6)
        stamp = f"{TIME_S[sample] + (0.004 if is_apart and at > 2 else 0.0):.3f}"
        is_late = sample in late and at == (3 if is_apart else 0)
        rows.append([rows[-1][0] if is_late else stamp, *one[1:]])
    found, _ = read(written(tmp_path, "time,channel,value", rows))
    signals = found.sensors["imu"]
    np.testing.assert_allclose(signals.gyroscope_radps, GYROSCOPE[:N], rtol=2e-6, atol=2e-6)
    if not is_apart:
        is_as_measured(signals)
        return
    assert np.isfinite(signals.accelerometer_mps2[1:]).all()
    between = 0.4 * FORCE[: N - 1] + 0.6 * FORCE[1:N]
    np.testing.assert_allclose(signals.accelerometer_mps2[1:], between, atol=1e-4)


def labelled(rows, *labels):
    """Return the rows of a table with a label behind the time."""
    return [[one[0], label, *one[1:]] for one, label in zip(rows, labels, strict=True)]


@pytest.mark.parametrize("apart_s", [0.0, 0.005])
@pytest.mark.parametrize("column", ["side", "hand"])
def test_sides_that_hold_every_name_are_two_sensors(tmp_path, column, apart_s):
    both = [
        [f"{float(one[0]) + shift_s:.3f}", label, *one[1:]]
        for values, label, shift_s in ((VALUES, "left", 0.0), (VALUES[::-1], "right", apart_s))
        for one in rows_of(values, signals=SIGNALS[:6])
    ]
    both.sort(key=lambda one: float(one[0]))
    found, _ = read(written(tmp_path, f"time,{column},channel,value", both))
    assert set(found.sensors) == {"left", "right"}
    if not apart_s:
        is_as_measured(found.sensors["left"])
        is_as_measured(found.sensors["right"], slice(N - 1, None, -1))


@pytest.mark.parametrize("column", ["side", "hand", "position"])
def test_a_side_that_says_what_was_moved_splits_no_sensor(tmp_path, column):
    rows = rows_of()
    rows = labelled(rows, *(("left", "right")[k // 1350 % 2] for k in range(len(rows))))
    found, _ = read(written(tmp_path, f"time,{column},channel,value", rows))
    (signals,) = found.sensors.values()
    is_as_measured(signals)


def test_a_label_that_says_what_the_name_says_splits_no_sensor(tmp_path):
    rows = rows_of()
    rows = labelled(rows, *({"g": "IMU 1", "a": "IMU 1", "m": "compass"}[one[1][0]] for one in rows))
    found, _ = read(written(tmp_path, "time,sensor,channel,value", rows))
    (signals,) = found.sensors.values()
    is_as_measured(signals)


@pytest.mark.parametrize(
    "head", ["time,channel,value", "time,device,channel,value", "time,who,channel,value"]
)
def test_a_device_that_begins_later_is_a_sensor(tmp_path, head):
    """Behind the first 256 KiB; its own signals, or the same under another label."""
    stamps = [f"{k / 100:.2f}" for k in range(4200)]
    rows = []
    for device, values, begins in (("left", VALUES, 0), ("right", VALUES[::-1], 2900)):
        mine = rows_of((values * 7)[begins:4200], stamps[begins:], SIGNALS[:6])
        if head.split(",")[1] == "channel":
            rows += [[stamp, f"{device}_{name}", value] for stamp, name, value in mine]
        else:
            rows += labelled(mine, *[device] * len(mine))
    rows.sort(key=lambda one: float(one[0]))
    path = written(tmp_path, head, rows)
    found, said = read(path)
    assert set(found.sensors) == {"left", "right"}
    there = np.isfinite(found.sensors["right"].gyroscope_radps).all(axis=1)
    assert there.sum() == 1300
    np.testing.assert_allclose(
        found.sensors["right"].gyroscope_radps[2900:3000], GYROSCOPE[N - 1 :: -1][500:600], atol=1e-5
    )
    assert "table.rows_of_no_signal" not in said
