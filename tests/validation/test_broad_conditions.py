"""What is done to a trial of BROAD before it is scored, and what its uncertainty is held against."""

import numpy as np
import pytest

from estimators import rotation
from estimators.orientation import OrientationResult
from estimators.recording import SampleQuality
from estimators.signals import to_common_ticks
from tests.validation.made_up import trial_at_rest
from validation import protocols
from validation.orientation import broad_conditions as conditions

RATE_HZ = 200.0


@pytest.fixture
def trial():
    return trial_at_rest(3, 4000, RATE_HZ, (8.0, 20.0))


@pytest.mark.parametrize("rest_s", [3.0, 0.0])
def test_a_trial_begins_with_the_rest_it_is_left(trial, rest_s):
    cut = conditions.started_before_movement(trial, rest_s)
    begin = round((8.0 - rest_s) * RATE_HZ)
    signals, whole = cut.sensors["imu"], trial.sensors["imu"]
    assert signals.time_s[0] == 0.0
    np.testing.assert_array_equal(signals.gyroscope_radps, whole.gyroscope_radps[begin:])
    np.testing.assert_array_equal(signals.magnetometer_t, whole.magnetometer_t[begin:])
    np.testing.assert_array_equal(np.flatnonzero(cut.reference["is_movement"])[0], round(rest_s * RATE_HZ))
    assert conditions.started_before_movement(trial, None) is trial


def test_bursts_are_as_long_and_as_many_as_said(trial):
    lossy = conditions.with_bursts_lost(trial, 1)
    time_s = lossy.sensors["imu"].time_s
    lost = 1.0 - time_s.size / 4000
    assert 0.035 <= lost <= 0.05  # bursts may overlap
    assert time_s[round(conditions._SOUND_START_S * RATE_HZ) - 1] == pytest.approx(0.995)
    chunk = to_common_ticks(lossy, RATE_HZ)
    assert chunk.tick_count == 4000
    assert ((chunk.quality[0] & int(SampleQuality.BRIDGED)) != 0).sum() == 4000 - time_s.size
    other = conditions.with_bursts_lost(trial, 2).sensors["imu"].time_s
    assert not np.array_equal(time_s, other)


@pytest.mark.parametrize(("error_sigmas", "expected"), [(0.0, 1.0), (2.7, 1.0), (2.9, 0.0)])
def test_inside_means_within_2_8_sigma(trial, monkeypatch, error_sigmas, expected):
    """Three normal errors leave the sphere of radius sqrt(7.815) = 2.80 sigma in one case of twenty."""

    class Stated:
        def __init__(self, *_):
            pass

        def update(self, chunk):
            shape = (1, chunk.tick_count)
            sigma = np.tile(np.array([0.01, 0.02, 0.05]), (*shape, 1))
            error = np.array([0.0, 0.0, error_sigmas * 0.05])
            q = np.broadcast_to(rotation.exp(error), (*shape, 4))
            return OrientationResult(q, np.zeros((*shape, 3)), sigma, np.zeros(shape, dtype=np.uint8))

    monkeypatch.setattr(conditions, "create", Stated)
    assert conditions.share_inside(trial, "stated") == expected


def test_every_figure_is_measured(trial):
    protocol = next(p for p in protocols() if p.name == "broad_conditions")
    values = protocol.measure(range(2), {"made up": trial})
    assert set(values) == {figure.name for figure in protocol.figures}
    assert values["Telemotion, no rest"][0] < 1.0
    assert len(values["VQF, samples lost"]) == 2
