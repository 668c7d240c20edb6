"""Feet of slow sensors and over bad links; the truth is that of the simulation."""

import numpy as np
import pytest

from estimators.gait import FootParameters, smooth
from estimators.gait.foot.bridge_kernel import add_bridge_noise
from estimators.gait.foot.gaps import fill_gaps
from estimators.gait.foot.parameters import with_clips
from estimators.recording import SensorSignals
from estimators.simulation import gait_preset, simulate_gait
from validation.foot.rates import averaged, lossy, picked
from validation.foot.recordings import followed, rigid_rmse


def turning(time_s, rate_radps=8.0):
    """Return signals of a sensor that swings about two axes."""
    gyroscope = rate_radps * np.stack(
        [np.sin(7.0 * time_s), np.cos(9.0 * time_s), 0.1 * np.sin(5.0 * time_s)], axis=1
    )
    return SensorSignals(time_s, gyroscope, gyroscope + np.array([0.0, 0.0, 9.81]))


def test_a_slow_sensor_is_followed_in_the_steps_of_a_fast_one():
    fast = turning(np.arange(2000) / 200.0)
    slow = averaged(fast, 4)
    filled = fill_gaps(slow, 50.0)
    assert (filled.rate_hz, filled.lag) == (200.0, 4)
    assert np.diff(filled.signals.time_s) == pytest.approx(0.005)
    assert not filled.gap_s.any()
    # Averaging over 20 ms leaves (w h)^2 / 24 of a swing at w = 9 rad/s: 0.1 %, and the curve adds little.
    true = turning(filled.signals.time_s).gyroscope_radps
    assert np.abs(filled.signals.gyroscope_radps - true)[50:-50].max() < 0.05


def test_a_sensor_that_is_fast_and_whole_is_left_alone():
    signals = turning(np.arange(1000) / 100.0)
    filled = fill_gaps(signals, 100.0)
    assert filled.lag == 1
    assert np.array_equal(filled.signals.gyroscope_radps, signals.gyroscope_radps)


def test_every_lost_sample_is_bridged_and_says_so():
    time_s = np.arange(1000) / 200.0
    lost = np.array([200, 400, 401, 600, 601, 602])
    signals = turning(np.delete(time_s, lost))
    filled = fill_gaps(signals, 200.0)
    assert filled.signals.time_s == pytest.approx(time_s)
    assert np.flatnonzero(filled.gap_s).tolist() == lost.tolist()
    assert not filled.is_missing.any()


def bridge_noise(scale, lag=1):
    """Return what is added for a bridge of three steps between samples that change by `scale`."""
    values = np.ascontiguousarray(scale * np.repeat(np.arange(40) % 2, lag)[:, None] * np.ones((1, 3)))
    filled = np.zeros(len(values), dtype=np.bool_)
    filled[20 * lag + 1 : 23 * lag] = True
    force, rate = np.zeros(len(values)), np.zeros((len(values), 3))
    add_bridge_noise(values, values, filled, filled, 0, len(values), 10 * lag, lag, 0.005, force, rate)
    assert not force[~filled].any()
    return force[filled], rate[filled]


@pytest.mark.parametrize("lag", [1, 4])
def test_a_bridge_is_as_doubtful_as_the_signal_beside_it_is_unsteady(lag):
    force, rate = bridge_noise(2.0, lag)
    # j^2 n D with j = 2, n = 3, D = 15 ms
    assert force == pytest.approx(0.18)
    assert rate == pytest.approx(0.18)
    assert not np.any(bridge_noise(0.0, lag)[1])


def test_a_clip_level_is_found_in_the_samples():
    time_s = np.arange(4000) / 200.0
    signals = turning(time_s, 20.0)
    clipped = SensorSignals(time_s, np.clip(signals.gyroscope_radps, -15.0, 15.0), signals.accelerometer_mps2)
    assert with_clips(clipped, FootParameters()).gyroscope_clip_radps == pytest.approx(15.0, rel=0.01)
    assert with_clips(signals, FootParameters()) == FootParameters()


@pytest.mark.parametrize("burst_s", [0.0, 0.02])
def test_a_walk_with_a_twentieth_lost_stays_where_it_was(burst_s):

    walk = simulate_gait(gait_preset("placement"))
    signals = walk.recording.sensors["heel_left"]
    whole, broken = smooth(signals), smooth(lossy(signals, burst_s, [7]))
    whole_m = whole.position_m[-1] - whole.position_m[0]
    broken_m = broken.position_m[-1] - broken.position_m[0]
    apart = np.linalg.norm(whole_m[:2]) - np.linalg.norm(broken_m[:2])
    assert abs(apart) < 0.01 * np.linalg.norm(whole_m[:2])


@pytest.mark.parametrize("begin_s", [5.2, 5.5, 5.8, 6.1])
def test_begun_while_walking_live_says_nothing_is_known_until_it_is(begin_s):
    walk = simulate_gait(gait_preset("placement"))
    signals = walk.recording.sensors["heel_left"]
    parameters = FootParameters()
    whole = smooth(signals, parameters)
    begin = int(np.searchsorted(signals.time_s, begin_s))
    late = picked(signals, slice(begin, None))
    found, is_known = followed(late, walk.recording.nominal_rate_hz, parameters)
    since = int(np.argmax(is_known))
    assert is_known.any()
    assert late.time_s[since] - late.time_s[0] < 4.0
    true = np.stack([np.interp(late.time_s, whole.time_s, whole.position_m[:, i]) for i in (0, 1)], axis=1)
    assert rigid_rmse(found[since:, :2], true[since:]) < 0.05
