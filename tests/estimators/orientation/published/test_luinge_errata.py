"""What the method page corrects in Luinge and Veltink's equations, sampled and differentiated."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2 as G
from estimators.kernels import turn
from estimators.recording import ImuChunk
from tests.estimators.orientation import strapdown_twins as twins
from tests.estimators.orientation.published.test_luinge_filter import DEG, UP, shaken


@pytest.mark.slow
def test_e3_cross_covariance_of_a_step():
    """E-2, E-3, E-5: sampled, cov(theta-, b-) is -T Q_b, and theta turns with the sensor."""
    rng = np.random.default_rng(8)
    step_s, rate = 0.01, np.array([3.0, -2.0, 4.0])
    theta, offset = 1e-3 * rng.normal(size=(200_000, 3)), 0.02 * rng.normal(size=(200_000, 3))
    truth = Rotation.from_rotvec([0.4, 1.0, -0.3])
    estimate = truth * Rotation.from_rotvec(theta)
    # The estimate turns by y - b_hat = rate - offset error.
    after = (truth * Rotation.from_rotvec(rate * step_s)).inv() * (
        estimate * Rotation.from_rotvec((rate - offset) * step_s)
    )
    found = after.as_rotvec()
    cross = found.T @ offset / len(offset)
    # Deviation of the sampled mean: 1e-3 x 0.02 / sqrt(200 000) = 5e-8.
    np.testing.assert_allclose(cross, -step_s * 0.02**2 * np.eye(3), atol=3e-7)
    turned_error = Rotation.from_rotvec(rate * step_s).inv().apply(theta) - step_s * offset
    assert np.abs(found - turned_error).max() < 4e-5  # second order: T theta x offset
    assert np.abs(found - (theta - step_s * offset)).mean() > 10 * np.abs(found - turned_error).mean()


def test_v12_turn_is_the_exponential_and_coning_is_corrected():
    rng = np.random.default_rng(2)
    for size in (1e-9, 1e-3, 0.1, 0.4999, 0.5001, 1.0, 3.0):
        vector = size * rotation.normalize(rng.normal(size=4) * [0, 1, 1, 1])[1:]
        np.testing.assert_allclose(turn(*vector), rotation.exp(vector), atol=3e-16)
    errors = {}
    for instantaneous in (False, True):
        rate_hz, seconds, angle = 100, 60, 20 * DEG
        time = np.arange(seconds * rate_hz + 1) / rate_hz
        q = coning(time, angle)
        if instantaneous:
            h = 1e-5
            rate = rotation.log(
                rotation.multiply(rotation.conjugate(coning(time - h, angle)), coning(time + h, angle))
            ) / (2 * h)
        else:
            rate = np.zeros((len(time), 3))
            rate[1:] = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:])) * rate_hz
        up = rotation.rotate(rotation.conjugate(q), G * UP)
        chunk = ImuChunk(0, 1 / rate_hz, rate[None], up[None], None, np.zeros((1, len(time)), dtype=np.uint8))
        result = orientation.create(
            "luinge_inclination",
            1,
            1 / rate_hz,
            {
                "instantaneous_rate": instantaneous,
                "start_samples": 1.0,
                "accelerometer_sigma_mps2": 1e12,
                "rest_update": False,
            },
        ).update(chunk)
        since = [rotation.multiply(rotation.conjugate(p[:1]), p) for p in (result.q_earth_sensor[0], q)]
        errors[instantaneous] = rotation.angle_between(*since).max() / DEG
    assert errors[False] <= 1e-6
    assert errors[True] <= 1.0


def coning(time, angle):
    """Half a turn's axis in the horizontal plane goes round once a second, the sensor with it."""
    axis = np.stack([np.cos(2 * np.pi * time), np.sin(2 * np.pi * time), 0 * time], axis=-1)
    return rotation.exp(angle * axis)


def test_without_correlation_both_forms_weigh_gravity_alike():
    """Check 4.4.6: with c_a = 0 the rows are the same, and so is R_v = (sigma_w^2 + sigma_A^2) / g^2."""
    chunk, _ = shaken(ticks=12)
    p = np.diag([(3 * DEG) ** 2] * 3 + [0.005**2] * 3)
    start = Rotation.from_rotvec([0.3, -0.8, 1.0])
    given = chunk.gyroscope_radps[0, 10:11], chunk.accelerometer_mps2[0, 10:11], 0.01, start, p
    r, b, _, _, s = twins.luinge_consistent(*given, c_a=0.0)[0]
    r_published, b_published, *_ = twins.luinge_published(*given, c_a=0.0)[0]
    assert s[0, 0] - (3 * DEG) ** 2 == pytest.approx((0.4**2 + 0.1**2) / G**2, rel=1e-3)
    # The published third row is harmless: the correction is the same to second order in the innovation.
    assert (r.inv() * r_published).magnitude() < 0.1 * (start.inv() * r).magnitude()
    np.testing.assert_allclose(b, b_published, atol=1e-4)
