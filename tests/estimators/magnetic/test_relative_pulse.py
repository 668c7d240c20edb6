"""The value of a pulse: what noise and offset of the gyroscope do to it, and that old quiet samples weigh less."""

import numpy as np
import pytest

from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative import pulse as pulses
from estimators.magnetic.relative.parameters import read, to_settings

STEP_S, LENGTH, QUIET = 1.0 / 120.0, 7, 24
AMBIENT = np.array([1.9e-5, 1.0e-5, -4.3e-5])
COIL = np.array([2.0e-7, -1.0e-7, 3.0e-7])
SETTINGS = to_settings(
    read({"rate_sigma_radps": 0.01, "baseline_samples": QUIET, "pulse_s": 0.06}), STEP_S, 3
)


def seen(rate_radps, field_noise=0.0, bias_radps=0.0, most_off=QUIET):
    """Return the pulse that a sensor at rest sees, where its gyroscope says `rate_radps`, shape (K, 3)."""
    ring = np.zeros((at.RING, at.RING_COLUMNS))
    count = len(rate_radps)
    ring[:count, at.GYROSCOPE : at.GYROSCOPE + 3] = rate_radps
    ring[:count, at.FIELD : at.FIELD + 3] = AMBIENT + field_noise
    ring[count - LENGTH : count, at.FIELD : at.FIELD + 3] += COIL
    ring[count - LENGTH : count, at.COIL], ring[count - LENGTH : count, at.CURRENT] = 1.0, 1.5
    ring[:, at.KEPT_ATTITUDE] = 1.0
    nominal = np.zeros(at.NOMINAL)
    nominal[at.RATE_BIAS : at.RATE_BIAS + 3] = bias_radps
    out, path = np.zeros(12), np.zeros((at.PATH, at.PATH_COLUMNS))
    assert pulses.pulse_value(ring, count - 1, LENGTH, most_off, nominal, SETTINGS, out, path) == 0
    return out


def test_at_rest_the_pulse_is_the_coil():
    out = seen(np.zeros((60, 3)))
    np.testing.assert_allclose(out[:3], COIL, atol=1e-18)
    np.testing.assert_allclose(out[7:10], AMBIENT, atol=1e-18)
    assert out[4] == pytest.approx(1.5)


def test_an_offset_of_the_gyroscope_turns_the_ambient_field():
    """The lever that the update takes for it is the numeric derivative: d value / d bias = [ambient]x lever."""
    still, size = np.zeros((60, 3)), 1e-4
    lever = seen(still)[11]
    assert lever > 5 * STEP_S
    for axis in np.eye(3):
        numeric = (seen(still, bias_radps=size * axis)[:3] - seen(still, bias_radps=-size * axis)[:3]) / (
            2 * size
        )
        # Estimate minus truth of the signal is minus that of the offset.
        np.testing.assert_allclose(numeric, -lever * np.cross(axis, AMBIENT), atol=1e-10)


def test_noise_is_as_told_and_less_than_with_a_plain_mean():
    rng = np.random.default_rng(5)
    sigma, rate = SETTINGS[at.FIELD_SIGMA], SETTINGS[at.RATE_SIGMA]
    found = np.array(
        [seen(rng.normal(0.0, rate, (60, 3)), rng.normal(0.0, sigma, (60, 3)))[:3] for _ in range(2000)]
    )
    told = seen(np.zeros((60, 3)))
    across = told[10] * (AMBIENT @ AMBIENT * np.eye(3) - np.outer(AMBIENT, AMBIENT))
    expected = told[3] * np.eye(3) + across
    assert np.abs(np.cov(found.T) - expected).max() < 0.1 * np.trace(expected) / 3.0
    assert pulses.expected_variance(SETTINGS) == pytest.approx(np.trace(expected) / 3.0, rel=0.05)
    # The quiet samples alone, their plain mean: white noise and a walk that grows with every sample.
    walk = 2.0 / 3.0 * (rate * STEP_S) ** 2 * (AMBIENT @ AMBIENT)
    near = (LENGTH - 1) // 2
    plain = [
        sigma**2 * (1 / (LENGTH - 2) + 1 / n) + walk * (near + sum((k / n) ** 2 for k in range(1, n)))
        for n in (5, 8, 16, QUIET)
    ]
    assert np.trace(expected) / 3.0 < min(plain)
