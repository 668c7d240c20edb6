"""Bursts seconds apart: dead reckoning no longer tells on which side of the source the sensor is."""

import pytest

from validation.magnetic.checks import _whole_bursts


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4, 12))
def test_the_side_is_kept_when_dead_reckoning_is_lost(seed):
    smoothed, forward = _whole_bursts(seed, 2.4)
    # Forward it is lost by decimetres between bursts; on the wrong side both would be off by metres.
    assert smoothed < 20.0
    assert forward < 400.0
