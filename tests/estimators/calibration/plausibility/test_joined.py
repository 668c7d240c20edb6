"""Stretches joined one after the other read as one, and what a live session hands on with each look stays small."""

import pickle
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from estimators.calibration import RecordingCheck
from estimators.calibration.plausibility.contradiction import slowed, slowed_by
from estimators.calibration.plausibility.joined import Joined
from tests.estimators.calibration.test_recording_check import ARM, codes, simulated


@pytest.mark.parametrize("rate_hz", [25.0, 60.0, 74.0, 76.0, 100.0, 128.0, 200.0, 1000.0])
def test_stretches_of_any_length_read_as_one(rate_hz):
    step_s, readings = 1.0 / rate_hz, np.random.default_rng(3).normal(size=(3, round(40.0 * rate_hz), 3))
    joined, at, edges = Joined(), 0, np.cumsum([0, *np.random.default_rng(4).integers(3, 9, 5)])
    whole = np.stack([slowed(one, step_s)[0] for one in readings])
    for begun_s, end_s in pairwise(edges):
        stretch = readings[:, round(begun_s * rate_hz) : round(end_s * rate_hz)]
        part, slow_s = joined.add(stretch, step_s)
        assert slowed_by(slow_s) == 1, "means are not averaged once more"
        at = round(end_s * rate_hz) // slowed_by(step_s)
        np.testing.assert_allclose(part, whole[:, at - part.shape[1] : at], atol=1e-6)
        # Four seconds of the one before, as windows of six seconds begin every two.
        before = round(begun_s * rate_hz) // slowed_by(step_s)
        assert part.shape[1] == min(round(4.0 / slow_s), before) + at - before
    joined.forget()
    part, _ = joined.add(readings[:, : round(4.0 * rate_hz)], step_s)
    np.testing.assert_array_equal(part, whole[:, : part.shape[1]])


def test_what_a_live_session_hands_on_is_small():
    """It goes to another process and back with each look: 31 to 80 kB a sensor before it was held in little room."""
    sound, check, sizes = simulated(), RecordingCheck(ARM), []
    rng = np.random.default_rng(4)
    for number in range(16):
        # Peaks of the same size would look like the end of the range and are held for it.
        rate = sound.gyroscope_radps * rng.uniform(0.8, 1.0)
        check.add(replace(sound, gyroscope_radps=rate, first_tick=number * sound.tick_count))
        sizes.append(len(pickle.dumps(check)) / len(ARM))
    assert max(sizes) < 48e3, "while it is gathered what an accelerometer's errors are judged by, once"
    assert max(sizes[9:]) < 22e3


def test_a_gyroscope_that_misses_samples_does_not_stand_still_there():
    """Half a second in every five: the sensor turned meanwhile."""
    sound = simulated(exercise="flexion")
    rate = sound.gyroscope_radps.copy()
    for first in (300, 450, 600, 750):
        rate[1, first : first + 50] = np.nan
    assert codes(replace(sound, gyroscope_radps=rate)) == []
