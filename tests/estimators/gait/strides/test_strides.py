from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators.errors import ShapeError
from estimators.gait import find_strides, smooth, steady, summarise, turns
from estimators.gait._contact import force_events
from estimators.recording import SensorSignals
from estimators.simulation import gait_preset, simulate_gait
from tests.said import codes


@cache
def walked(name):
    walk = simulate_gait(replace(gait_preset(name, 1), rate_hz=100.0))
    feet = {
        side: find_strides(smooth(walk.recording.sensors[f"heel_{side}"]), side) for side in ("left", "right")
    }
    return walk, feet


@pytest.mark.parametrize("name", ["placement", "shuffling", "stroke"])
def test_events_and_lengths_of_simulated_feet(name):
    walk, feet = walked(name)
    for side, strides in feet.items():
        truth = walk.truth.feet[side]
        assert strides.count == len(truth.lift_s) - 1
        np.testing.assert_allclose(strides.toe_off_s, truth.lift_s[:-1], atol=0.025)
        # A dropped foot lands on its toes, softly: found early.
        atol = 0.08 if (name, side) == ("stroke", "left") else 0.025
        np.testing.assert_allclose(strides.contact_s, truth.land_s[1:], atol=atol)
        length = np.linalg.norm(np.diff(truth.foothold_m[:, :2], axis=0), axis=1)
        np.testing.assert_allclose(strides.length_m, length, atol=0.012)
        assert np.abs((strides.length_m - length) / strides.length_sigma_m).max() < 3.0


def test_the_walk_ratio_is_step_length_over_step_rate():
    for name in ("placement", "stroke"):
        walk, feet = walked(name)
        ratio = summarise(feet).both["walk_ratio"]
        length_m, stride_s = [], []
        for side, strides in feet.items():
            truth = walk.truth.feet[side]
            use = steady(strides)
            length_m += np.linalg.norm(np.diff(truth.foothold_m[:, :2], axis=0), axis=1)[use].tolist()
            stride_s += np.diff(truth.land_s)[use].tolist()
        exact = np.mean(0.5 * np.array(length_m) * 0.5 * np.array(stride_s))
        assert ratio.unit == "m s"
        assert ratio.count == len(length_m)
        assert abs(ratio.value - exact) < 2.0 * ratio.sigma + 0.005
    assert "walk_ratio" not in summarise({"left": feet["left"]}).both


def test_the_paretic_foot_shows():
    summary = summarise(walked("stroke")[1])
    left, right = summary.feet["left"], summary.feet["right"]
    assert np.rad2deg(left["toe_out"].value) == pytest.approx(25.0, abs=6.0)
    assert np.rad2deg(right["toe_out"].value) == pytest.approx(10.0, abs=4.0)
    assert left["circumduction"].value > right["circumduction"].value + 0.02
    assert left["contact_pitch"].value < right["contact_pitch"].value - np.deg2rad(10.0)
    assert left["stance_share"].value < right["stance_share"].value
    assert summary.asymmetry["swing_time"].value > 3.0 * summary.asymmetry["swing_time"].sigma


def test_a_healthy_walk_in_numbers():
    walk, feet = walked("placement")
    summary = summarise(feet)
    style = walk.truth
    for side in ("left", "right"):
        foot = summary.feet[side]
        assert foot["stride_time"].value == pytest.approx(1.15, abs=0.01)
        assert foot["cadence"].value == pytest.approx(120 / 1.15, rel=0.01)
        assert foot["stance_share"].value == pytest.approx(0.62, abs=0.03)
        assert foot["speed"].value == pytest.approx(foot["stride_length"].value / 1.15, rel=0.01)
        assert foot["stride_length"].count == steady(feet[side]).sum() == feet[side].count - 2
        assert np.isfinite(foot["stride_length"].sigma)
        assert foot["lateral_placement"].count >= 3
        assert len(summary.initiation_length_m[side]) == len(summary.termination_length_m[side]) == 1
    assert summary.both["double_support"].value == pytest.approx(0.12 * 1.15, abs=0.04)
    assert abs(summary.asymmetry["stride_length"].value) < 0.05
    assert summary.turn_count == 0
    assert summary.bout_count == 1
    assert summary.reasons == ()
    assert style.step_side


def test_turns_are_counted():
    walk = foot_walk(strides=8, turn_rad=0.35, noise=1.0)
    strides = find_strides(smooth(walk.signals), "left")
    (one,) = turns(strides)
    assert one[2] == pytest.approx(8 * 0.35, abs=0.05)
    assert not steady(strides).any() or np.abs(strides.turn_rad[steady(strides)]).max() < 0.35


def test_mirroring_the_foot_mirrors_the_result():
    walk = foot_walk(strides=5, turn_rad=0.1, noise=1.0, mounting=[0.0, 0.2, 0.0])
    s = walk.signals
    mirrored = SensorSignals(s.time_s, s.gyroscope_radps * [-1, 1, -1], s.accelerometer_mps2 * [1, -1, 1])
    one, other = find_strides(smooth(s), "left"), find_strides(smooth(mirrored), "right")
    np.testing.assert_allclose(one.length_m, other.length_m, atol=1e-9)
    np.testing.assert_allclose(one.turn_rad, -other.turn_rad, atol=1e-9)
    np.testing.assert_allclose(one.toe_out_rad, other.toe_out_rad, atol=1e-7)
    np.testing.assert_allclose(one.circumduction_m, other.circumduction_m, atol=1e-9)


def test_bouts_are_parted_by_standing():
    one = foot_walk(strides=4, noise=1.0, rest_s=1.5).signals
    count = len(one.time_s)
    both = SensorSignals(
        np.arange(2 * count) / 100.0,
        np.concatenate([one.gyroscope_radps] * 2),
        np.concatenate([one.accelerometer_mps2] * 2),
    )
    strides = find_strides(smooth(both), "left")
    assert strides.bout.tolist() == [0] * 4 + [1] * 4
    assert np.flatnonzero(strides.is_initiation).tolist() == [0, 4]
    assert np.flatnonzero(strides.is_termination).tolist() == [3, 7]
    assert np.isnan(strides.duration_s[[0, 4]]).all()


def test_standing_still_has_no_strides_and_says_so():
    still = foot_walk(strides=1, length_m=0.0, lift_m=0.0, roll_rad=0.0, noise=1.0, rest_s=3.0)
    strides = find_strides(smooth(still.signals), "left")
    assert strides.count == 0
    summary = summarise({"left": strides})
    assert "walk.no_stride" in codes(summary.reasons)
    assert summary.feet["left"]["stride_length"].count == 0


def test_force_events():
    rate = 100.0
    time = np.arange(400) / rate
    phase = (time - 0.4) % 1.2
    inside = (time >= 0.4) & (phase < 0.7)
    heel = np.where(inside & (phase < 0.45), 500.0 * np.sin(np.pi * phase / 0.45), 0.0)
    fore = np.where(inside & (phase > 0.1), 500.0 * np.sin(np.pi * (phase - 0.1) / 0.6), 0.0)
    heel[30:32] = 60.0  # a spark of 20 ms
    heel[60] = 0.0  # a dropped sample
    events = force_events(heel, fore, rate)
    starts = 0.4 + 1.2 * np.arange(3)
    np.testing.assert_allclose(events.heel_down_s, starts, atol=0.021)
    np.testing.assert_allclose(events.contact_s, starts, atol=0.021)
    np.testing.assert_allclose(events.heel_off_s, starts + 0.45, atol=0.021)
    np.testing.assert_allclose(events.toe_off_s, starts + 0.7, atol=0.021)
    assert events.flat_core_s.shape == (3, 2)
    np.testing.assert_allclose(events.flat_core_s.mean(axis=1), starts + 0.275, atol=0.03)
    whole = force_events(heel + fore, None, rate)
    np.testing.assert_allclose(whole.contact_s, events.contact_s, atol=0.011)
    with pytest.raises(ShapeError, match="finite"):
        force_events(np.full(10, np.nan), None, rate)
    with pytest.raises(ShapeError, match="both must be"):
        force_events(heel, fore[:-1], rate)
