"""Feet that move and do not walk: nothing may be made of them."""

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators.conventions import GRAVITY_MPS2
from estimators.gait import FootFlag, find_strides, guided_test, smooth, steady, summarise
from estimators.gait._stride_flags import StrideFlag
from estimators.recording import SensorSignals
from tests.said import codes

RATE = 100.0
TIME_S = np.arange(2000) / RATE


def noise(sigma, seed):
    return sigma * np.random.default_rng(seed).standard_normal((len(TIME_S), 3))


def swung(amplitude_rad, rate_hz, radius_m=0.4):
    """Return a lower leg that swings from a chair about the knee."""
    w = 2.0 * np.pi * rate_hz
    angle = amplitude_rad * np.sin(w * TIME_S)
    rate, change = amplitude_rad * w * np.cos(w * TIME_S), -w * w * angle
    zero = np.zeros_like(angle)
    gyroscope = np.stack([zero, rate, zero], axis=1)
    along = -radius_m * change - GRAVITY_MPS2 * np.sin(angle)
    force = np.stack([along, zero, radius_m * rate**2 + GRAVITY_MPS2 * np.cos(angle)], axis=1)
    return SensorSignals(TIME_S, gyroscope + noise(0.005, 1), force + noise(0.05, 2))


def pedalled(rate_hz, radius_m=0.17):
    """Return a foot that stays level on a pedal."""
    w = 2.0 * np.pi * rate_hz
    turn = np.stack([-np.cos(w * TIME_S), np.zeros_like(TIME_S), -np.sin(w * TIME_S)], axis=1)
    force = radius_m * w * w * turn + [0.0, 0.0, GRAVITY_MPS2]
    return SensorSignals(TIME_S, noise(0.005, 3), force + noise(0.05, 4))


def shaken(turning_radps):
    force = noise(2.5 * turning_radps, 6)
    force[:, 2] += GRAVITY_MPS2
    return SensorSignals(TIME_S, noise(turning_radps, 5), force)


@pytest.mark.parametrize(
    "signals",
    [
        swung(0.3, 0.5),
        swung(0.5, 1.0),
        swung(0.8, 1.0),
        swung(0.5, 1.5),
        pedalled(0.7),
        pedalled(1.0),
        shaken(2.0),
    ],
    ids=["slow leg", "leg", "wide leg", "fast leg", "slow pedal", "pedal", "shaken"],
)
def test_no_walking_has_no_strides_and_says_so(signals):
    strides = find_strides(smooth(signals), "left")
    assert strides.count == 0
    assert "walk.no_stride" in codes(summarise({"left": strides}).reasons)
    assert guided_test({"left": strides}) is None


@pytest.mark.parametrize("signals", [shaken(2.0), shaken(1.0), pedalled(1.5), swung(0.5, 1.5)])
def test_what_never_stands_is_said_to_have_no_stance(signals):
    assert (smooth(signals).flags & FootFlag.NO_STANCE).all()


def test_a_walk_after_a_leg_swung_is_the_walk():
    walk, swing = foot_walk(strides=6, noise=1.0).signals, swung(0.5, 1.0)
    both = SensorSignals(
        np.arange(len(walk.time_s) * 2 + len(TIME_S)) / RATE,
        *(
            np.concatenate([getattr(part, name) for part in (walk, swing, walk)])
            for name in ("gyroscope_radps", "accelerometer_mps2")
        ),
    )
    strides = find_strides(smooth(both), "left")
    aloft = (strides.flags & StrideFlag.ALOFT) != 0
    assert strides.count == 13
    assert np.flatnonzero(aloft).tolist() == [6]
    np.testing.assert_allclose(strides.length_m[~aloft], 1.2, atol=0.05)
    assert not steady(strides)[aloft].any()
    assert "walk.aloft" in codes(summarise({"left": strides}).reasons)
    found = guided_test({"left": strides})
    assert found.distance_m == pytest.approx(12 * 1.2, abs=0.1)
    assert found.step_count == 24
