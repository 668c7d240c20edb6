"""Faults do what they say, no more, and the same each time."""

import numpy as np
import pytest

from estimators.errors import SetupError
from estimators.simulation import ArmScenario, Schedule, faults, simulate_arm
from estimators.simulation._sensors import dipole_field


@pytest.fixture(scope="module")
def recording():
    return simulate_arm(ArmScenario(schedule=Schedule(n_pose_s=1.0, repetitions=1))).recording


def test_burst_loss_has_the_asked_share_and_burst_length():
    lost = faults.burst_loss(200_000, 0.05, 4.0, seed=1)
    # 2500 bursts of geometric length (SD about 3.5): standard error of the share 2.5 %, of the mean 2 %.
    assert lost.mean() == pytest.approx(0.05, rel=0.12)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], lost.astype(int), [0]))))
    assert (edges[1::2] - edges[::2]).mean() == pytest.approx(4.0, rel=0.1)
    np.testing.assert_array_equal(lost, faults.burst_loss(200_000, 0.05, 4.0, seed=1))
    assert not faults.burst_loss(100, 0.0, 4.0, seed=1).any()


def test_plan_delivers_every_packet_that_was_not_lost_in_an_order_a_link_can_have():
    wanted = faults.LinkFaults(
        loss_fraction=0.05, duplicate_fraction=0.03, reorder_fraction=0.04, reorder_depth=3, jitter_sd_s=0.01,
        break_count=2, break_s=5.0, clock_skew_ppm=40.0, clock_offset_s=3.0,
    )  # fmt: skip
    plan = faults.plan_delivery(12_000, 0.05, wanted, seed=2)
    assert set(plan.packet) == set(np.flatnonzero(~plan.is_lost))
    counts = np.bincount(plan.packet, minlength=12_000)
    assert counts.max() == 2
    assert (counts == 2).mean() == pytest.approx(0.03 * 0.95, rel=0.3)
    assert (np.diff(plan.send_s) >= 0).all()
    assert (plan.send_s >= (plan.packet + 1) * 0.05 - 1e-9).all()
    assert (np.diff(plan.packet) < 0).any()
    rank = np.cumsum(~plan.is_lost)[plan.packet]
    assert 1 <= (np.maximum.accumulate(rank) - rank).max() <= wanted.reorder_depth
    assert plan.breaks_s.shape == (2, 2)
    for start, end in plan.breaks_s:
        assert end - start == pytest.approx(5.0)
        assert not ((plan.send_s >= start) & (plan.send_s < end)).any()
    np.testing.assert_allclose(plan.device_time_s, 0.05 * np.arange(12_000) * 1.00004 + 3.0)


def test_a_perfect_link_delivers_everything_once_in_order_at_once():
    plan = faults.plan_delivery(500, 0.05, faults.LinkFaults(), seed=3)
    np.testing.assert_array_equal(plan.packet, np.arange(500))
    np.testing.assert_allclose(plan.send_s, 0.05 * np.arange(1, 501))
    assert not plan.is_lost.any()


def test_signal_faults_touch_one_sensor_and_leave_the_original_alone(recording):
    name = "forearm_right"
    before = recording.sensors[name].gyroscope_radps.copy()
    clipped = faults.saturate(recording, name, gyroscope_radps=0.5)
    assert np.abs(clipped.sensors[name].gyroscope_radps).max() == 0.5
    np.testing.assert_array_equal(recording.sensors[name].gyroscope_radps, before)
    assert clipped.sensors["sternum"] is recording.sensors["sternum"]
    stamps = recording.sensors[name].time_s
    silent = faults.kill_sensor(recording, name, 2.0, 3.0)
    np.testing.assert_array_equal(silent.sensors[name].time_s, stamps[(stamps < 2.0) | (stamps >= 3.0)])
    stuck = faults.kill_sensor(recording, name, 2.0, 3.0, mode="stuck").sensors[name]
    dead = (stamps >= 2.0) & (stamps < 3.0)
    assert np.ptp(stuck.gyroscope_radps[dead], axis=0).max() == 0.0
    zero = faults.kill_sensor(recording, name, 2.0, mode="zero").sensors[name]
    assert not zero.magnetometer_t[stamps >= 2.0].any()
    skewed = faults.skew_stamps(recording, name, 100.0, 0.5).sensors[name]
    np.testing.assert_allclose(skewed.time_s, stamps * 1.0001 + 0.5)
    shaken = faults.jitter_stamps(recording, name, 0.05, seed=4).sensors[name]
    assert (np.diff(shaken.time_s) > 0).all()
    assert np.abs(shaken.time_s - stamps).max() > 1e-3


def test_impossible_faults_are_refused_in_words(recording):
    with pytest.raises(SetupError, match="no sensor"):
        faults.saturate(recording, "tail", gyroscope_radps=1.0)
    with pytest.raises(SetupError, match="at least one"):
        faults.kill_sensor(recording, "sternum", 0.0)
    with pytest.raises(SetupError, match="fractions"):
        faults.LinkFaults(loss_fraction=1.0)
    with pytest.raises(SetupError, match="bursts"):
        faults.LinkFaults(mean_burst_packets=0.5)
    with pytest.raises(SetupError, match="breaks"):
        faults.link_breaks(10.0, 4, 3.0, seed=1)


def test_dipole_field_is_that_of_the_textbook():
    """On the axis mu0 m / (2 pi r^3), across it half of that and opposite; falls with the cube."""
    moment = (0.0, 0.0, 2.0)
    on_axis = dipole_field(moment, np.array([[0.0, 0.0, 0.3]]))[0]
    np.testing.assert_allclose(on_axis, [0, 0, 2e-7 * 2.0 / 0.3**3], rtol=1e-9, atol=1e-20)
    across = dipole_field(moment, np.array([[0.3, 0.0, 0.0]]))[0]
    np.testing.assert_allclose(across, -0.5 * on_axis, rtol=1e-9, atol=1e-20)
    np.testing.assert_allclose(
        dipole_field(moment, np.array([[0.6, 0.0, 0.0]]))[0], across / 8, rtol=1e-9, atol=1e-20
    )


def test_breaks_begin_after_what_must_not_be_broken():
    breaks = faults.link_breaks(60.0, 2, 3.0, seed=4, from_s=20.0)
    assert breaks[0, 0] > 20.0
    assert breaks[1, 0] > breaks[0, 1]
    assert breaks[1, 1] < 60.0
