"""Each measure against its closed form and in its undefined cases."""

import numpy as np
import pytest

from estimators.comparison.measures import (
    interjoint_coordination,
    log_dimensionless_jerk,
    multiple_correlation,
    outward_stroke,
    superimpose,
    symmetry_angle,
    symmetry_ratio,
    time_to_peak_speed,
    units_per_metre,
)
from estimators.errors import ShapeError
from estimators.rotation import about_x, about_z, multiply, rotate

RATE_HZ = 1000.0
SHARE = np.linspace(0.0, 1.0, 1001)
BELL = 30.0 * SHARE**2 * (1.0 - SHARE) ** 2
STEP = SHARE**3 * (10.0 - 15.0 * SHARE + 6.0 * SHARE**2)
TWO_BELLS = np.concatenate([BELL[:-1:2], BELL[::2]])


def test_jerk_of_one_and_two_minimum_jerk_strokes():
    # -ln(720 / 1.875^2) and -ln(16 times that); differences over a millisecond leave less than 0.01.
    assert log_dimensionless_jerk(BELL, RATE_HZ, None) == pytest.approx(-5.322, abs=0.01)
    assert log_dimensionless_jerk(TWO_BELLS, RATE_HZ, None) == pytest.approx(-8.095, abs=0.02)


def test_jerk_does_not_know_size_duration_or_direction():
    one = log_dimensionless_jerk(BELL, RATE_HZ, None)
    assert log_dimensionless_jerk(3.0 * BELL, RATE_HZ, None) == pytest.approx(one)
    assert log_dimensionless_jerk(BELL, 0.5 * RATE_HZ, None) == pytest.approx(one)
    along = np.outer(BELL, [0.6, 0.0, 0.8])
    assert log_dimensionless_jerk(along, RATE_HZ, None) == pytest.approx(one)


def test_jerk_of_a_noisy_stroke_needs_its_filter():
    noisy = BELL[::10] + np.random.default_rng(1).normal(0.0, 0.02, 101)
    assert log_dimensionless_jerk(noisy, 100.0, None) < -8.0
    assert log_dimensionless_jerk(noisy, 100.0) == pytest.approx(-5.322, abs=0.8)


def test_jerk_is_undefined_where_nothing_moves():
    assert np.isnan(log_dimensionless_jerk(np.zeros(500), RATE_HZ))
    assert np.isnan(log_dimensionless_jerk(BELL[:200], RATE_HZ))
    assert np.isnan(log_dimensionless_jerk(np.where(SHARE == 0.5, np.nan, BELL), RATE_HZ))


@pytest.mark.parametrize("count", [1, 2, 5])
def test_abutting_units_a_metre(count):
    way = np.concatenate([(number + STEP[:-1:2]) for number in range(count)]) * 0.3
    path = np.outer(way, [0.6, 0.8, 0.0])
    assert units_per_metre(path, 500.0, 0.55) == pytest.approx(count / (0.3 * count), rel=0.01)
    assert np.isnan(units_per_metre(0.1 * path / count, 500.0, 0.55))


def test_time_to_peak_speed():
    assert time_to_peak_speed(BELL) == pytest.approx(0.5, abs=1e-6)
    assert BELL.max() / BELL.mean() == pytest.approx(1.875, abs=0.003)
    # A quarter of the way up, three quarters down.
    skewed = np.concatenate([np.linspace(0, 1, 26)[:-1], np.linspace(1, 0, 76)])
    assert time_to_peak_speed(skewed) == pytest.approx(0.25, abs=0.01)
    assert np.isnan(time_to_peak_speed(SHARE))
    assert np.isnan(time_to_peak_speed(np.zeros(10)))


def test_outward_stroke_ends_where_it_arrives():
    there_and_back = np.concatenate([np.zeros(200), STEP, np.ones(300), STEP[::-1]])
    path = np.outer(there_and_back, [0.3, 0.0, 0.1])
    found = outward_stroke(path, RATE_HZ)
    # 5 % of the peak speed and 98 % of the way of a minimum-jerk step of a second.
    assert found.start == pytest.approx(200 + 60, abs=5)
    assert found.stop == pytest.approx(200 + 866, abs=5)
    assert outward_stroke(np.zeros((50, 3)), RATE_HZ) == slice(0, 0)


def test_coordination_of_two_sines_an_eighth_apart():
    time_s = np.arange(800) / 800.0
    first, second = np.sin(2 * np.pi * time_s), 0.4 * np.sin(2 * np.pi * time_s - np.pi / 4)
    found = interjoint_coordination(first, second, 800.0, 0.087)
    assert found is not None
    assert found.correlation == pytest.approx(np.sqrt(0.5), abs=1e-6)
    assert found.common_share == pytest.approx(0.8536, abs=1e-4)
    assert found.lag_s == pytest.approx(1.0 / 8.0, abs=0.002)
    back = interjoint_coordination(second, first, 800.0, 0.087)
    assert back is not None
    assert back.lag_s == pytest.approx(-1.0 / 8.0, abs=0.002)
    assert interjoint_coordination(first, 0.05 * second, 800.0, 0.087) is None
    with pytest.raises(ShapeError):
        interjoint_coordination(first, second[:-1], 800.0, 0.087)


def test_multiple_correlation_and_where_it_is_undefined():
    sine = np.sin(2 * np.pi * np.arange(100) / 100)
    near = multiple_correlation(np.stack([sine + 0.25, sine - 0.25]))
    assert near.value == pytest.approx(0.88255, abs=1e-5)
    far = multiple_correlation(np.stack([sine + 0.75, sine - 0.75]))
    assert not far.is_defined
    assert np.isnan(far.value)
    assert far.rms == pytest.approx(0.75)
    assert far.extent == pytest.approx(2.0)
    assert multiple_correlation(np.stack([sine, sine])).value == 1.0
    assert not multiple_correlation(np.ones((3, 100))).is_defined
    with pytest.raises(ShapeError):
        multiple_correlation(sine[None])


def test_superposition_takes_away_turn_and_scale():
    path = np.stack([STEP, np.sin(np.pi * SHARE), 0.2 * SHARE**2], axis=1)
    turn = multiply(about_z(np.radians(15.0)), about_x(0.0))
    found = superimpose(0.8 * rotate(turn, path) + 3.0, path)
    assert found.residual == pytest.approx(0.0, abs=1e-7)
    assert np.degrees(found.angle_rad) == pytest.approx(15.0, abs=1e-6)
    assert found.scale == pytest.approx(1.25)
    assert not found.is_straight
    bumpy = path + 0.01 * np.sign(np.sin(40.0 * SHARE))[:, None] * [0.0, 0.0, 1.0]
    assert superimpose(bumpy, path).residual == pytest.approx(0.01, rel=0.1)


def test_superposition_of_a_mirrored_path_is_no_mirror():
    path = np.stack([STEP, np.sin(np.pi * SHARE), np.sin(2.0 * np.pi * SHARE)], axis=1)
    assert superimpose(path * [1.0, 1.0, -1.0], path).residual > 0.3


def test_a_turn_about_a_straight_path_is_undefined():
    line = np.outer(STEP, [1.0, 0.0, 0.0])
    turned = rotate(about_z(np.radians(20.0)), line)
    found = superimpose(turned, line)
    assert found.is_straight
    assert np.degrees(found.angle_rad) == pytest.approx(20.0, abs=1e-6)
    with pytest.raises(ShapeError):
        superimpose(np.zeros((10, 3)), line[:10])


def test_symmetry():
    assert symmetry_ratio(40.0, 50.0) == pytest.approx(-0.2231, abs=1e-4)
    assert symmetry_angle(50.0, 40.0) == pytest.approx(-0.0704, abs=1e-4)
    assert symmetry_angle(40.0, 50.0) == pytest.approx(0.0704, abs=1e-4)
    for measure in (symmetry_ratio, symmetry_angle):
        assert measure(45.0, 45.0) == pytest.approx(0.0)
        assert np.isnan(measure(1.0, 50.0, 0.6))
        assert np.isnan(measure(-1.0, 50.0))
        assert np.isfinite(measure(1.3, 50.0, 0.6))
