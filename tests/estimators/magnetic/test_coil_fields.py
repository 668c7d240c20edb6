"""Fields of coils: closed forms, Biot-Savart, numeric derivatives, identities (method pages MM 8.10 and C5 4.2)."""

import time

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

from estimators.errors import SetupError, ShapeError
from estimators.magnetic import Coil, IronSphere, Source, keep_away_distance_m, perpendicular_source
from estimators.magnetic import _loop_kernel as kernel
from estimators.magnetic.published import (
    MU0_TM_PER_A,
    axial_dipole_error,
    axial_reach_m,
    biot_savart,
    curvature_per_m2,
    dipole_field,
    dipole_gradient,
    linearisation_error_percent,
    range_m,
    required_moment_am2,
)

RNG = np.random.default_rng(5)
TILTED = Coil(50.0, 0.055, (0.01, 0.02, -0.03), (1.0, 2.0, 3.0))
BENCH = Source((Coil(axis=(1.0, 0.0, 0.0)),))
"""The bench of 2010: axis along x of the table, 0.91 A."""
POINT = np.array([0.3, 0.1, 0.0])


def far_points(count, least=0.12):
    points = RNG.uniform(-0.8, 0.8, (count * 3, 3))
    return points[np.linalg.norm(points, axis=1) > least][:count]


@pytest.mark.parametrize("m", [0.0, 1e-12, 1e-6, 0.01, 0.3, 0.9, 0.9999])
def test_elliptic_integrals(m):
    k, s = kernel.elliptic(1.0 - m)
    assert k == pytest.approx(ellipk(m), rel=1e-15)
    assert k * (1.0 - 0.5 * m - m * m * s) == pytest.approx(ellipe(m), rel=2e-15)


def test_loop_equals_biot_savart():
    points = far_points(300)
    found = Source((TILTED,)).field(0, 1.3, points)
    expected = biot_savart(TILTED, 1.3, points)
    error = np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)
    assert error.max() < 1e-9


@pytest.mark.parametrize("model", ["exact", "dipole"])
def test_gradients_equal_numeric_ones(model):
    source, points, step = Source((TILTED,), model), far_points(300), 1e-5
    _, gradient = source.field_and_gradient(0, 1.3, points)
    numeric = np.stack(
        [
            (source.field(0, 1.3, points + step * e) - source.field(0, 1.3, points - step * e)) / (2 * step)
            for e in np.eye(3)
        ],
        axis=-1,
    )
    size = np.linalg.norm(gradient, axis=(1, 2))
    assert (np.linalg.norm(gradient - numeric, axis=(1, 2)) / size).max() < 1e-6
    assert (np.abs(np.trace(gradient, axis1=1, axis2=2)) / size).max() < 1e-12
    np.testing.assert_array_equal(gradient, np.swapaxes(gradient, 1, 2))


def test_the_axis_is_no_special_place():
    source = perpendicular_source(current_limit_a=1.5)
    z = np.array([0.0, 0.05, 0.3])
    axis = source.field(2, 1.0, np.stack([0 * z, 0 * z, z], axis=1))
    b = 0.055
    expected = MU0_TM_PER_A * 50.0 * b**2 / (2.0 * (b**2 + z**2) ** 1.5)
    np.testing.assert_allclose(axis[:, 2], expected, rtol=1e-13)
    np.testing.assert_array_equal(axis[:, :2], 0.0)
    # Continuity across all small radii: field along x grows in proportion to the distance from the axis.
    rho = 10.0 ** np.arange(-12.0, -4.0)
    near, gradient = source.field_and_gradient(2, 1.0, np.stack([rho, 0 * rho, 0 * rho + 0.3], axis=1))
    np.testing.assert_allclose(near[:, 0] / rho, gradient[0, 0, 0], rtol=1e-6)
    np.testing.assert_allclose(
        gradient, np.broadcast_to(gradient[0], gradient.shape), atol=2e-3 * abs(gradient[0]).max()
    )


def test_symmetries_and_scaling():
    loop = Source((Coil(),))
    p = far_points(50)
    field = loop.field(0, 1.0, p)
    np.testing.assert_allclose(loop.field(0, 1.0, -p), field, rtol=1e-12)
    mirrored = loop.field(0, 1.0, p * [1, 1, -1])
    np.testing.assert_allclose(mirrored, field * [-1, -1, 1], rtol=1e-12)
    np.testing.assert_allclose(loop.field(0, 3.0, p), 3.0 * field, rtol=1e-14)
    np.testing.assert_allclose(Source((Coil(radius_m=0.11),)).field(0, 1.0, 2 * p), field / 2.0, rtol=1e-11)


def test_amperes_law_along_the_axis():
    z = np.tan(np.linspace(-np.pi / 2, np.pi / 2, 200001)[1:-1]) * 0.055
    field = Source((Coil(),)).field(0, 1.0, np.stack([0 * z, 0 * z, z], axis=1))[:, 2]
    assert np.trapezoid(field, z) == pytest.approx(MU0_TM_PER_A * 50.0, rel=1e-6)


def test_the_dipole_is_the_far_limit():
    exact, dipole = Source((Coil(),)), Source((Coil(),), "dipole")
    direction = np.array([0.3, 0.5, np.sqrt(1 - 0.34)])
    r = np.array([0.4, 0.8, 1.6])
    a, b = (s.field(0, 1.0, r[:, None] * direction) for s in (exact, dipole))
    error = np.linalg.norm(a - b, axis=1) / np.linalg.norm(a, axis=1)
    np.testing.assert_allclose(error[:-1] / error[1:], 4.0, atol=0.15)
    assert axial_dipole_error(0.055, 0.35) == pytest.approx(0.037, abs=5e-4)
    moment = np.array([0.0, 0.0, Coil().moment_m2])
    np.testing.assert_allclose(b, dipole_field(moment, r[:, None] * direction), rtol=1e-12)
    _, gradient = dipole.field_and_gradient(0, 1.0, r[:, None] * direction)
    np.testing.assert_allclose(dipole_gradient(moment, r[:, None] * direction), gradient, rtol=1e-10)


@pytest.mark.parametrize(
    ("r_cm", "axis", "equator"),
    [(10, 95.90, -106.57), (20, 15.97, -9.732), (35, 3.205, -1.710), (80, 0.276, -0.140)],
)
def test_field_values_of_the_thesis_coil(r_cm, axis, equator):
    source = perpendicular_source()
    r = r_cm / 100.0
    on, across = source.field(2, 1.5, [[0, 0, r], [r, 0, 0]])[:, 2] * 1e6
    assert (on, across) == (pytest.approx(axis, abs=0.006), pytest.approx(equator, abs=0.006))


def test_a_winding_of_fifty_turns_is_nearly_a_loop():
    thin, wound = Coil(), Coil(length_m=0.008, depth_m=0.004, layers=(10, 5))
    points = np.array([[0.0, 0.0, 0.2], [0.3, 0.0, 0.0], [0.15, 0.1, 0.1]])
    a, b = (Source((coil,)).field(0, 1.0, points) for coil in (thin, wound))
    error = np.linalg.norm(a - b, axis=1) / np.linalg.norm(a, axis=1)
    assert 1e-5 < error.max() < 1.5e-3
    assert len(Source((wound,)).loops) == 50


def test_solenoid_length_that_cancels_the_first_error_term():
    """Roetenberg 5.5 (E15): length sqrt(3)/2 of the diameter, on the axis."""
    b = 0.055
    long = Coil(length_m=np.sqrt(3.0) * b, layers=(400, 1))
    found = Source((long,)).field(0, 1.0, [0.0, 0.0, 0.4])[2]
    dipole = Source((Coil(),), "dipole").field(0, 1.0, [0.0, 0.0, 0.4])[2]
    assert abs(found / dipole - 1.0) < 1e-3 < axial_dipole_error(b, 0.4)


def test_linearisation_error_and_curvature_are_those_of_the_page():
    for y, row in ((0.1, (6.42, 3.89, 2.53, 0.76)), (0.5, (1.36, 1.01, 0.73, 0.38))):
        found = [
            linearisation_error_percent(BENCH, 0, [x, y, 0.0], [0.03, 0, 0]) for x in (0.2, 0.3, 0.4, 0.8)
        ]
        np.testing.assert_allclose(found, row, atol=0.02)
    np.testing.assert_allclose(curvature_per_m2(BENCH, 0, POINT)[:2], (98.4, 52.6), rtol=0.01)


def test_range_size_and_safety():
    assert required_moment_am2(0.7, 4.0, 0.5e-7) == pytest.approx(0.686, abs=1e-3)
    assert range_m(0.686, 4.0, 0.5e-7) == pytest.approx(0.7, abs=1e-3)
    source = perpendicular_source()
    assert axial_reach_m(source, 5e-4) == pytest.approx(0.036, abs=5e-4)
    assert np.linalg.norm(source.field(2, 1.5, [0, 0, 0])) == pytest.approx(8.57e-4, rel=2e-3)
    away = keep_away_distance_m(source)
    polar = np.linspace(0, np.pi, 50)
    ring = away * np.stack([np.sin(polar), 0 * polar, np.cos(polar)], axis=1)
    strongest = np.linalg.norm(source.field(2, 1.5, ring), axis=1).max()
    assert strongest == pytest.approx(5e-4, rel=1e-2)


@pytest.mark.parametrize(
    ("place", "percent"),
    [((0.2, 0.1), 41.9), ((0.1, 0.1), 13.6), ((0.3, 0.2), 9.9), ((0.5, 0.1), 0.56), ((0.1, 0.3), 0.52)],
)
def test_iron_changes_the_field_as_on_the_page(place, percent):
    iron = IronSphere.of_cylinder(0.05, 0.05)
    at = np.array([*place, 0.0])
    added = iron.disturbance(BENCH.field(0, 0.91, at), POINT - at)
    share = 100 * np.linalg.norm(added) / np.linalg.norm(BENCH.field(0, 0.91, POINT))
    assert share == pytest.approx(percent, rel=0.02)


def test_iron_limits():
    assert IronSphere(0.05, 1.0).coupling == 0.0
    assert IronSphere(0.05, 0.0).coupling == -0.5
    inside = IronSphere().disturbance([1e-5, 0, 0], [1e-6, 0, 0])
    surface = IronSphere().disturbance([1e-5, 0, 0], [IronSphere().radius_m, 0, 0])
    np.testing.assert_allclose(inside, surface)


def test_a_million_fields_and_gradients_a_second():
    """Half of that is asked for here: the test machine has other work."""
    points = np.ascontiguousarray(far_points(20000))
    coil, current = np.zeros(len(points), dtype=np.int64), np.ones(len(points))
    field, gradient = np.empty_like(points), np.empty((len(points), 3, 3))
    best = np.inf
    for _ in range(5):
        begin = time.perf_counter()
        kernel.coil_fields(Source((TILTED,)).loops, coil, current, points, field, gradient)
        best = min(best, time.perf_counter() - begin)
    assert len(points) / best > 5e5


def test_bad_input_is_named():
    with pytest.raises(SetupError, match="radius"):
        Coil(radius_m=0.0)
    with pytest.raises(SetupError, match="axis"):
        Coil(axis=(0.0, 0.0, 0.0))
    with pytest.raises(SetupError):
        Source(())
    with pytest.raises(ShapeError):
        BENCH.field(0, 1.0, [0.1, 0.2])
    with pytest.raises(ShapeError, match="numbered"):
        BENCH.field(1, 1.0, POINT)
    with pytest.raises(SetupError):
        range_m(1.0, 0.0, 1e-8)
