"""The stochastic measurement model against the method page (8.6, 8.9, 8.10) and numeric derivatives."""

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.magnetic import Coil, Source, perpendicular_source
from estimators.magnetic.published import (
    choose_coil,
    choose_current,
    noise_covariance,
    posterior_covariance,
    predict,
    update,
)

BENCH = Source((Coil(axis=(1.0, 0.0, 0.0)),))
POINT, Q = np.array([0.3, 0.1, 0.0]), np.array([1.0, 0.0, 0.0, 0.0])
P = 1e-4 * np.eye(6)
NOISE = noise_covariance(np.zeros(3), 1, 0)
THREE = Source(
    (
        Coil(axis=(1.0, 0.2, 0.0), centre_m=(0.06, 0.0, 0.0)),
        Coil(axis=(0.0, 1.0, -0.3), centre_m=(0.0, 0.06, 0.01)),
        Coil(axis=(0.1, 0.0, 1.0), centre_m=(0.0, 0.0, 0.06)),
    )
)


@pytest.mark.parametrize("coil", [0, 1, 2])
def test_the_jacobian_is_the_numeric_one(coil):
    rng = np.random.default_rng(coil)
    p, q = rng.uniform(0.2, 0.4, 3), rotation.normalize(rng.standard_normal(4))
    h = predict(THREE, coil, 1.3, p, q).jacobian
    numeric = np.empty((3, 6))
    for i in range(6):
        e = np.zeros(6)
        e[i] = 1e-5
        ahead, behind = (
            predict(
                THREE, coil, 1.3, p + s * e[:3], rotation.multiply(q, rotation.exp(s * e[3:]))
            ).field_sensor_t
            for s in (1, -1)
        )
        numeric[:, i] = (ahead - behind) / 2e-5
    scale = np.linalg.norm(numeric, axis=0)
    assert (np.linalg.norm(h - numeric, axis=0) / scale).max() < 1e-6
    # Without the turn of the coil it would be wrong (erratum X3): here each axis is tilted.
    assert not np.allclose(h[:, :3], predict(BENCH, 0, 1.3, p, q).jacobian[:, :3], rtol=0.1)


@pytest.mark.parametrize(
    ("sign", "passes", "percent"),
    [
        (1, 1, (10.8, 16.1, 12.3)),
        (-1, 1, (6.2, 24.1, 7.2)),
        (1, 5, (7.3, 23.1, 1.9)),
        (-1, 5, (7.0, 12.1, 18.9)),
    ],
)
def test_one_update_as_on_the_page(sign, passes, percent):
    error = np.array([0.01] * 3 + [sign * 0.01] * 3)
    measured = predict(BENCH, 0, 0.91, POINT, Q).field_sensor_t
    found = update(BENCH, 0, 0.91, POINT + error[:3], rotation.exp(error[3:]), P, measured, NOISE, passes)
    np.testing.assert_allclose(np.abs(found.position_m - POINT) / 1e-4, percent, atol=0.5)
    assert (np.abs(found.position_m - POINT) < np.sqrt(np.diag(found.covariance)[:3])).all()


def test_the_iterated_update_is_consistent():
    rng = np.random.default_rng(8)
    errors = rng.normal(0.0, 0.01, (1500, 6))
    measured = predict(BENCH, 0, 0.91, POINT, Q).field_sensor_t + rng.normal(0.0, 3e-8, (1500, 3))
    found = update(BENCH, 0, 0.91, POINT + errors[:, :3], rotation.exp(errors[:, 3:]), P, measured, NOISE)
    left = np.concatenate([found.position_m - POINT, rotation.log(found.q_source_sensor)], axis=1)
    solved = np.linalg.solve(found.covariance, left[..., None])[..., 0]
    assert 0.9 < np.mean(np.sum(left * solved, axis=1)) / 6.0 < 1.1
    assert 2.7 < found.nis.mean() < 3.3


def test_covariance_identities():
    h = predict(THREE, 0, 1.3, POINT, Q).jacobian
    after = posterior_covariance(P, h, NOISE)
    gain = P @ h.T @ np.linalg.inv(h @ P @ h.T + NOISE)
    np.testing.assert_allclose(after, (np.eye(6) - gain @ h) @ P, rtol=1e-9, atol=1e-15)
    assert np.linalg.eigvalsh(P - after).min() > -1e-15
    np.testing.assert_allclose(posterior_covariance(P, h, 1e6 * np.eye(3)), P, atol=1e-18)
    full = predict(THREE, 0, 1.3, POINT, Q).covariance(P, NOISE)
    np.testing.assert_allclose(full, h @ P @ h.T + NOISE)


def test_turning_everything_together_changes_nothing():
    rng = np.random.default_rng(3)
    turn = rotation.normalize(rng.standard_normal(4))
    turned = Source(
        tuple(
            Coil(
                centre_m=tuple(rotation.rotate(turn, coil.centre_m)),
                axis=tuple(rotation.rotate(turn, coil.axis)),
            )
            for coil in THREE.coils
        )
    )
    q = rotation.normalize(rng.standard_normal(4))
    a = predict(THREE, [0, 1, 2], 1.0, POINT, q).field_sensor_t
    b = predict(turned, [0, 1, 2], 1.0, rotation.rotate(turn, POINT), rotation.multiply(turn, q))
    np.testing.assert_allclose(b.field_sensor_t, a, rtol=1e-11)
    np.testing.assert_allclose(predict(THREE, [0, 1, 2], 1.0, POINT, -q).field_sensor_t, a, rtol=1e-14)


def test_the_coaxial_coil_is_chosen():
    source = perpendicular_source(0.06)
    prior = np.diag([4e-4] * 3 + [1.9e-3] * 3)
    coil, scores = choose_coil(
        source, 1.3, 0.4 * np.eye(3), np.tile(Q, (3, 1)), np.broadcast_to(prior, (3, 6, 6))
    )
    np.testing.assert_array_equal(coil, [0, 1, 2])
    np.testing.assert_array_equal(np.argmin(scores, axis=1), coil)


def test_the_least_current_that_does():
    for current, sigmas in ((0.1, (7.85, 8.92, 9.21)), (1.5, (1.20, 2.34, 2.61))):
        after = posterior_covariance(P, predict(BENCH, 0, current, POINT, Q).jacobian, NOISE)
        np.testing.assert_allclose(np.sqrt(np.diag(after)[:3]) * 1e3, sigmas, rtol=0.01)
    current, reason = choose_current(BENCH, 0, POINT, Q, P, 0.004, NOISE)
    after = posterior_covariance(P, predict(BENCH, 0, current, POINT, Q).jacobian, NOISE)
    assert reason == "target"
    assert np.sqrt(np.diag(after)[:3].max()) == pytest.approx(0.004, rel=1e-3)
    assert choose_current(BENCH, 0, POINT, Q, P, 1e-4, NOISE) == (1.5, "limit")
    assert choose_current(BENCH, 0, POINT, Q, P, 0.5, NOISE) == (0.01, "least")
    needed, reason = choose_current(BENCH, 0, POINT, Q, P, 0.5, NOISE, signal_to_noise=20.0)
    seen = predict(BENCH, 0, needed, POINT, Q).field_sensor_t
    assert reason == "signal"
    assert np.linalg.norm(seen) / 3e-8 == pytest.approx(20.0, rel=1e-6)


def test_noise_of_the_two_means():
    found = noise_covariance(np.zeros(3), 8, 88)
    np.testing.assert_allclose(np.sqrt(np.diag(found)), 0.111e-7, rtol=0.01)
    grown = noise_covariance(np.array([1e-5, 0, 0]), 8, 88)
    assert np.sqrt(grown[0, 0] - found[0, 0]) == pytest.approx(2e-8, rel=1e-6)


def test_bad_input_is_named():
    with pytest.raises(SetupError):
        noise_covariance(np.zeros(3), 0, 5)
    with pytest.raises(SetupError, match="passes"):
        update(BENCH, 0, 1.0, POINT, Q, P, np.zeros(3), NOISE, passes=0)
    with pytest.raises(ShapeError):
        update(BENCH, 0, 1.0, POINT, Q, P, np.zeros(2), NOISE)
    with pytest.raises(SetupError):
        choose_current(BENCH, 0, POINT, Q, P, 0.0, NOISE)
