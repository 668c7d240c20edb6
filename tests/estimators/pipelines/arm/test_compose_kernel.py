"""The compiled composition against its numpy twin, and what it means."""

import numpy as np

from estimators import rotation
from estimators.pipelines.arm.kernel import Worn, compose, compose_numpy, compose_python

NO_MOUNTING = np.empty((0, 3))


def draw(sensors=5, ticks=11, seed=1):
    generator = np.random.default_rng(seed)
    q = rotation.normalize(generator.normal(size=(sensors, ticks, 4)))
    sigma = generator.random((sensors, ticks, 3)) * 0.1
    gyroscope, bias = generator.normal(size=(2, sensors, ticks, 3))
    flags = (generator.random((sensors, ticks)) < 0.2).astype(np.uint8) | np.uint8(8)
    turn = rotation.about_z(generator.uniform(-3, 3, sensors))
    mounting = rotation.normalize(generator.normal(size=(sensors, 4)))
    return q, sigma, gyroscope, bias, flags, turn, mounting, NO_MOUNTING, np.zeros(sensors, np.uint8)


def filled(function, arguments):
    sensors, ticks = arguments[4].shape
    out = (
        np.empty((ticks, sensors, 4)),
        np.empty((ticks, sensors, 3)),
        np.empty((ticks, sensors, 3)),
        np.empty((ticks, sensors), dtype=np.uint8),
    )
    function(*arguments[:5], Worn(*arguments[5:]), *out)
    return out


def test_kernel_equals_its_twin():
    q, sigma, gyroscope, bias, flags, turn, mounting, *_ = draw()
    more = np.array([0, 32, 0, 4, 0], dtype=np.uint8)
    for variance in (NO_MOUNTING, np.random.default_rng(3).random((5, 3)) * 1e-2):
        expected = compose_numpy(q, sigma, gyroscope - bias, flags, turn, mounting, variance)
        for function in (compose, compose_python):
            found = filled(function, (q, sigma, gyroscope, bias, flags, turn, mounting, variance, more))
            for one, two in zip(found[:3], expected, strict=True):
                assert np.allclose(one, two, atol=1e-13, equal_nan=True)
            assert np.array_equal(found[3], flags.T | more)


def test_what_the_mounting_adds_is_to_the_bit_what_numpy_adds():
    """The kernel replaced an expression of numpy behind it; recorded results must not move."""
    *arguments, _, more = draw(17, 5, seed=2)
    variance = np.random.default_rng(4).random((17, 3)) * 1e-2
    q, _, bare, _ = filled(compose, (*arguments, NO_MOUNTING, more))
    part = rotation.to_matrix(q) ** 2 * variance[:, None]
    expected = np.sqrt(bare**2 + (part[..., 0] + part[..., 1] + part[..., 2]))
    assert np.array_equal(filled(compose, (*arguments, variance, more))[2], expected)


def test_rate_is_that_of_the_orientation():
    """Orientation differentiated numerically turns at the rate that comes out, in room axes."""
    rate, step_s = np.array([0.3, -0.7, 0.5]), 1e-4
    start = rotation.normalize([0.3, 0.5, -0.2, 0.7])
    q = np.stack([rotation.multiply(start, rotation.exp(rate * step_s * k)) for k in range(3)])[None]
    zeros, gyroscope = np.zeros((1, 3, 3)), np.broadcast_to(rate, (1, 3, 3)).copy()
    turn, mounting = rotation.about_z([0.8]), rotation.normalize([[0.1, 0.9, 0.2, 0.4]])
    segment, omega, _, _ = filled(
        compose,
        (
            q,
            zeros,
            gyroscope,
            zeros,
            np.zeros((1, 3), np.uint8),
            turn,
            mounting,
            NO_MOUNTING,
            np.zeros(1, np.uint8),
        ),
    )
    turned = rotation.log(rotation.multiply(segment[2, 0], rotation.conjugate(segment[0, 0]))) / (2 * step_s)
    assert np.allclose(turned, omega[1, 0], atol=1e-7)


def test_sigma_turns_with_the_room():
    q, _, gyroscope, bias, flags, _, mounting, none, more = draw(1, 1)
    sigma = np.array([[[0.1, 0.02, 0.3]]])
    quarter = rotation.about_z([np.pi / 2])
    assert np.allclose(
        filled(compose, (q, sigma, gyroscope, bias, flags, quarter, mounting, none, more))[2][0, 0],
        [0.02, 0.1, 0.3],
    )
