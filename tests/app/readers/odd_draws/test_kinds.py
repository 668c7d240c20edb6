"""Kinds of tables that the drawn ones found, each by itself: see `odd_draws`."""

import numpy as np
import pytest

from app import readers
from app.readers.tables.clocks.counter import gone_on, unwrapped
from app.readers.tables.clocks.mended import mended
from app.readers.tables.clocks.stamps import nominal_rate
from app.readers.tables.schemas import CsvMapping
from tests.app.readers.odd_tables import FIELD_UT, FORCE, GYROSCOPE, NINE, PLAIN, TIME_S, numbers, text
from tests.said import codes, sentence

SIX = np.column_stack([GYROSCOPE, FORCE])
ROWS = numbers(SIX)
STAMPS = [f"{stamp:.2f}" for stamp in TIME_S]
N = 600


def read(folder, head, rows, rate_hz=None):
    """Return the recording of a table by its guess, and the codes of what was said."""
    path = folder / "table.csv"
    path.write_text(text([head], rows))
    guess = readers.preview_text(path.name, path.read_bytes()[: readers.HEAD_BYTES], None, rate_hz).guess
    assert codes(guess.missing) == []
    found = readers.read(path, "csv", CsvMapping.model_validate(guess.mapping))
    return found, [*codes(guess.notes), *codes(found.notes)]


def in_turns(*parts):
    """Return rows of several devices: of each part one row, then of each the next."""
    return [row for rows in zip(*parts, strict=True) for row in rows]


def device(name, values, stamps=STAMPS):
    return [[stamp, name, *row] for stamp, row in zip(stamps[:N], values[:N], strict=True)]


def is_as_measured(signals, gyroscope):
    np.testing.assert_allclose(signals.gyroscope_radps, gyroscope, rtol=2e-6, atol=2e-6)


BOTH = in_turns(device("a", ROWS), device("b", ROWS[::-1]))
HEAD = ",".join(["time", "device", *NINE[:6]])


def test_rows_of_devices_and_of_kinds_at_once(tmp_path):
    rows = in_turns(
        *(
            [
                [stamp, name, kind, *(row[:3] if kind == "gyroscope" else row[3:])]
                for stamp, row in zip(STAMPS[:N], values, strict=False)
            ]
            for name, values in (("a", ROWS), ("b", ROWS[::-1]))
            for kind in ("gyroscope", "accelerometer")
        )
    )
    found, said = read(tmp_path, "time,device,sensor,x,y,z", rows)
    assert set(found.sensors) == {"a", "b"}
    is_as_measured(found.sensors["a"], GYROSCOPE[:N])
    is_as_measured(found.sensors["b"], GYROSCOPE[::-1][:N])
    assert "guess.devices" in said


def test_the_unit_of_rows_of_their_own_is_seen_by_the_turning(tmp_path):
    degrees = numbers(np.degrees(GYROSCOPE[:N] / 20.0))
    rows = in_turns(
        [[stamp, "gyroscope", *row] for stamp, row in zip(STAMPS, degrees, strict=False)],
        [[stamp, "accelerometer", *row[3:]] for stamp, row in zip(STAMPS, ROWS[:N], strict=False)],
    )
    _, said = read(tmp_path, "time,sensor,x,y,z", rows)
    # Twenty times too slow: no unit fits, and that is said; before, nothing was compared.
    assert "guess.unit_assumed" in said
    fast = numbers(np.degrees(GYROSCOPE[:N]))
    rows[::2] = [[stamp, "gyroscope", *row] for stamp, row in zip(STAMPS, fast, strict=False)]
    found, said = read(tmp_path, "time,sensor,x,y,z", rows)
    is_as_measured(found.sensors["imu"], GYROSCOPE[:N])
    assert "guess.unit_assumed" not in said


@pytest.mark.parametrize("odd", [HEAD.split(","), ["3.0", "x", *ROWS[0]]])
def test_a_row_that_is_of_no_device_makes_no_sensor_and_none_of_two_one(tmp_path, odd):
    found, _ = read(tmp_path, HEAD, [*BOTH[:500], odd, *BOTH[500:]])
    assert set(found.sensors) == {"a", "b"}


def test_rows_that_name_no_device_or_an_unknown_one_are_said(tmp_path):
    rows = [[row[0], "", *row[2:]] if k in (7, 30) else row for k, row in enumerate(BOTH)]
    rows[45] = [rows[45][0], "c", *rows[45][2:]]
    found, _ = read(tmp_path, HEAD, rows)
    assert sentence(found.notes, "table.rows_of_nobody").parameters["count"] == 2
    assert sentence(found.notes, "table.rows_of_none").parameters["values"] == ["c"]


def test_devices_whose_clock_runs_over_its_end(tmp_path):
    stamps = [str(int(64_000 + 10 * k) % 65_536) for k in range(N)]
    rows = in_turns(device("a", ROWS, stamps), device("b", ROWS[::-1], stamps))
    found, _ = read(tmp_path, HEAD.replace("time", "time_ms"), rows)
    assert set(found.sensors) == {"a", "b"}
    assert found.sensors["a"].time_s[-1] == pytest.approx((N - 1) / 100.0)


def test_counters_that_begin_at_other_numbers_stand_beside_each_other(tmp_path):
    counts = [[str(first + k) for k in range(N)] for first in (7, 400)]
    rows = in_turns(device("a", ROWS, counts[0]), device("b", ROWS[::-1], counts[1]))
    found, said = read(tmp_path, HEAD.replace("time", "counter"), rows, 100.0)
    assert "table.counters_apart" in said
    for name, gyroscope in (("a", GYROSCOPE[:N]), ("b", GYROSCOPE[::-1][:N])):
        there = np.isfinite(found.sensors[name].gyroscope_radps).all(axis=1)
        assert there.sum() >= N - 2
        np.testing.assert_allclose(found.sensors[name].gyroscope_radps[there][5], gyroscope[5], atol=0.2)


@pytest.mark.parametrize(
    "names",
    [
        ["gx A", "gy A", "gz A", "ax A", "ay A", "az A"],
        ["wx_rads", "wy_rads", "wz_rads", "ax_ms2", "ay_ms2", "az_ms2"],
        ["omegax", "omegay", "omegaz", "specific forcex", "specific forcey", "specific forcez"],
        [f"Drehrate {a} [rad·s⁻¹]" for a in "xyz"] + [f"Beschleunigung {a} [m·s⁻²]" for a in "xyz"],
    ],
)
def test_names_and_units(tmp_path, names):
    rows = [[s, *r] for s, r in zip(STAMPS, ROWS, strict=True)]
    found, _ = read(tmp_path, ",".join(["time", *names]), rows)
    (signals,) = found.sensors.values()
    is_as_measured(signals, GYROSCOPE)


def test_clocks_of_quantities_with_names_of_two_words(tmp_path):
    later = [f"{stamp + 0.004:.3f}" for stamp in TIME_S]
    head = ["omega_time", *(f"omega {a}" for a in "xyz")]
    head += ["specific force_time", *(f"specific force {a}" for a in "xyz")]
    rows = [[s, *r[:3], t, *r[3:]] for s, t, r in zip(STAMPS, later, ROWS, strict=True)]
    found, said = read(tmp_path, ",".join(head), rows)
    assert "guess.own_clocks" in said
    assert np.abs(found.sensors["imu"].accelerometer_mps2[1:] - FORCE[1:]).max() > 0.1


def test_a_device_may_be_called_second(tmp_path):
    names = [f"{name}_{column}" for name in ("first", "second") for column in ["time", *NINE[:6]]]
    rows = [[s, *a, s, *b] for s, a, b in zip(STAMPS, ROWS, ROWS[::-1], strict=True)]
    found, said = read(tmp_path, ",".join(names), rows)
    assert set(found.sensors) == {"first", "second"}
    assert "guess.own_clocks" in said


def test_the_stamps_of_the_device_beside_those_of_arrival(tmp_path):
    arrival = [f"{stamp:.3f}" for stamp in 0.08 * np.ceil((TIME_S + 0.01) / 0.08)]
    rows = [[a, s, *r] for a, s, r in zip(arrival, STAMPS, ROWS, strict=True)]
    found, said = read(tmp_path, ",".join(["host time (s)", "device time (s)", *NINE[:6]]), rows)
    np.testing.assert_allclose(found.sensors["imu"].time_s, TIME_S, atol=1e-6)
    assert "guess.clocks_left" in said
    assert "time.repeated" not in said


def test_rows_of_text_and_few_numbers_are_a_table(tmp_path):
    stamps = [f"01/02/2026 03:18:{k // 100:02d}.{10 * (k % 100):03d}" for k in range(N)]
    rows = in_turns(
        *(
            [
                [s, "one", kind, *(r[:3] if kind == "gyroscope" else r[3:])]
                for s, r in zip(stamps, ROWS, strict=False)
            ]
            for kind in ("gyroscope", "accelerometer")
        )
    )
    found, _ = read(tmp_path, "DateTime,device,sensor,x,y,z", rows)
    is_as_measured(found.sensors["imu"], GYROSCOPE[:N])


def test_stamps_of_microseconds_that_are_called_fine(tmp_path):
    stamps = [str((4_294_000_000 + 10_000 * k) % 2**32) for k in range(len(ROWS))]
    rows = [[s, *r] for s, r in zip(stamps, ROWS, strict=True)]
    found, said = read(tmp_path, ",".join(["SampleTimeFine", *NINE[:6]]), rows)
    assert "guess.microseconds" in said
    np.testing.assert_allclose(found.sensors["imu"].time_s, TIME_S, atol=1e-9)


@pytest.mark.parametrize("rate_hz", [60.0, 104.0, 120.0, 128.0, 148.148, 256.0, 400.0])
@pytest.mark.parametrize("lost", [0.0, 0.05])
def test_the_rate_of_stamps_in_whole_milliseconds(rate_hz, lost):
    rng = np.random.default_rng(2)
    time_s = np.arange(2000)[rng.random(2000) >= lost] / rate_hz
    assert nominal_rate(np.floor(1000.0 * time_s) / 1000.0) == pytest.approx(rate_hz, rel=5e-3)
    assert nominal_rate(time_s) == pytest.approx(rate_hz, rel=1e-3)


def test_the_rate_of_800_hz_in_whole_milliseconds():
    assert nominal_rate(np.floor(1000.0 * np.arange(3000) / 800.0) / 1000.0) == 800.0


@pytest.mark.parametrize("rate_hz", [20.0, 62.5, 100.0])
@pytest.mark.parametrize("begins_s", [0.1, 0.55, 0.93])
def test_a_clock_of_whole_seconds_that_begins_within_one(rate_hz, begins_s):
    time_s = begins_s + np.arange(int(6 * rate_hz)) / rate_hz
    found = mended(np.floor(time_s), 1.0).time_s
    np.testing.assert_allclose(found, time_s - time_s[0], atol=1.0 / rate_hz)


def test_a_sample_that_a_packet_misses_moves_no_other_by_more_than_a_step():
    time_s = np.arange(800) / 100.0
    stamps = 0.08 * np.floor(time_s / 0.08 + 1e-9)
    there = np.ones(800, dtype=bool)
    there[np.arange(5, 790, 37)] = False
    found = mended(stamps[there], 1.0).time_s
    apart = found - time_s[there]
    assert np.abs(apart - np.median(apart)).max() < 0.0101
    assert nominal_rate(found) == pytest.approx(100.0, rel=2e-3)


@pytest.mark.parametrize("bits", [16, 24, 32])
def test_one_place_knows_where_clocks_run_over(bits):
    true = 2.0**bits - 3000.0 + 10.0 * np.arange(800)
    written = np.mod(true, 2.0**bits)
    np.testing.assert_array_equal(gone_on(written), true)
    np.testing.assert_array_equal(unwrapped(written)[0], true)
    # A row that came late there goes over the end and back.
    late = written.copy()
    late[[299, 301]] = late[[301, 299]]
    np.testing.assert_array_equal(np.sort(gone_on(late)), true)


def test_a_counter_of_one_byte_that_lost_much_at_its_end():
    count = np.concatenate([np.arange(186, 250), np.arange(328, 480)])
    np.testing.assert_array_equal(unwrapped(np.mod(count, 256).astype(float))[0], count)


def test_phases_of_a_recording_are_no_devices(tmp_path):
    stamps = [f"2026-12-25 09:05:{20 + int(0.4 + stamp):02d}" for stamp in TIME_S]
    for name in ("imu3 activity", "position"):
        phases = [("rest", "reach", "back")[k // 90 % 3] for k in range(len(ROWS))]
        rows = [[s, *r, phase] for s, r, phase in zip(stamps, ROWS, phases, strict=True)]
        found, said = read(tmp_path, ",".join(["time", *NINE[:6], name]), rows)
        assert set(found.sensors) == {"imu"}
        assert "guess.devices" not in said


@pytest.mark.parametrize("words", [("init", "on"), ("A1", "A2"), ("idle", "measuring", "idle")])
def test_a_column_of_devices_that_only_changes_its_word_is_one(tmp_path, words):
    rows = [
        [s, words[k * len(words) // len(ROWS)], *r] for k, (s, r) in enumerate(zip(STAMPS, ROWS, strict=True))
    ]
    found, said = read(tmp_path, HEAD, rows)
    (signals,) = found.sensors.values()
    is_as_measured(signals, GYROSCOPE)
    assert "guess.one_device" in said


def test_a_device_that_lies_as_another_did_not_is_another(tmp_path):
    half = len(ROWS) // 2
    turned = [[row[k] for k in (1, 2, 0, 4, 5, 3)] for row in ROWS[half:]]
    rows = [[s, "a", *r] for s, r in zip(STAMPS, ROWS[:half], strict=False)]
    rows += [[s, "b", *r] for s, r in zip(STAMPS[half:], turned, strict=True)]
    path = tmp_path / "table.csv"
    path.write_text(text([HEAD], rows))
    guess = readers.preview_text(path.name, path.read_bytes()[: readers.HEAD_BYTES], None, None).guess
    assert "guess.devices" in codes(guess.notes)


def test_a_recorder_that_changes_its_name_is_no_sensor_beside_limbs(tmp_path):
    limbs = [f"{limb}_{name}" for limb in ("upper_arm_right", "forearm_right") for name in NINE[:6]]
    names = ["A1" if k < len(ROWS) // 2 else "A2" for k in range(len(ROWS))]
    rows = [[s, n, *r, *o] for s, n, r, o in zip(STAMPS, names, ROWS, ROWS[::-1], strict=True)]
    found, said = read(tmp_path, ",".join(["time", "device", *limbs]), rows)
    assert set(found.sensors) == {"upper_arm_right", "forearm_right"}
    is_as_measured(found.sensors["forearm_right"], GYROSCOPE[::-1])
    assert "guess.one_device" in said


def test_a_clock_of_few_steps_that_was_set_back_does_not_run_over():
    stamps = np.concatenate([np.arange(0.0, 50_000.0, 10_000.0), np.arange(0.0, 90_000.0, 10_000.0)])
    np.testing.assert_array_equal(gone_on(stamps), stamps)


def test_a_table_of_nine_is_as_it_was(tmp_path):
    rows = [[s, *r] for s, r in zip(STAMPS, numbers(np.column_stack([SIX, FIELD_UT])), strict=True)]
    found, said = read(tmp_path, PLAIN, rows)
    is_as_measured(found.sensors["imu"], GYROSCOPE)
    assert "guess.clocks_left" not in said


def test_what_is_left_of_a_packet_behind_a_hole_ends_where_the_next_one_begins():
    time_s = np.arange(400) / 120.0
    stamps = (8 * (np.arange(400) // 8) + 7) / 120.0 + 2e-5 * (np.arange(400) % 8)
    there = np.ones(400, dtype=bool)
    there[141:245] = False
    found = mended(stamps[there], 1.0).time_s
    np.testing.assert_allclose(found, time_s[there], atol=1e-3)


def test_stamps_that_run_over_their_end_early_have_the_unit_of_their_steps(tmp_path):
    at = [4_294_967_061 + round(1000.0 * k / 256.0) for k in range(N)]
    stamps = [str(one % 2**32) for one in at]
    rows = in_turns(
        [[stamp, "Gyroscope", *row[:3]] for stamp, row in zip(stamps, ROWS, strict=False)],
        [[stamp, "TotalAcceleration", *row[3:]] for stamp, row in zip(stamps, ROWS, strict=False)],
    )
    found, said = read(tmp_path, "timestamp,sensor,x,y,z", rows)
    assert found.nominal_rate_hz == pytest.approx(256.0, rel=5e-3)
    assert "guess.time_unit" not in said


@pytest.mark.parametrize(("step", "lost"), [(50.0, 57), (20.0, 101), (5.0, 230)])
def test_a_clock_of_two_bytes_that_ran_over_its_end_in_a_hole(step, lost):
    true = step * np.arange(400) + 65_538.0 - step * (42 + 0.5 * lost)
    there = np.ones(400, dtype=bool)
    there[42 : 42 + lost] = False
    np.testing.assert_array_equal(gone_on(np.mod(true, 65_536.0)[there]), true[there])


def test_a_clock_of_two_bytes_that_was_started_again_begins_at_its_zero():
    again = 50.0 * np.concatenate([np.arange(1220, 1262), np.arange(100)])
    np.testing.assert_array_equal(gone_on(again), again)


def test_rows_of_kinds_may_begin_with_those_of_the_field(tmp_path):
    # A column of marks stands beside: whether it names devices was asked of the jumps of no signal at all.
    field = numbers(FIELD_UT)
    rows = in_turns(
        *(
            [[stamp, kind, *row, "0"] for stamp, row in zip(STAMPS[:N], values, strict=False)]
            for kind, values in (
                ("android.sensor.magnetic_field", field),
                ("android.sensor.gyroscope", [row[:3] for row in ROWS]),
                ("android.sensor.accelerometer", [row[3:] for row in ROWS]),
            )
        )
    )
    rows[30][-1] = "1"
    found, _ = read(tmp_path, "time,sensor,x,y,z,button", rows)
    is_as_measured(found.sensors["imu"], GYROSCOPE[:N])


def test_devices_under_the_same_headings_have_one_unit(tmp_path):
    noise = 0.01 * np.random.default_rng(4).standard_normal((2, N, 6))
    at_s = np.arange(N) / 100.0
    rate, angle = 1.5 * np.cos(at_s), 1.5 * np.sin(at_s)
    about_x = np.column_stack(
        [rate, 0 * rate, 0 * rate, 0 * rate, 9.81 * np.sin(angle), 9.81 * np.cos(angle)]
    )
    # By itself it looks as one that rests and counts degrees.
    about_vertical = np.tile([0.0, 0.0, 2.0, 0.0, 0.0, 9.81], (N, 1))
    turned, steady = about_x + noise[0], about_vertical + noise[1]
    head = "time,device,gx,gy,gz,ax,ay,az"
    found, said = read(tmp_path, head, in_turns(device("a", numbers(turned)), device("b", numbers(steady))))
    for name, values in (("a", turned), ("b", steady)):
        np.testing.assert_allclose(found.sensors[name].gyroscope_radps, values[:, :3], atol=1e-4)
    assert "guess.unit_assumed" not in said
    # Beside one that rests nothing turns as gravity does: what is taken over is said.
    _, said = read(tmp_path, head, in_turns(device("a", ROWS), device("b", numbers(steady))))
    assert "guess.unit_of_others" in said
