"""The error-state core beside dense algebra, and the records, angles and matrices that it stands on."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.kernels import (
    arcsine,
    direction,
    filled,
    invert_symmetric,
    mirror,
    record,
    restored,
    skew,
    turn,
)
from published._error_state import BASE, absorb, attitude_seen, inject, predict, turn_by_rate

STATE = record([("q", "f8", 4), ("bias", "f8", 3)])
STATES = BASE + 3
STEP_S = 0.01


def covariance(seed):
    root = np.random.default_rng(seed).standard_normal((STATES, STATES))
    return root @ root.T


def upper(p):
    """The half that the core works on, with nonsense below."""
    return np.where(np.tri(STATES, k=-1) > 0, np.nan, p)


def estimate(seed):
    rng = np.random.default_rng(seed)
    state = np.zeros(1, STATE)
    state["q"], state["bias"] = rotation.normalize(rng.standard_normal(4)), 0.1 * rng.standard_normal(3)
    return state


def test_prediction_is_the_dense_one():
    state, rate = estimate(1), np.array([0.4, -0.7, 0.3])
    turned_q = rotation.multiply(state["q"][0], rotation.exp((rate - state["bias"][0]) * STEP_S))
    turned = turn_by_rate(state[0], *rate, STEP_S)
    np.testing.assert_allclose(state["q"][0], turned_q, atol=1e-15)
    np.testing.assert_allclose(
        np.reshape(turned, (3, 3)), STEP_S * rotation.to_scipy(turned_q).as_matrix(), atol=1e-16
    )
    p = upper(covariance(2))
    predict(p, turned, 0.3, 0.2)
    transition = np.eye(BASE)
    transition[:3, 3:] = -np.reshape(turned, (3, 3))
    dense = covariance(2)
    dense[:BASE, :BASE] = transition @ dense[:BASE, :BASE] @ transition.T + np.diag([0.3] * 3 + [0.2] * 3)
    mirror(p)
    np.testing.assert_allclose(p, dense, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("is_pinned", [False, True])
def test_scalar_measurement_is_the_dense_one(is_pinned):
    dense, row = covariance(3), np.array([0.3, -1.2, 0.7])
    if is_pinned:
        dense[:BASE, BASE:] = dense[BASE:, :BASE] = 0.0
    p, h, errors = upper(dense), np.zeros(STATES), np.zeros(STATES)
    attitude_seen(p, tuple(row), h)
    np.testing.assert_allclose(h, dense[:, :3] @ row, rtol=1e-14, atol=1e-14)
    inverse = 1.0 / (row @ h[:3] + 0.5)
    absorb(p, errors, h, 0.8, inverse, 0.0 if is_pinned else inverse)
    mirror(p)
    np.testing.assert_allclose(errors, 0.8 * inverse * h, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(p, dense - inverse * np.outer(h, h), rtol=1e-13, atol=1e-13)


def test_a_pinned_state_is_left_alone():
    dense = covariance(4)
    p, h, errors = upper(dense), np.zeros(STATES), np.zeros(STATES)
    attitude_seen(p, (1.0, 0.0, 0.0), h)
    absorb(p, errors, h, 0.8, 0.2, 0.0)
    np.testing.assert_array_equal(p[:, BASE:], upper(dense)[:, BASE:])
    np.testing.assert_array_equal(errors[BASE:], 0.0)
    assert (errors[:BASE] != 0.0).all()


def test_errors_are_taken_out_of_the_estimate():
    state, errors = estimate(5), np.random.default_rng(6).standard_normal(STATES)
    expected = rotation.multiply(rotation.exp(-errors[:3]), state["q"][0])
    bias = state["bias"][0] - errors[3:6]
    inject(state[0], errors)
    np.testing.assert_allclose(state["q"][0], expected, atol=1e-15)
    np.testing.assert_array_equal(state["bias"][0], bias)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.03, 0.0633, 0.3, 0.6, 3.0])
def test_turn_is_that_of_the_library(angle):
    vector = angle * np.array([0.6, -0.48, 0.64])
    np.testing.assert_allclose(
        turn(*vector), Rotation.from_rotvec(vector).as_quat(scalar_first=True), atol=2e-16
    )


def test_arcsine_is_that_of_the_library():
    sines = np.concatenate((np.linspace(-1.0, 1.0, 2001), [0.5, np.nextafter(0.5, 1.0), 1e-9, -1e-300, 0.0]))
    found = [arcsine(float(sine)) for sine in sines]
    np.testing.assert_allclose(found, np.arcsin(sines), rtol=4e-16, atol=4e-16)


def test_direction_is_that_of_the_library():
    y, x = np.random.default_rng(8).standard_normal((2, 500))
    # The borders of the eighths, the axes, where both are tiny, and where there is no direction.
    edge = math.tan(math.pi / 8)
    y = np.concatenate((y, [edge, np.nextafter(edge, 1.0), 1.0, -1.0, 0.0, 1e-300, 3.0, -3.0, 0.0]))
    x = np.concatenate((x, [1.0, 1.0, 1.0, -edge, -2.0, 1e-300, 0.0, 0.0, 0.0]))
    found = [direction(float(a), float(b)) for a, b in zip(y, x, strict=True)]
    np.testing.assert_allclose(found, np.arctan2(y, x), rtol=6e-16)


def test_small_matrices():
    m, v, w = covariance(7)[:3, :3].copy(), np.array([0.2, -0.5, 1.1]), np.array([0.7, 0.3, -0.4])
    found = np.zeros((3, 3))
    invert_symmetric(m, found)
    np.testing.assert_allclose(found @ m, np.eye(3), atol=1e-12)
    skew(*v, found)
    np.testing.assert_allclose(found @ w, np.cross(v, w), atol=1e-16)


def test_a_record_wants_every_field_and_no_other():
    kind = record([("step_s", "f8")], [("is_still", "i8")])
    assert filled(kind, {"step_s": 0.5, "is_still": True})[0].tolist() == (0.5, 1)
    for wrong in ({"step_s": 0.5}, {"step_s": 0.5, "is_still": 1, "more": 0}):
        with pytest.raises(SetupError):
            filled(kind, wrong)


def test_records_of_another_version_are_refused():
    old, new = record([("step_s", "f8")]), record([("step_s", "f8"), ("more", "f8")])
    like = np.zeros(2, new)
    copy = restored({"x": like}, "x", like)
    copy["more"] = 1.0
    assert (like["more"] == 0.0).all()
    for stored in ({}, {"x": np.zeros(2, old)}, {"x": np.zeros(3, new)}):
        with pytest.raises(ShapeError):
            restored(stored, "x", like)
