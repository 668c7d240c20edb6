"""Times of day as text: which are read, and what a jump of them means."""

import numpy as np
import pytest

from app.readers.tables.clocks.of_day import is_clock, seconds_of_clock
from tests.said import codes


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("2026-11-22T10:00:00.123Z", "2026-11-22T10:00:00.133Z"),
        ("2026-11-22T10:00:00,123+01:00", "2026-11-22T09:00:00,133Z"),
        ("2026-11-22 10:00:00.123 +0530", "2026-11-22 04:30:00.133 UTC"),
        ("2026/11/22 10:00:00.123-08", "2026/11/22 18:00:00.133Z"),
        ("22.11.2026 23:59:59.995", "23.11.2026 00:00:00.005"),
        ("11/22/2026 11:59:59.995 PM", "11/23/2026 12:00:00.005 AM"),
        ("22/11/2026 23:59:59.995", "23/11/2026 00:00:00.005"),
        ("1/12/2026 23:59:59.995", "1/13/2026 00:00:00.005"),
        ("01/12/2026 23:59:59.995", "02/12/2026 00:00:00.005"),
        ("10:00:00:123", "10:00:00:133"),
        ("11:59:59.995 am", "12:00:00.005 PM"),
        ("23:59:59.995", "00:00:00.005"),
        ("11/22/26 23:59:59.995", "11/23/26 00:00:00.005"),
        ("31-12-26 23:59:59.995", "01-01-27 00:00:00.005"),
        ("26-12-31 23:59:59.995", "27-01-01 00:00:00.005"),
        ("9:5:3.995", "9:5:4.005"),
        ("59:59.995", "00:00.005"),
        ("5:9.995", "5:10.005"),
        ("100:59.995", "101:00.005"),
    ],
)
def test_the_difference_of_two_times(first, second):
    seconds, _ = seconds_of_clock([first, second])
    assert np.diff(seconds)[0] == pytest.approx(0.01, abs=1e-9)


@pytest.mark.parametrize(
    "text", ["", "12", "11/22/2026", "11/22/26", "2026-11-22", "10:00", "10:00:00.1.2", "a10:00:00"]
)
def test_what_is_no_time_of_day(text):
    assert not is_clock(text)


def test_times_that_no_clock_shows_are_none():
    seconds, notes = seconds_of_clock(
        ["10:00:00", "10:61:00", "2026-02-30 10:00:00", "13:00:00 PM", None, "10:00:01"]
    )
    assert np.isnan(seconds[1:5]).all()
    assert seconds[5] - seconds[0] == 1.0
    assert notes == ()


def test_one_damaged_date_with_slashes_does_not_turn_the_others():
    seconds, _ = seconds_of_clock(["11/22/2026 10:00:00", "31/11/2026 10:00:00", "11/22/2026 10:00:02"])
    assert np.isnan(seconds[1])
    assert seconds[2] - seconds[0] == 2.0


def test_the_order_of_most_rows_counts_not_of_most_dates():
    seconds, _ = seconds_of_clock(
        ["11/22/2026 10:00:00"] * 9 + ["22/11/2026 10:00:00", "23/11/2026 10:00:00"]
    )
    assert np.isfinite(seconds).tolist() == [True] * 9 + [False] * 2


def test_a_row_that_came_late_at_midnight_stays_where_it_was():
    seconds, notes = seconds_of_clock(["23:59:59.99", "00:00:00.01", "23:59:59.995", "00:00:00.02"])
    np.testing.assert_allclose(seconds - seconds[0], [0.0, 0.02, 0.005, 0.03], atol=1e-9)
    assert codes(notes) == ["time.midnight"]


def test_a_pause_of_an_hour_within_an_hour_is_a_pause():
    seconds, notes = seconds_of_clock(["2026-11-22 10:20:00", "2026-11-22 11:20:00"])
    assert np.diff(seconds)[0] == 3600.0
    assert notes == ()


def test_a_clock_put_forward_with_its_zone_is_no_jump():
    seconds, notes = seconds_of_clock(["2026-03-29T01:59:59.99+01:00", "2026-03-29T03:00:00.00+02:00"])
    assert np.diff(seconds)[0] == pytest.approx(0.01, abs=1e-9)
    assert notes == ()


def test_thousandths_without_leading_zeros_are_no_decimals():
    seconds, _ = seconds_of_clock([f"10:00:0{k // 1000}:{k % 1000}" for k in range(0, 3000, 7)])
    np.testing.assert_allclose(np.diff(seconds), 0.007, atol=1e-9)


def test_decimals_whose_zeros_at_the_end_are_left_out_stay_decimals():
    seconds, _ = seconds_of_clock(
        [f"10:00:{k / 1000:.3f}".rstrip("0").rstrip(".") for k in range(10_005, 30_000, 5)]
    )
    np.testing.assert_allclose(np.diff(seconds), 0.005, atol=1e-9)


def test_a_passed_hour_of_minutes_and_seconds_is_said():
    seconds, notes = seconds_of_clock(["59:50.5", "59:59.5", "00:08.5"])
    np.testing.assert_allclose(seconds - seconds[0], [0.0, 9.0, 18.0], atol=1e-9)
    assert codes(notes) == ["time.hour_passed"]
