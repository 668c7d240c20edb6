"""Rotations are proven by their axioms; scipy is the second opinion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import _kernels, rotation

SEED = 20260
ROUNDING = 5e-15  # a few dozen operations on numbers near one


def unit_quaternions(count: int = 1000, seed: int = SEED) -> np.ndarray:
    q = np.random.default_rng(seed).standard_normal((count, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def same_rotation(p, q, tolerance=ROUNDING) -> None:
    np.testing.assert_allclose(rotation.positive(p), rotation.positive(q), atol=tolerance)


def test_product_stays_on_the_unit_sphere():
    product = rotation.multiply(unit_quaternions(), unit_quaternions(seed=1))
    np.testing.assert_allclose(np.linalg.norm(product, axis=-1), 1.0, atol=ROUNDING)


def test_identity_and_inverse():
    q = unit_quaternions()
    np.testing.assert_array_equal(rotation.multiply(q, rotation.identity()), q)
    np.testing.assert_array_equal(rotation.multiply(rotation.identity((1000,)), q), q)
    np.testing.assert_allclose(
        rotation.multiply(q, rotation.conjugate(q)),
        np.broadcast_to(rotation.identity(), q.shape),
        atol=ROUNDING,
    )


def test_product_is_associative_and_rotates_in_turn():
    p, q, r = (unit_quaternions(seed=i) for i in range(3))
    np.testing.assert_allclose(
        rotation.multiply(rotation.multiply(p, q), r),
        rotation.multiply(p, rotation.multiply(q, r)),
        atol=ROUNDING,
    )
    v = np.random.default_rng(SEED).standard_normal((1000, 3))
    np.testing.assert_allclose(
        rotation.rotate(rotation.multiply(p, q), v), rotation.rotate(p, rotation.rotate(q, v)), atol=2e-14
    )


def test_rotation_keeps_length_and_handedness():
    q = unit_quaternions()
    x, y, z = (rotation.rotate(q, axis) for axis in np.eye(3))
    np.testing.assert_allclose(np.cross(x, y), z, atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.norm(x, axis=-1), 1.0, atol=ROUNDING)


def test_quarter_turn_about_z_takes_x_to_y():
    np.testing.assert_allclose(
        rotation.rotate(rotation.about_z(np.pi / 2), [1, 0, 0]), [0, 1, 0], atol=ROUNDING
    )
    np.testing.assert_allclose(
        rotation.rotate(rotation.about_x(np.pi / 2), [0, 1, 0]), [0, 0, 1], atol=ROUNDING
    )
    np.testing.assert_allclose(
        rotation.rotate(rotation.about_y(np.pi / 2), [0, 0, 1]), [1, 0, 0], atol=ROUNDING
    )


def test_both_covers_are_one_rotation():
    q = unit_quaternions()
    v = np.array([0.3, -1.0, 2.0])
    np.testing.assert_allclose(rotation.rotate(q, v), rotation.rotate(-q, v), atol=ROUNDING)
    np.testing.assert_allclose(rotation.angle_between(q, -q), 0.0, atol=ROUNDING)
    np.testing.assert_allclose(rotation.log(q), rotation.log(-q))


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 0.99e-4, 1.01e-4, 1e-3, 1.0, np.pi - 1e-9, np.pi])
def test_exp_and_log_undo_each_other(angle):
    axes = np.random.default_rng(SEED).standard_normal((200, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    there = rotation.exp(angle * axes)
    np.testing.assert_allclose(np.linalg.norm(there, axis=-1), 1.0, atol=ROUNDING)
    back = rotation.log(there)
    # At pi either sign of the axis is right. Near pi the cosine still fixes the angle to rounding.
    if angle == np.pi:
        back *= np.sign(np.sum(back * axes, axis=-1, keepdims=True))
    np.testing.assert_allclose(back, angle * axes, rtol=1e-13, atol=1e-15 if angle < 1 else 1e-14)


def test_exp_takes_angles_beyond_a_turn():
    same_rotation(rotation.exp([0.0, 0.0, 2 * np.pi + 0.3]), rotation.about_z(0.3))


def test_series_branch_meets_the_closed_form():
    just_below, just_above = (
        np.array([0.0, 0.0, 1e-4 * (1 - 1e-12)]),
        np.array([0.0, 0.0, 1e-4 * (1 + 1e-12)]),
    )
    np.testing.assert_allclose(rotation.exp(just_below), rotation.exp(just_above), rtol=3e-12)


def test_matrices_agree_with_scipy_and_come_back():
    q = unit_quaternions()
    matrices = rotation.to_matrix(q)
    np.testing.assert_allclose(matrices, rotation.to_scipy(q).as_matrix(), atol=ROUNDING)
    same_rotation(rotation.from_matrix(matrices), q)
    half_turns = np.concatenate([np.zeros((3, 1)), np.eye(3)], axis=1)
    same_rotation(rotation.from_matrix(rotation.to_matrix(half_turns)), half_turns)


def test_scipy_bridge_is_its_own_inverse():
    q = unit_quaternions()
    same_rotation(rotation.from_scipy(rotation.to_scipy(q)), q)
    quarter = rotation.from_scipy(Rotation.from_euler("z", 90, degrees=True))
    same_rotation(quarter, rotation.about_z(np.pi / 2))


def test_angle_between_known_turns():
    angles = np.array([0.0, 1e-9, 0.5, np.pi - 1e-9, np.pi])
    q = unit_quaternions(5)
    np.testing.assert_allclose(
        rotation.angle_between(q, rotation.multiply(q, rotation.about_y(angles))), angles, atol=ROUNDING
    )


def test_slerp_is_even_and_takes_the_short_way():
    p = unit_quaternions()
    vector = np.random.default_rng(SEED).uniform(-1, 1, (1000, 3))
    q = rotation.multiply(p, rotation.exp(vector))
    same_rotation(rotation.slerp(p, q, np.zeros(1000)), p)
    same_rotation(rotation.slerp(p, -q, np.ones(1000)), q)
    same_rotation(rotation.slerp(p, q, np.full(1000, 0.3)), rotation.multiply(p, rotation.exp(0.3 * vector)))


def test_mean_ignores_signs_and_is_the_middle():
    centre = unit_quaternions(1)[0]
    vectors = np.random.default_rng(SEED).uniform(-0.4, 0.4, (100, 3))
    around = rotation.multiply(centre, rotation.exp(np.concatenate((vectors, -vectors))))
    around[::3] *= -1
    same_rotation(rotation.mean(around), centre, 1e-14)
    pair = np.stack((rotation.identity(), rotation.about_z(1.0)))
    np.testing.assert_allclose(rotation.mean(pair, [1.0, 0.0]), rotation.identity(), atol=ROUNDING)
    assert rotation.mean(around.reshape(2, 100, 4)).shape == (2, 4)


def test_split_heading_puts_itself_together():
    q = unit_quaternions()
    heading, inclination = rotation.split_heading(q)
    same_rotation(rotation.multiply(rotation.about_z(heading), inclination), q)
    np.testing.assert_allclose(inclination[..., 3], 0.0, atol=ROUNDING)
    turned, same_inclination = rotation.split_heading(rotation.multiply(rotation.about_z(0.5), q))
    np.testing.assert_allclose(np.exp(1j * turned), np.exp(1j * (heading + 0.5)), atol=1e-11)
    same_rotation(same_inclination, inclination, 1e-11)  # ill-conditioned for the few nearly inverted ones
    undefined, _ = rotation.split_heading([0.0, 1.0, 0.0, 0.0])
    assert undefined == 0.0


def test_shortest_rotation_between_directions():
    rng = np.random.default_rng(SEED)
    a, b = rng.standard_normal((2, 1000, 3))
    q = rotation.shortest(a, b)
    turned = rotation.rotate(q, a)
    scale = np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    np.testing.assert_allclose(turned, b * scale[:, None], atol=1e-13)
    np.testing.assert_allclose(rotation.rotate(rotation.shortest(a, -a), a), -a, atol=1e-13)
    same_rotation(rotation.shortest(a, a), np.broadcast_to(rotation.identity(), (1000, 4)))


def test_continuous_removes_sign_jumps():
    angles = np.linspace(0, 4 * np.pi, 400)
    q = rotation.positive(rotation.about_z(angles))
    smooth = rotation.continuous(q)
    assert np.abs(np.diff(smooth, axis=0)).max() < 0.02
    same_rotation(smooth, q)


def test_compiled_scalars_equal_the_arrays():
    p, q = unit_quaternions(50), unit_quaternions(50, seed=1)
    v = np.random.default_rng(SEED).standard_normal((50, 3)) * np.logspace(-12, 0, 50)[:, None]
    for a, b, c in zip(p, q, v, strict=True):
        np.testing.assert_allclose(_kernels.multiply(*a, *b), rotation.multiply(a, b), atol=ROUNDING)
        np.testing.assert_allclose(_kernels.rotate(*a, *c), rotation.rotate(a, c), atol=ROUNDING)
        np.testing.assert_allclose(
            _kernels.rotate_back(*a, *c), rotation.rotate(rotation.conjugate(a), c), atol=ROUNDING
        )
        np.testing.assert_allclose(_kernels.exponential(*c), rotation.exp(c), rtol=1e-14, atol=1e-300)
        np.testing.assert_allclose(_kernels.normalized(*(3 * a)), a, atol=ROUNDING)
    assert _kernels.normalized(0.0, 0.0, 0.0, 0.0) == (1.0, 0.0, 0.0, 0.0)
    for angle in (-7.0, -np.pi, 0.0, 3.0, np.pi, 100.0):
        wrapped = _kernels.wrapped(angle)
        assert -np.pi <= wrapped < np.pi
        assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-13)
