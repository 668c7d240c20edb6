"""Time bases, gaps and filters against closed forms."""

import numpy as np
import pytest

from estimators import rotation, signals
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.recording import Recording, SampleQuality, SensorSignals
from tests.said import refuses

MEASURED, BRIDGED, MISSING, SATURATED = (
    int(q)
    for q in (SampleQuality.MEASURED, SampleQuality.BRIDGED, SampleQuality.MISSING, SampleQuality.SATURATED)
)
RATE = 100.0


def line(time_s: np.ndarray) -> np.ndarray:
    """Linear in time, so that interpolation has a closed form."""
    return np.stack((time_s, 2.0 - 3.0 * time_s, np.full_like(time_s, 0.5)), axis=-1)


def sensor(time_s: np.ndarray, field: bool = True) -> SensorSignals:
    return SensorSignals(time_s, line(time_s), 10.0 * line(time_s), 1e-5 * line(time_s) if field else None)


def recording(**sensors: SensorSignals) -> Recording:
    return Recording(sensors, RATE)


def even(count: int = 200, rate: float = RATE) -> np.ndarray:
    return np.arange(count) / rate


class TestEven:
    def test_passes_bit_for_bit(self):
        rng = np.random.default_rng(3)
        values = rng.standard_normal((3, 200, 3))
        given = SensorSignals(even(), *values)
        chunk = signals.to_common_ticks(recording(a=given, b=sensor(even())), RATE)
        np.testing.assert_array_equal(chunk.gyroscope_radps[0], given.gyroscope_radps)
        np.testing.assert_array_equal(chunk.accelerometer_mps2[0], given.accelerometer_mps2)
        np.testing.assert_array_equal(chunk.magnetometer_t[0], given.magnetometer_t)
        assert not chunk.quality.any()
        assert chunk.first_tick == 0

    def test_passes_when_stamps_have_an_offset_and_rounding(self):
        rng = np.random.default_rng(3)
        stamps = np.round(even() + 12.3437, 4) + rng.uniform(-1e-5, 1e-5, 200)
        given = SensorSignals(stamps, *rng.standard_normal((2, 200, 3)))
        chunk = signals.to_common_ticks(recording(a=given), RATE)
        np.testing.assert_array_equal(chunk.gyroscope_radps[0], given.gyroscope_radps)
        assert chunk.first_tick == 1234
        assert chunk.magnetometer_t is None

    def test_lost_samples_are_bridged_or_missing(self):
        keep = np.ones(200, dtype=bool)
        keep[50:70] = False  # 20 lost ticks are 200 ms: the longest that may be bridged
        keep[100:121] = False  # one more is too long
        chunk = signals.to_common_ticks(recording(a=sensor(even()[keep])), RATE)
        expected = np.zeros(200)
        expected[50:70], expected[100:121] = BRIDGED, MISSING
        np.testing.assert_array_equal(chunk.quality[0], expected)
        np.testing.assert_allclose(chunk.gyroscope_radps[0, 50:70], line(even()[50:70]), atol=1e-12)
        for values in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t):
            assert np.isnan(values[0, 100:121]).all()
            assert np.isfinite(np.delete(values[0], np.s_[100:121], axis=0)).all()

    def test_not_finite_samples_are_lost_samples(self):
        given = sensor(even())
        given.gyroscope_radps[20:24] = np.nan
        given.accelerometer_mps2[80:140, 1] = np.inf
        chunk = signals.to_common_ticks(recording(a=given), RATE)
        assert (chunk.quality[0, 20:24] == BRIDGED).all()
        assert (chunk.quality[0, 80:140] == MISSING).all()
        assert not chunk.quality[0, [19, 24, 79, 140]].any()

    def test_sensors_that_start_late_or_end_early_are_missing_there(self):
        chunk = signals.to_common_ticks(recording(a=sensor(even()), b=sensor(even()[30:150])), RATE)
        assert (chunk.quality[1, :30] == MISSING).all()
        assert (chunk.quality[1, 150:] == MISSING).all()
        assert not chunk.quality[1, 30:150].any()

    def test_clipped_samples_are_marked(self):
        given = sensor(even())
        given.gyroscope_radps[40, 2] = -34.9
        given.accelerometer_mps2[60, 0] = 156.9
        chunk = signals.to_common_ticks(
            recording(a=given), RATE, gyroscope_clip_radps=34.9, accelerometer_clip_mps2=156.9
        )
        assert np.flatnonzero(chunk.quality[0] & SATURATED).tolist() == [40, 60]

    def test_magnetometer_may_be_slower_or_absent(self):
        given = sensor(even())
        given.magnetometer_t[np.arange(200) % 5 != 0] = np.nan
        chunk = signals.to_common_ticks(recording(a=given, b=sensor(even(), field=False)), RATE)
        np.testing.assert_allclose(chunk.magnetometer_t[0, :196], 1e-5 * line(even()[:196]), atol=1e-15)
        assert np.isnan(chunk.magnetometer_t[1]).all()
        assert not chunk.quality.any()


class TestUneven:
    def test_jittered_stamps_are_brought_to_the_tick(self):
        stamps = even() + np.random.default_rng(5).uniform(-0.003, 0.003, 200)
        stamps[0] = 0.0
        chunk = signals.to_common_ticks(recording(a=sensor(stamps)), RATE)
        inside = chunk.time_s <= stamps[-1]
        np.testing.assert_allclose(chunk.gyroscope_radps[0, inside], line(chunk.time_s[inside]), atol=1e-12)
        assert not chunk.quality[0, inside].any()

    def test_gaps_in_jittered_stamps(self):
        stamps = even() + np.random.default_rng(5).uniform(-0.003, 0.003, 200)
        stamps[0] = 0.0
        stamps = np.delete(stamps, np.r_[50:60, 100:140])
        chunk = signals.to_common_ticks(recording(a=sensor(stamps)), RATE)
        # The ticks beside a gap may count as measured when a sample lies within half an interval.
        assert (chunk.quality[0, 51:59] == BRIDGED).all()
        assert (chunk.quality[0, 101:139] == MISSING).all()
        assert not chunk.quality[0, np.r_[1:49, 61:99, 141:198]].any()

    def test_other_rate_keeps_the_angle_turned_through(self):
        time_s = even(2000, 1000.0)
        rate = 3.0 * np.sin(2 * np.pi * 1.3 * time_s) + 0.4
        values = np.stack((rate, rate, rate), axis=-1)
        chunk = signals.to_common_ticks(recording(a=SensorSignals(time_s, values, values)), 50.0)
        # Ticks 1 to 98 average over [0.01, 1.97] s.
        turned = 0.4 * 1.96 + 3 / (2.6 * np.pi) * (np.cos(2.6 * np.pi * 0.01) - np.cos(2.6 * np.pi * 1.97))
        # The trapezoid over 1 ms steps errs by step^2/12 times the change of slope: under 1e-5.
        assert chunk.gyroscope_radps[0, 1:99, 0].sum() / 50.0 == pytest.approx(turned, abs=1e-5)

    def test_slower_sensor_is_interpolated_unflagged(self):
        chunk = signals.to_common_ticks(recording(a=sensor(even(40, 17.0))), RATE)
        np.testing.assert_allclose(chunk.gyroscope_radps[0], line(chunk.time_s), atol=1e-12)
        assert not chunk.quality.any()


def test_a_recording_without_samples_is_refused():
    empty = SensorSignals(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)))
    with refuses("recording.no_samples", error=SetupError):
        signals.to_common_ticks(recording(a=empty), RATE)
    with pytest.raises(SetupError, match="rate"):
        signals.to_common_ticks(recording(a=sensor(even())), 0.0)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_stamps_that_are_no_numbers_are_refused(wrong):
    with pytest.raises(ShapeError, match="finite"):
        sensor(np.array([0.0, 0.01, wrong]))


def test_one_wrong_stamp_is_named_instead_of_asking_for_years_of_ticks():
    with refuses("recording.span", error=SetupError):
        signals.to_common_ticks(recording(a=sensor(np.array([0.0, 0.01, 1.7e9]))), RATE)
    paused = np.concatenate((even(100), even(100) + 3600.0))
    assert signals.to_common_ticks(recording(a=sensor(paused)), RATE).tick_count > 360_000


def test_low_pass_has_no_delay_and_stops_high_frequencies():
    time_s = even(1000)
    slow, fast = np.sin(2 * np.pi * 0.5 * time_s), np.sin(2 * np.pi * 20 * time_s)
    smooth = signals.low_pass((slow + fast)[:, None], RATE, 4.0)[:, 0]
    # Butterworth order 2 twice: gain 1/(1+(f/4)^4): 0.9998 at 0.5 Hz, below 1/625 at 20 Hz (bilinear: less)
    np.testing.assert_allclose(smooth[100:-100], slow[100:-100], atol=0.003)
    with pytest.raises(ShapeError):
        signals.low_pass(np.full((10, 1), np.nan), RATE, 4.0)
    with pytest.raises(SetupError):
        signals.low_pass(np.zeros((10, 1)), RATE, 60.0)


def test_derivative_of_a_cubic_is_exact():
    time_s = even()
    cubic = np.stack((time_s**3, time_s**2 - time_s), axis=-1)
    exact = np.stack((3 * time_s**2, 2 * time_s - 1), axis=-1)
    np.testing.assert_allclose(signals.derivative(cubic, RATE), exact, atol=1e-9)
    with pytest.raises(ShapeError):
        signals.derivative(np.zeros((3, 1)), RATE)


def test_rotations_are_interpolated_at_constant_rate():
    times = np.array([0.0, 1.0, 2.0])
    q = rotation.about_z(np.array([0.0, 1.0, 1.5]))
    q[1] *= -1
    at = np.array([-1.0, 0.25, 1.5, 2.0, 9.0])
    expected = rotation.about_z(np.array([0.0, 0.25, 1.25, 1.5, 1.5]))
    np.testing.assert_allclose(
        rotation.angle_between(signals.interpolate_rotations(times, q, at), expected), 0, atol=1e-12
    )


def test_stillness_sees_rest_but_not_motion_or_holes():
    rng = np.random.default_rng(2)
    gyroscope = np.deg2rad([5.0, -2.0, 1.0]) + np.deg2rad(0.5) * rng.standard_normal((600, 3))
    accelerometer = [0.0, 0.0, GRAVITY_MPS2] + 0.1 * rng.standard_normal((600, 3))
    gyroscope[200:300, 1] += np.sin(np.arange(100) * 0.2)
    gyroscope[450] = np.nan
    still = signals.stillness(gyroscope, accelerometer, RATE)
    assert still[30:170].all()
    assert not still[200:300].any()
    assert still[330:420].all()
    assert not still[426:474].any()
    assert not signals.stillness(gyroscope[:100], 2 * accelerometer[:100], RATE).any()
