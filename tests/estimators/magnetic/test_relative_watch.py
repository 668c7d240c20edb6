"""What the relative-pose filter watches: the earth's field of the standstill, with samples missing, and gaps."""

import numpy as np
import pytest

from estimators.magnetic import RelativePoseParameters
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.parameters import to_settings
from estimators.magnetic.relative.watch import GAP, calibrate, tell

FIELD = np.array([1.5e-5, 0.0, -4.5e-5])


def standing(settings: np.ndarray, missing: list[int]) -> np.ndarray:
    """Return the memory after a standstill in which the magnetometer gave nothing at some samples."""
    sample, nominal = np.zeros(at.SAMPLE), np.zeros(at.NOMINAL)
    sample[at.ACCELEROMETER + 2] = sample[at.SOURCE_ACCELEROMETER + 2] = 9.81
    memory, counters = np.zeros(at.MEMORY), np.zeros(at.COUNTERS, dtype=np.int64)
    for k in range(int(settings[at.CALIBRATE_TICKS])):
        sample[at.FIELD : at.FIELD + 3] = np.nan if k in missing else FIELD
        calibrate(sample, settings, nominal, memory, counters)
    return memory


@pytest.mark.parametrize("missing", [[], [50], [0, 1, 2], [0, 7, 8, 9, 100]])
def test_the_field_of_a_standstill_survives_missing_samples(missing):
    settings = to_settings(RelativePoseParameters(), 1.0 / 120.0, 3)
    memory = standing(settings, missing)
    assert memory[at.REFERENCE_NORM] == pytest.approx(np.linalg.norm(FIELD), rel=1e-12)
    assert memory[at.REFERENCE_DIP] == pytest.approx(np.arccos(FIELD[2] / np.linalg.norm(FIELD)), abs=1e-6)


def test_a_standstill_without_a_field_is_not_compared_with():
    settings = to_settings(RelativePoseParameters(), 1.0 / 120.0, 3)
    assert standing(settings, list(range(1000)))[at.REFERENCE_NORM] == 0.0


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_gap_of_any_axis_is_told(axis):
    settings = to_settings(RelativePoseParameters(), 1.0 / 120.0, 3)
    sample, counters = np.zeros(at.SAMPLE), np.zeros(at.COUNTERS, dtype=np.int64)
    covariance = np.zeros((at.ERRORS, at.ERRORS))
    assert not tell(sample, settings, counters, covariance) & GAP
    sample[at.GYROSCOPE + axis] = np.nan
    assert tell(sample, settings, counters, covariance) & GAP
