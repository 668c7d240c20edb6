"""What stands in for the samples of a short gap."""

import numpy as np
import pytest

from estimators.recording import Recording, SampleQuality, SensorSignals
from estimators.signals import bridge, to_common_ticks

RATE_HZ = 100.0


def rate_of(time_s):
    return np.stack([np.sin(2 * np.pi * f * time_s + f) for f in (0.8, 1.3, 1.9)], axis=-1)


def with_hole(start, stop):
    time_s = np.arange(200) / RATE_HZ
    kept = np.ones(200, dtype=bool)
    kept[start:stop] = False
    time_s = time_s[kept]
    gravity = np.broadcast_to([0.0, 0.0, 9.81], (time_s.size, 3))
    return Recording({"imu": SensorSignals(time_s, rate_of(time_s), gravity, None)}, RATE_HZ)


@pytest.mark.parametrize("start", range(20, 180, 17))
def test_short_gap_follows_the_movement_better_than_its_chord(start):
    stop = start + 5
    chunk = to_common_ticks(with_hole(start, stop), RATE_HZ)
    assert (chunk.quality[0, start:stop] == int(SampleQuality.BRIDGED)).all()
    true = rate_of(np.arange(start, stop) / RATE_HZ)
    ends = rate_of(np.array([start - 1, stop]) / RATE_HZ)
    share = (np.arange(1, 6) / 6)[:, None]
    chord = ends[0] + share * (ends[1] - ends[0])
    found = chunk.gyroscope_radps[0, start:stop]
    # The angle that is lost is what counts.
    assert np.linalg.norm((found - true).sum(axis=0)) < 0.5 * np.linalg.norm((chord - true).sum(axis=0))


def test_long_gap_is_the_chord():
    chunk = to_common_ticks(with_hole(60, 78), RATE_HZ)
    ends = rate_of(np.array([59, 78]) / RATE_HZ)
    share = (np.arange(1, 19) / 19)[:, None]
    np.testing.assert_allclose(
        chunk.gyroscope_radps[0, 60:78], ends[0] + share * (ends[1] - ends[0]), atol=1e-12
    )


def test_straight_course_stays_straight_and_unknown_slopes_are_the_chord():
    start, end = np.array([1.0, -2.0]), np.array([4.0, 1.0])
    share = np.linspace(0.0, 1.0, 7)[:, None]
    straight = start + share * (end - start)
    for slope in ((end - start) / 6.0, np.full(2, np.nan)):
        np.testing.assert_allclose(bridge(start, slope, end, slope, 6.0, share, 0.05), straight, atol=1e-14)


def test_ends_and_slopes_are_kept():
    start, end, before, after = (np.array([v]) for v in (0.3, 1.1, 0.2, -0.1))
    share = np.array([[0.0], [1e-6], [1.0 - 1e-6], [1.0]])
    found = bridge(start, before, end, after, 5.0, share, 0.05)[:, 0]
    assert found[0] == start[0]
    assert found[3] == pytest.approx(end[0])
    assert (found[1] - found[0]) / 5e-6 == pytest.approx(before[0], abs=1e-4)
    assert (found[3] - found[2]) / 5e-6 == pytest.approx(after[0], abs=1e-4)
