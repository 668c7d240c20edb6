"""Recordings at thousands of samples a second are averaged down, and say so."""

import numpy as np
import pytest

from app.readers.slower import slower
from estimators.recording import Recording, SensorSignals
from tests.said import codes


def recording(rate_hz: float, time_s: np.ndarray) -> Recording:
    """A slow turn, with a vibration above half of what is estimated on top."""
    turn = np.sin(2.0 * np.pi * 1.5 * time_s)
    shaken = turn + 0.5 * np.sin(2.0 * np.pi * 0.5 * rate_hz * time_s + 0.5 * np.pi)
    three = np.stack([shaken, turn, 0.0 * turn], axis=1)
    return Recording({"imu": SensorSignals(time_s, three, three + 9.8, None)}, rate_hz)


@pytest.mark.parametrize(("rate_hz", "expected_hz"), [(1125.0, 562.5), (4000.0, 1000.0), (1024.0, 512.0)])
def test_means_leave_the_movement_and_no_alias(rate_hz, expected_hz):
    found = slower(recording(rate_hz, np.arange(int(3 * rate_hz)) / rate_hz))
    signals = found.sensors["imu"]
    assert found.nominal_rate_hz == expected_hz
    assert codes(found.notes) == ["file.averaged_down"]
    np.testing.assert_allclose(np.diff(signals.time_s), 1.0 / expected_hz, rtol=1e-6)
    np.testing.assert_allclose(
        signals.gyroscope_radps[:, 0], np.sin(2.0 * np.pi * 1.5 * signals.time_s), atol=1e-3
    )


def test_a_hole_stays_a_hole():
    time_s = np.arange(6000) / 2000.0
    there = (time_s < 1.0) | (time_s > 1.5)
    signals = slower(recording(2000.0, time_s[there])).sensors["imu"]
    assert np.diff(signals.time_s).max() == pytest.approx(0.5, abs=4e-3)
    assert signals.time_s[-1] == pytest.approx(2.999, abs=2e-3)


def test_what_is_slow_enough_stays_as_it_is():
    as_it_is = recording(1000.0, np.arange(2000) / 1000.0)
    assert slower(as_it_is) is as_it_is


def test_few_samples_a_second_are_filled_up_and_that_is_said():
    time_s = np.delete(np.arange(40) / 4.0, np.arange(20, 26))
    found = slower(Recording({"imu": recording(4.0, time_s).sensors["imu"]}, 4.0))
    signals = found.sensors["imu"]
    assert (found.nominal_rate_hz, codes(found.notes)) == (20.0, ["file.slow"])
    np.testing.assert_allclose(np.diff(signals.time_s)[:95], 0.05, atol=1e-9)
    # A hole stays one.
    assert np.diff(signals.time_s).max() == pytest.approx(7 / 4.0)
    there = np.isin(np.round(signals.time_s, 6), np.round(time_s, 6))
    np.testing.assert_array_equal(
        signals.gyroscope_radps[there], recording(4.0, time_s).sensors["imu"].gyroscope_radps
    )
    middle = 0.5 * (signals.gyroscope_radps[0] + signals.gyroscope_radps[5])
    np.testing.assert_allclose(
        0.5 * (signals.gyroscope_radps[2] + signals.gyroscope_radps[3]), middle, atol=1e-12
    )
