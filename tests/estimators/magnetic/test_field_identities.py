"""Identities of coils, updates and the tracker to the last digit (method pages MM 8.10, C5 4.2 and 4.4)."""

import numpy as np
import pytest

from estimators import rotation
from estimators.magnetic import Coil, Source, perpendicular_source
from estimators.magnetic.published import (
    axial_dipole_error,
    biot_savart,
    choose_coil,
    closed_form,
    noise_covariance,
    posterior_covariance,
    predict,
    update,
)

LOOP, DIPOLE = Source((Coil(),)), Source((Coil(),), "dipole")
TILTED = Source((Coil(centre_m=(0.03, -0.02, 0.05), axis=(0.3, -0.8, 0.5)),))
BENCH = Source((Coil(axis=(1.0, 0.0, 0.0)),))
POINT, LEVEL = np.array([0.3, 0.1, 0.0]), rotation.identity()
P, NOISE = 1e-4 * np.eye(6), noise_covariance(np.zeros(3), 1, 0)


def size(vectors):
    return np.linalg.norm(vectors, axis=-1)


@pytest.mark.slow
def test_the_loop_is_its_wire_at_two_thousand_points():
    points = np.random.default_rng(17).uniform(-0.8, 0.8, (4000, 3))
    points = points[size(points) > 0.12][:2000]
    expected = biot_savart(Coil(), 1.0, points)
    assert (size(LOOP.field(0, 1.0, points) - expected) / size(expected)).max() <= 1e-9


@pytest.mark.parametrize(
    ("r_cm", "off_axis", "off_equator", "axis", "equator"),
    [
        (10, 48.7, 33.1, 95.90, -106.57),
        (15, 20.8, 15.0, 34.96, -24.83),
        (20, 11.6, 8.5, 15.97, -9.732),
        (30, 5.1, 3.8, 5.024, -2.743),
        (35, 3.7, 2.8, 3.205, -1.710),
        (40, 2.8, 2.1, 2.166, -1.138),
        (50, 1.8, 1.4, 1.120, -0.578),
        (70, 0.9, 0.7, 0.412, -0.209),
        (80, 0.7, 0.5, 0.276, -0.140),
    ],
)
def test_the_whole_table_of_the_thesis_coil(r_cm, off_axis, off_equator, axis, equator):
    places = [[0, 0, r_cm / 100.0], [r_cm / 100.0, 0, 0]]
    exact, dipole = (source.field(0, 1.5, places)[:, 2] for source in (LOOP, DIPOLE))
    np.testing.assert_allclose(1e6 * exact, [axis, equator], rtol=2e-3)
    # The loop is weaker than the dipole on the axis and stronger at the equator (E9).
    found = 100.0 * np.array([dipole[0] / exact[0] - 1.0, 1.0 - dipole[1] / exact[1]])
    np.testing.assert_allclose(found, [off_axis, off_equator], atol=0.06)


def test_on_the_axis():
    z = np.array([0.1, 0.2, 0.35, 0.8])
    places = np.stack([0 * z, 0 * z, z], axis=1)
    ratio = DIPOLE.field(0, 1.0, places)[:, 2] / LOOP.field(0, 1.0, places)[:, 2]
    np.testing.assert_allclose(ratio, (1 + (0.055 / z) ** 2) ** 1.5, rtol=1e-12)
    np.testing.assert_allclose([axial_dipole_error(0.055, r) for r in z], ratio - 1.0, rtol=1e-11)
    assert 1e7 * LOOP.field(0, 0.91, [0.0, 0.0, 0.0])[2] == pytest.approx(5197.9, abs=0.05)


def test_the_dipoles_error_falls_with_the_square_of_the_distance():
    r = np.array([0.4, 0.8, 1.6])
    for direction in ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]):
        places = r[:, None] * np.array(direction)
        a, b = LOOP.field(0, 1.0, places), DIPOLE.field(0, 1.0, places)
        error = size(a - b) / size(b)
        np.testing.assert_allclose(error[:-1] / error[1:], 4.0, atol=0.07)
        assert error[1] / error[2] == pytest.approx(4.0, abs=0.05)


def test_turned_about_its_axis():
    rng = np.random.default_rng(2)
    points, turn = rng.uniform(0.15, 0.5, (50, 3)), rotation.about_z(1.1)
    turned = LOOP.field(0, 1.0, rotation.rotate(turn, points))
    field = LOOP.field(0, 1.0, points)
    np.testing.assert_allclose(turned, rotation.rotate(turn, field), atol=1e-13 * size(field).max())


def test_no_sources_and_no_curl_outside_the_wire():
    step, points = 1e-4, np.random.default_rng(3).uniform(0.12, 0.5, (50, 3))
    numeric = np.stack(
        [(LOOP.field(0, 1.0, points + step * e) - LOOP.field(0, 1.0, points - step * e)) for e in np.eye(3)],
        axis=-1,
    ) / (2 * step)
    scale = np.linalg.norm(numeric, axis=(1, 2))
    assert (np.abs(np.trace(numeric, axis1=1, axis2=2)) / scale).max() < 1e-5
    assert (np.abs(numeric - np.swapaxes(numeric, 1, 2)).max(axis=(1, 2)) / scale).max() < 1e-5


@pytest.mark.parametrize("z", [0.02, 0.1, 0.3, 0.8])
def test_no_jump_near_the_axis(z):
    """Whatever series is used where, the field must not show it: k^2 from 1e-8 to 1e-2, in steps of parts in 1e9."""
    for k2 in 10.0 ** np.arange(-8.0, -1.9, 0.25):
        rho = 0.055 * k2 * (1 + (z / 0.055) ** 2) / 4.0
        near, beyond = LOOP.field(0, 1.0, [[rho, 0.0, z], [rho * (1 + 1e-9), 0.0, z]])
        assert abs(beyond[0] / near[0] - 1.0) < 1e-8
        assert abs(beyond[2] / near[2] - 1.0) < 1e-8


def test_the_turn_of_the_coil_belongs_into_the_jacobian():
    """Erratum X3: without it the derivative of a tilted coil is wrong by its own size."""
    p, q, step = np.array([0.25, 0.2, 0.3]), rotation.exp([0.4, -0.2, 0.6]), 1e-5
    coil = TILTED.coils[0]
    numeric = np.stack(
        [
            predict(TILTED, 0, 1.3, p + step * e, q).field_sensor_t
            - predict(TILTED, 0, 1.3, p - step * e, q).field_sensor_t
            for e in np.eye(3)
        ],
        axis=-1,
    ) / (2 * step)
    axis = np.array(coil.axis) / np.linalg.norm(coil.axis)
    across = np.cross([0.0, 0.0, 1.0], axis)
    angle = np.arctan2(np.linalg.norm(across), axis[2])
    to_source = rotation.to_matrix(rotation.exp(across / np.linalg.norm(across) * angle))
    _, gradient = LOOP.field_and_gradient(0, 1.3, to_source.T @ (p - np.array(coil.centre_m)))
    sensor = rotation.to_matrix(q).T
    right, printed = sensor @ to_source @ gradient @ to_source.T, sensor @ to_source @ gradient
    assert np.linalg.norm(right - numeric) < 1e-6 * np.linalg.norm(numeric)
    assert np.linalg.norm(printed - numeric) > 0.5 * np.linalg.norm(numeric)
    found = predict(TILTED, 0, 1.3, p, q).jacobian[:, :3]
    np.testing.assert_allclose(found, right, atol=1e-12 * np.abs(right).max())


def test_turning_source_and_pose_together_changes_nothing():
    turn = rotation.exp([0.7, -1.1, 0.4])
    coil = TILTED.coils[0]
    turned = Source(
        (
            Coil(
                centre_m=tuple(rotation.rotate(turn, coil.centre_m)),
                axis=tuple(rotation.rotate(turn, coil.axis)),
            ),
        )
    )
    q = rotation.exp([0.1, 0.5, -0.3])
    a = predict(TILTED, 0, 1.0, POINT, q).field_sensor_t
    b = predict(turned, 0, 1.0, rotation.rotate(turn, POINT), rotation.multiply(turn, q)).field_sensor_t
    np.testing.assert_allclose(b, a, atol=1e-12 * size(a))


def test_joseph_is_the_simple_form_and_endless_noise_changes_nothing():
    h = predict(BENCH, 0, 0.91, POINT, LEVEL).jacobian
    gain = P @ h.T @ np.linalg.inv(h @ P @ h.T + NOISE)
    simple = (np.eye(6) - gain @ h) @ P
    np.testing.assert_allclose(posterior_covariance(P, h, NOISE), simple, atol=1e-12 * np.abs(P).max())
    q = rotation.exp([0.1, 0.2, 0.3])
    measured = predict(BENCH, 0, 0.91, POINT, LEVEL).field_sensor_t
    left = update(BENCH, 0, 0.91, POINT + 0.01, q, P, measured, 1e20 * NOISE)
    np.testing.assert_allclose(left.position_m, POINT + 0.01, atol=1e-12)
    assert np.abs(rotation.log(rotation.multiply(rotation.conjugate(q), left.q_source_sensor))).max() < 1e-12
    np.testing.assert_allclose(left.covariance, P, atol=1e-15)


def test_current_and_noise_scaled_alike_and_both_signs_of_a_quaternion():
    q, measured = rotation.exp([0.01, -0.01, 0.01]), predict(BENCH, 0, 0.91, POINT, LEVEL).field_sensor_t
    one = update(BENCH, 0, 0.91, POINT + 0.01, q, P, measured, NOISE)
    scaled = update(BENCH, 0, 3 * 0.91, POINT + 0.01, q, P, 3 * measured, 9 * NOISE)
    other = update(BENCH, 0, 0.91, POINT + 0.01, -q, P, measured, NOISE)
    for found in (scaled, other):
        np.testing.assert_allclose(found.position_m, one.position_m, atol=1e-13)
        np.testing.assert_allclose(found.covariance, one.covariance, atol=1e-16)
        assert rotation.angle_between(found.q_source_sensor, one.q_source_sensor) < 1e-7


def columns(source, p, q, current=1.5):
    return np.stack([predict(source, k, current, p, q).field_sensor_t for k in range(3)], axis=-1)


def test_metamorphic_checks_of_the_tracker():
    source = perpendicular_source(model="dipole")
    p, q = np.array([0.2, 0.1, 0.3]), rotation.exp([0.3, -0.5, 0.2])
    base = closed_form(source, columns(source, p, q), 1.5)
    # Coils and axes of the source, named anew in a circle: the position's components follow.
    circle = rotation.from_matrix(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))
    named = closed_form(source, columns(source, p, q)[:, [1, 2, 0]], 1.5)
    np.testing.assert_allclose(np.abs(named.position_m), np.abs(base.position_m[[1, 2, 0]]), atol=1e-12)
    assert (
        rotation.angle_between(named.q_source_sensor, rotation.multiply(circle, base.q_source_sensor)) < 1e-6
    )
    # Twice as far is an eighth of the signal; more current with its own calibration leaves the pose.
    ratio = np.linalg.norm(columns(source, p, q)) / np.linalg.norm(columns(source, 2 * p, q))
    assert ratio == pytest.approx(8.0, rel=1e-12)
    stronger = closed_form(source, columns(source, p, q, 2.5), 2.5)
    np.testing.assert_allclose(stronger.position_m, base.position_m, atol=1e-13)


def test_coils_named_anew_change_only_the_name_of_the_choice():
    source, order = perpendicular_source(0.06), [2, 0, 1]
    other = Source(tuple(source.coils[k] for k in order))
    rng = np.random.default_rng(4)
    p, q = rng.uniform(0.15, 0.4, (200, 3)), rotation.normalize(rng.normal(size=(200, 4)))
    prior = np.broadcast_to(np.diag([4e-4] * 3 + [1.9e-3] * 3), (200, 6, 6))
    one, scores = choose_coil(source, 1.3, p, q, prior)
    two, renamed = choose_coil(other, 1.3, p, q, prior)
    np.testing.assert_allclose(renamed, scores[:, order], rtol=1e-11)
    np.testing.assert_array_equal(np.array(order)[two], one)
