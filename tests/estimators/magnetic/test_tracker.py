"""Closed forms, refinement, flags and pulses of the three-coil tracker (method page C5)."""

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.magnetic import (
    Coil,
    Source,
    TrackerFlag,
    bursts,
    extract_pulses,
    integrate_gyroscope,
    locate,
    perpendicular_source,
)
from estimators.magnetic.published import (
    MU0_TM_PER_A,
    closed_form,
    closed_form_published,
    dipole_covariance,
    find_pulses,
    predict,
)

DIPOLES, EXACT, APART = (
    perpendicular_source(model="dipole"),
    perpendicular_source(),
    perpendicular_source(0.06),
)


def poses(count, seed=0, low=0.1, high=0.8):
    rng = np.random.default_rng(seed)
    u = rng.normal(size=(count, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    return u * rng.uniform(low, high, (count, 1)), rotation.normalize(rng.normal(size=(count, 4)))


def pulses_of(source, p, q, current=1.5):
    return np.stack([predict(source, k, current, p, q).field_sensor_t for k in range(3)], axis=-2)


@pytest.mark.parametrize("solver", [closed_form, closed_form_published])
def test_closed_forms_are_exact_for_dipoles(solver):
    p, q = poses(500)
    found = solver(DIPOLES, np.swapaxes(pulses_of(DIPOLES, p, q), -1, -2), 1.5)
    side = np.sign(np.sum(found.position_m * p, axis=1))[:, None]
    np.testing.assert_allclose(found.position_m * side, p, atol=1e-12)
    assert rotation.angle_between(found.q_source_sensor, q).max() < 1e-6
    np.testing.assert_allclose(found.ratios, 1.0, rtol=1e-10)
    np.testing.assert_allclose(found.determinant, 1.0, rtol=1e-10)


def test_any_three_axes_and_gains():
    source = Source(
        (Coil(40.0, axis=(1, 0.3, 0)), Coil(60.0, axis=(0, 1, 0.2)), Coil(50.0, 0.06, axis=(0.1, 0, 1))),
        "dipole",
    )
    p, q = poses(50, 1)
    found = closed_form(source, np.swapaxes(pulses_of(source, p, q), -1, -2), 1.5)
    side = np.sign(np.sum(found.position_m * p, axis=1))[:, None]
    np.testing.assert_allclose(found.position_m * side, p, atol=1e-10)
    flat = Source(tuple(Coil(axis=(1.0, 0.1 * i, 0.0)) for i in range(3)))
    with pytest.raises(SetupError, match="span"):
        closed_form(flat, np.eye(3), 1.5)


def test_metamorphic_checks():
    p, q = poses(1, 2, 0.3, 0.4)
    pulses = pulses_of(DIPOLES, p, q)[0]
    base = closed_form(DIPOLES, pulses.T, 1.5)
    turned = rotation.exp([0.3, -0.2, 0.5])
    found = closed_form(DIPOLES, rotation.rotate(rotation.conjugate(turned), pulses).T, 1.5)
    np.testing.assert_allclose(found.position_m, base.position_m, atol=1e-12)
    assert (
        rotation.angle_between(found.q_source_sensor, rotation.multiply(base.q_source_sensor, turned)) < 1e-7
    )
    np.testing.assert_allclose(pulses_of(DIPOLES, -p, q)[0], pulses, rtol=1e-12)
    stronger = closed_form(DIPOLES, 2.0 * pulses.T, 1.5)
    ratio = np.linalg.norm(stronger.position_m) / np.linalg.norm(base.position_m)
    assert ratio == pytest.approx(2.0 ** (-1 / 3))


@pytest.mark.parametrize("source", [EXACT, APART])
def test_refinement_finds_the_exact_pose(source):
    for p, q in zip(*poses(12, 3, 0.2, 0.6), strict=True):
        fix = locate(source, [0, 1, 2], 1.5, pulses_of(source, p, q), 1e-9, direction=p)
        assert fix.flags == TrackerFlag.SOUND
        assert np.linalg.norm(fix.position_m - p) < 1e-6
        assert rotation.angle_between(fix.q_source_sensor, q) < 1e-5


def test_covariance_is_the_closed_form():
    p, q = np.array([0.2, 0.3, 0.25]), rotation.exp([0.4, -0.3, 0.8])
    from estimators.magnetic import TrackerLimits

    fix = locate(
        DIPOLES,
        [0, 1, 2],
        1.5,
        pulses_of(DIPOLES, p, q),
        1e-8,
        direction=p,
        limits=TrackerLimits(gain_sigma=0.0),
    )
    kappa = MU0_TM_PER_A / (4 * np.pi) * DIPOLES.coils[0].moment_m2 * 1.5
    expected = dipole_covariance(p, q, kappa, 1e-8)
    np.testing.assert_allclose(fix.covariance, expected, atol=1e-6 * np.abs(expected).max())
    k, r = kappa / np.linalg.norm(p) ** 3, np.linalg.norm(p)
    assert np.sqrt(np.trace(expected[:3, :3])) == pytest.approx(1.06 * r * 1e-8 / k, rel=0.01)
    assert np.sqrt(np.trace(expected[3:, 3:])) == pytest.approx(2.12 * 1e-8 / k, rel=0.01)


def test_motion_within_the_burst_is_compensated():
    p, q = poses(1, 5, 0.3, 0.4)
    p, q = p[0], q[0]
    moved = np.array([[-0.02, 0.01, 0.0], [-0.01, 0.005, 0.0], [0.0, 0.0, 0.0]])
    turned = rotation.exp([[0.1, 0.0, -0.05], [0.05, 0.0, 0.0], [0.0, 0.0, 0.0]])
    pulses = np.stack(
        [
            predict(EXACT, k, 1.5, p + moved[k], rotation.multiply(q, turned[k])).field_sensor_t
            for k in range(3)
        ]
    )
    plain = locate(EXACT, [0, 1, 2], 1.5, pulses, 1e-9, direction=p)
    fix = locate(EXACT, [0, 1, 2], 1.5, pulses, 1e-9, direction=p, moved_m=moved, q_turned=turned)
    assert np.linalg.norm(fix.position_m - p) < 1e-6 < 1e-3 < np.linalg.norm(plain.position_m - p)


def test_flags():
    p, q = np.array([0.1, 0.2, 0.3]), rotation.exp([0.2, 0.3, -0.4])
    pulses = pulses_of(EXACT, p, q)
    sound = locate(EXACT, [0, 1, 2], 1.5, pulses, 1e-8, direction=p)
    assert sound.usable
    assert locate(EXACT, [0, 1, 2], 1.5, pulses, 1e-8).flags & TrackerFlag.AMBIGUOUS
    assert not locate(EXACT, [0, 1, 2], 1.5, pulses, 1e-8, last_position_m=-p).flags
    last = locate(EXACT, [0, 1, 2], 1.5, pulses, 1e-8, last_position_m=-p)
    np.testing.assert_allclose(last.position_m, -p, atol=1e-3)
    assert not locate(APART, [0, 1, 2], 1.5, pulses_of(APART, p, q), 1e-8).flags
    exchanged = locate(EXACT, [0, 1, 2], 1.5, pulses[[1, 0, 2]], 1e-8, direction=p)
    assert exchanged.flags & TrackerFlag.WRONG_ORDER
    assert not exchanged.usable
    assert (
        locate(EXACT, [0, 1, 2], 1.5, pulses, 1e-8, direction=p, saturated=True).flags & TrackerFlag.SATURATED
    )
    far = pulses_of(EXACT, 4 * p, q) + np.random.default_rng(0).normal(0, 5e-8, (3, 3))
    assert locate(EXACT, [0, 1, 2], 1.5, far, 5e-8, direction=p).flags & TrackerFlag.OUT_OF_RANGE
    bent = pulses * np.array([[1.3], [1.0], [1.0]])
    assert locate(EXACT, [0, 1, 2], 1.5, bent, 1e-8, direction=p).flags & TrackerFlag.DISTURBED
    broken = locate(EXACT, [0, 1, 2], 1.5, np.full((3, 3), np.nan), 1e-8)
    assert broken.flags & TrackerFlag.NO_SOLUTION
    assert np.isnan(broken.position_m).all()
    with pytest.raises(ShapeError):
        locate(EXACT, [0, 1], 1.5, pulses[:2], 1e-8)
    with pytest.raises(ShapeError, match="first three"):
        locate(EXACT, [0, 1, 1], 1.5, pulses, 1e-8)


def turning_sensor(rate, noise=0.0):
    """A sensor that turns evenly in the earth's field while three pulses pass."""
    t = np.arange(200) / 120.0
    q = rotation.exp(t[:, None] * np.asarray(rate))
    state = np.zeros(200, dtype=np.int64)
    state[60:67], state[68:75], state[75:82] = 1, 2, 3
    earth = rotation.rotate(rotation.conjugate(q), [2e-5, 0.0, -4.5e-5])
    pulses = np.array([[1e-6, 2e-6, 0.0], [0.0, -1e-6, 1e-6], [2e-6, 0.0, 1e-6]])
    added = np.where(state[:, None] > 0, pulses[np.maximum(state - 1, 0)], 0.0)
    rng = np.random.default_rng(0)
    return earth + added + rng.normal(0.0, noise, (200, 3)) if noise else earth + added, q, state, pulses, t


def test_pulses_of_a_turning_sensor():
    rate = np.array([0.6, -0.5, 0.7])
    field, q, state, pulses, _ = turning_sensor(rate)
    attitude = integrate_gyroscope(np.tile(rate, (200, 1)), 1 / 120.0)
    assert rotation.angle_between(attitude, q).max() < 1e-9
    found = extract_pulses(field, state, 1.5, attitude)
    assert [pulse.coil for pulse in found] == [0, 1, 2]
    plain = extract_pulses(field, state, 1.5, None)
    for pulse, without, truth in zip(found, plain, pulses, strict=True):
        # The pulse itself is fixed to the sensor here, so only its mean over a small turn is lost.
        assert np.linalg.norm(pulse.field_sensor_t - truth) < 2e-8
        assert np.linalg.norm(without.field_sensor_t - truth) > 1e-6 or pulse.coil == 1
        assert pulse.covariance[0, 0] == pytest.approx(9e-16 * (1 / 5 + 1 / 17), rel=0.2)
    assert len(bursts(found)) == 1
    assert bursts(found[:2]) == []


def test_saturation_constant_fields_and_edges():
    field, _, state, pulses, _ = turning_sensor(np.zeros(3), noise=1e-9)
    shifted = extract_pulses(field + np.array([1e-5, 2e-5, 3e-5]), state, 1.5, None)
    for pulse, truth in zip(shifted, pulses, strict=True):
        np.testing.assert_allclose(pulse.field_sensor_t, truth, atol=5e-9)
        assert not pulse.saturated
    assert all(pulse.saturated for pulse in extract_pulses(field, state, 1.5, None, full_scale_t=4e-5))
    single = np.zeros(200, dtype=np.int64)
    single[60:67] = 1
    alone = np.where(single[:, None] > 0, pulses[0], 0.0) + np.random.default_rng(1).normal(0, 3e-8, (200, 3))
    np.testing.assert_array_equal(find_pulses(alone, 7), [[60, 67]])
    with pytest.raises(ShapeError):
        extract_pulses(field, state[:10], 1.5, None)
    with pytest.raises(SetupError):
        extract_pulses(field, state, 1.5, None, before=0, after=0)
