"""Time bases, gaps, synchronisation, the lower leg's mounting, gait cycles and peaks."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import CalibrationError, SetupError, ShapeError
from estimators.kinetics import analyse_shoe, force_peaks
from estimators.kinetics.published import (
    fill_gaps,
    lag_s,
    on_one_time_base,
    over_cycles,
    rms_difference,
    shank_mounting,
)
from estimators.recording import Recording
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait


def test_fast_load_cells_and_slow_inertial_sensors_meet_on_one_time_base():
    scenario = replace(gait_preset("ankle"), errors="ideal", course=(Bout((Leg(4),), 2.0),))
    fast = simulate_gait(replace(scenario, rate_hz=500.0)).recording
    slow = simulate_gait(scenario)
    names = ("heel_left", "forefoot_left")
    mixed = Recording({names[0]: fast.sensors[names[0]], names[1]: slow.recording.sensors[names[1]]}, 50.0)
    even = on_one_time_base(mixed, names, 50.0)
    assert np.array_equal(even[names[0]].time_s, even[names[1]].time_s)
    found = analyse_shoe(even[names[0]], even[names[1]])
    both = analyse_shoe(*(slow.recording.sensors[name] for name in names))
    count = min(len(found.reaction.force_n), len(both.reaction.force_n))
    error = found.reaction.force_n[:count] - both.reaction.force_n[:count]
    # The 15 Hz filter once more takes some of the fastest loading.
    assert np.sqrt(np.mean(error**2)) < 0.01 * 68.0 * 9.81
    with pytest.raises(SetupError, match="no sensor hand_left"):
        on_one_time_base(mixed, ("hand_left",), 50.0)


def test_short_gaps_are_filled_and_long_ones_stay():
    time = np.arange(200) / 50.0
    values = np.column_stack((np.sin(3 * time), np.cos(2 * time)))
    broken = values.copy()
    broken[40:50], broken[100:130], broken[:3] = np.nan, np.nan, np.nan
    found, filled = fill_gaps(broken)
    np.testing.assert_allclose(found[40:50], values[40:50], atol=1e-3)
    assert np.flatnonzero(filled).tolist() == list(range(40, 50))
    assert np.isnan(found[100:130]).all()
    assert np.isnan(found[:3]).all()
    with pytest.raises(ShapeError, match="four"):
        fill_gaps(np.full((10, 2), np.nan))


@pytest.mark.parametrize("late_s", [0.0, 0.37, -0.7334, 1.111])
def test_lag_is_found_to_a_part_of_a_sample(late_s):
    rng = np.random.default_rng(3)
    phases, rates = rng.uniform(0, 6, 12), rng.uniform(0.3, 4.0, 12)
    time = np.arange(1500) / 50.0
    signal = lambda t: sum(np.sin(2 * np.pi * f * t + p) for f, p in zip(rates, phases, strict=True))  # noqa: E731
    window = np.hanning(1500)
    # A parabola through three samples 20 ms apart is good to a tenth of them.
    assert lag_s(window * signal(time), window * signal(time - late_s), 50.0) == pytest.approx(
        late_s, abs=0.01
    )
    with pytest.raises(ShapeError, match="changes"):
        lag_s(np.ones(100), np.ones(100), 50.0)


def test_mounting_of_the_lower_leg_comes_back():
    rng = np.random.default_rng(4)
    q = rotation.exp(rng.normal(size=3))
    back = rotation.conjugate(q)
    standing = rotation.rotate(back, np.array([0.0, 0.0, 9.81])) + 0.02 * rng.normal(size=(200, 3))
    time = np.arange(500) / 100.0
    angle_rate = 1.5 * np.sin(2 * np.pi * 0.4 * time)
    bending = rotation.rotate(back, np.outer(angle_rate, [0.0, 1.0, 0.0])) + 0.01 * rng.normal(size=(500, 3))
    found = shank_mounting(standing, bending)
    # Means of 200 and 500 noisy samples: well below half a degree.
    assert rotation.angle_between(found, q) < np.radians(0.5)
    with pytest.raises(CalibrationError, match="hardly moved"):
        shank_mounting(standing, 0.01 * bending)
    with pytest.raises(CalibrationError, match="more than one axis"):
        shank_mounting(standing, rng.normal(size=(500, 3)))
    twist = rotation.rotate(back, np.outer(angle_rate, [0.0, 0.0, 1.0]))
    with pytest.raises(CalibrationError, match="long axis"):
        shank_mounting(standing, twist)


def test_cycles_have_mean_and_band():
    time = np.arange(1000) / 100.0
    values = np.sin(2 * np.pi * time / 1.25)
    found = over_cycles(values, np.array([0, 125, 250, 375]), 100.0)
    assert found.cycles.shape == (3, 101)
    np.testing.assert_allclose(found.mean, np.sin(2 * np.pi * np.linspace(0, 1, 101)), atol=1e-3)
    np.testing.assert_allclose(found.sd, 0.0, atol=1e-9)
    np.testing.assert_allclose(found.duration_s, 1.25)
    assert over_cycles(np.column_stack((values, values)), np.array([0, 125]), 100.0).cycles.shape == (
        1,
        101,
        2,
    )
    with pytest.raises(ShapeError, match="two landings"):
        over_cycles(values, np.array([3]), 100.0)


def test_peaks_of_the_m_and_of_a_single_hump():
    u = np.linspace(0.0, 1.0, 80)
    double = 700.0 * (np.sin(np.pi * u) + 0.35 * np.sin(3 * np.pi * u))
    found = force_peaks(double, 700.0)
    assert found.is_double
    assert found.loading == pytest.approx(found.push_off, rel=1e-9)
    assert found.valley < found.loading
    single = force_peaks(700.0 * np.sin(np.pi * u), 700.0)
    assert not single.is_double
    assert single.loading == pytest.approx(1.0, abs=1e-3)
    assert np.isnan(single.push_off)
    with pytest.raises(ShapeError, match="five"):
        force_peaks(double[:3], 700.0)


def test_difference_is_absolute_and_of_the_largest():
    reference = np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 10.0], [np.nan, 0.0, 0.0]])
    assert rms_difference(1.1 * reference, reference) == pytest.approx(
        (np.sqrt((0.25 + 1.0) / 2), np.sqrt(0.625) * 10)
    )
    with pytest.raises(ShapeError, match="compared"):
        rms_difference(reference, reference[:1])
