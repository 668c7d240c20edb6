"""Steps that filters over lanes have in common: quaternions, small angles, and what is read and written.

Those with a scalar sister in `_kernels` or `_strapdown_steps` equal it to the bit.
"""

import math

from numba import types

from estimators._kernels import Scalars3, Scalars4, multiply, rotate
from estimators._lanes import (
    LANES_TYPE,
    MASK_TYPE,
    QUATERNION_TYPE,
    VECTOR_TYPE,
    anywhere,
    at_least,
    at_most,
    chosen,
    column,
    in_lanes,
    of_one,
    put_column,
)
from estimators.recording import Float

_L, _I = LANES_TYPE, types.intp
_ROWS, _BLOCK = types.float64[:, ::1], types.float64[:, :, ::1]

multiply_lanes = in_lanes(QUATERNION_TYPE(*[_L] * 8))(of_one(multiply))
rotate_lanes = in_lanes(VECTOR_TYPE(*[_L] * 7))(of_one(rotate))


@in_lanes(_L(_L))
def sigma_of(variance: float) -> float:
    """Return the square root of a variance of an angle, at most half a turn."""
    return at_most(math.sqrt(at_least(variance, 0.0)), math.pi)


@in_lanes(types.UniTuple(_L, 2)(_L), inlined=False)
def far_turn(square: float) -> tuple[float, float]:
    """Return sin(x)/2x and cos(x) of x^2: for `turn_lanes` where its short series do not reach."""
    scale = 0.5 * (
        1.0
        + square
        * (
            -1 / 6
            + square * (1 / 120 + square * (-1 / 5040 + square * (1 / 362880 - square * (1 / 39916800))))
        )
    )
    cosine = 1.0 + square * (
        -1 / 2
        + square
        * (
            1 / 24
            + square * (-1 / 720 + square * (1 / 40320 + square * (-1 / 3628800 + square * (1 / 479001600))))
        )
    )
    far = square >= 0.0625
    if anywhere(far):
        half = math.sqrt(square)
        scale, cosine = chosen(far, 0.5 * math.sin(half) / half, scale), chosen(far, math.cos(half), cosine)
    return scale, cosine


@in_lanes(QUATERNION_TYPE(_L, _L, _L))
def turn_lanes(rx: float, ry: float, rz: float) -> Scalars4:
    """Return the unit quaternions of rotation vectors; see `_strapdown_steps.turn`."""
    square = 0.25 * (rx * rx + ry * ry + rz * rz)
    scale = 0.5 + square * (-1 / 12 + square * (1 / 240 - square * (1 / 10080)))
    cosine = 1.0 + square * (-1 / 2 + square * (1 / 24 + square * (-1 / 720 + square * (1 / 40320))))
    far = square >= 1e-3
    if anywhere(far):
        far_scale, far_cosine = far_turn(square)
        scale, cosine = chosen(far, far_scale, scale), chosen(far, far_cosine, cosine)
    return cosine, rx * scale, ry * scale, rz * scale


@in_lanes(_L(_L))
def arcsine(sine: float) -> float:
    """Return asin of what lies within one, exact to 2e-16, without a call.

    Below a half asin x = x + x s P(s) with s = x^2, above pi/2 - 2 asin sqrt((1 - x) / 2). P interpolates the
    series at the thirteen Chebyshev points of s in [0, 1/4].
    """
    size = abs(sine)
    steep = size > 0.5
    s = chosen(steep, 0.5 * (1.0 - size), size * size)
    x = chosen(steep, math.sqrt(s), size)
    s2 = s * s
    s4 = s2 * s2
    first = (0.16666666666666669 + s * 0.07499999999998433) + s2 * (
        0.04464285714635543 + s * 0.030381944138531247
    )
    second = (0.02237217294214989 + s * 0.017352392720869973) + s2 * (
        0.013971212973552933 + s * 0.011479177415184906
    )
    third = (0.01032281435018578 + s * 0.005457506718640356) + s2 * (
        0.017400879442694025 - s * 0.014851887071247209
    )
    angle = x + x * (s * (first + s4 * (second + s4 * (third + s4 * 0.02875785136742157))))
    angle = chosen(steep, 0.5 * math.pi - 2.0 * angle, angle)
    return chosen(sine < 0.0, -angle, angle)


@in_lanes(_L(_L, _L), inlined=False)
def far_direction(y: float, x: float) -> float:
    """Return atan2(y, x), exact to 4e-16; zero where both are."""
    across, along = abs(y), abs(x)
    steep = across > along
    length = math.sqrt(x * x + y * y)
    # The lesser of sine and cosine: its arc is as exact as itself.
    sine = chosen(length > 0.0, chosen(steep, along, across) / length, 0.0)
    angle = arcsine(sine)
    angle = chosen(steep, 0.5 * math.pi - angle, angle)
    angle = chosen(x < 0.0, math.pi - angle, angle)
    return chosen(y < 0.0, -angle, angle)


@in_lanes(_L(_L, _L))
def direction_lanes(y: float, x: float) -> float:
    """Return atan2(y, x); up to seven degrees, as innovations are, as `_marzouk_steps.direction` does."""
    t = y / x
    s = t * t
    s2 = s * s
    near = (1.0 - s * (1 / 3)) + s2 * (1 / 5 - s * (1 / 7))
    angle = t * (near + s2 * s2 * ((1 / 9 - s * (1 / 11)) + s2 * (1 / 13 - s * (1 / 15))))
    far = abs(y) >= 0.125 * x
    if anywhere(far):
        angle = chosen(far, far_direction(y, x), angle)
    return angle


@in_lanes(QUATERNION_TYPE(MASK_TYPE, QUATERNION_TYPE, QUATERNION_TYPE))
def either_quaternion(mask: bool, yes: Scalars4, no: Scalars4) -> Scalars4:
    """Return one quaternion where the mask is true and the other elsewhere."""
    return (
        chosen(mask, yes[0], no[0]),
        chosen(mask, yes[1], no[1]),
        chosen(mask, yes[2], no[2]),
        chosen(mask, yes[3], no[3]),
    )


@in_lanes(VECTOR_TYPE(MASK_TYPE, VECTOR_TYPE, VECTOR_TYPE))
def either_vector(mask: bool, yes: Scalars3, no: Scalars3) -> Scalars3:
    """Return one vector where the mask is true and the other elsewhere."""
    return chosen(mask, yes[0], no[0]), chosen(mask, yes[1], no[1]), chosen(mask, yes[2], no[2])


@in_lanes(VECTOR_TYPE(_ROWS, _I, _I, _I))
def three(rows: Float, row: int, last: int, first: int) -> Scalars3:
    """Return three columns of the rows side by side."""
    return (
        column(rows, (row, last, first)),
        column(rows, (row, last, first + 1)),
        column(rows, (row, last, first + 2)),
    )


@in_lanes(types.void(_ROWS, _I, _I, _I, VECTOR_TYPE))
def put_three(rows: Float, row: int, last: int, first: int, value: Scalars3) -> None:
    """Write three columns of the rows side by side."""
    put_column(rows, (row, last, first), value[0])
    put_column(rows, (row, last, first + 1), value[1])
    put_column(rows, (row, last, first + 2), value[2])


@in_lanes(QUATERNION_TYPE(_ROWS, _I, _I))
def quaternions(rows: Float, row: int, last: int) -> Scalars4:
    """Return the quaternions in the rows side by side."""
    return (
        column(rows, (row, last, 0)),
        column(rows, (row, last, 1)),
        column(rows, (row, last, 2)),
        column(rows, (row, last, 3)),
    )


@in_lanes(types.void(_ROWS, _I, _I, QUATERNION_TYPE))
def put_quaternions(rows: Float, row: int, last: int, value: Scalars4) -> None:
    """Write the quaternions in the rows side by side."""
    put_column(rows, (row, last, 0), value[0])
    put_column(rows, (row, last, 1), value[1])
    put_column(rows, (row, last, 2), value[2])
    put_column(rows, (row, last, 3), value[3])


@in_lanes(types.void(_BLOCK, _BLOCK, _BLOCK, _I, _I, _I, QUATERNION_TYPE, VECTOR_TYPE, VECTOR_TYPE))
def put_results(
    q_earth_sensor: Float,
    bias_out: Float,
    sigma_rad: Float,
    row: int,
    last: int,
    k: int,
    q: Scalars4,
    bias: Scalars3,
    variance: Scalars3,
) -> None:
    """Write quaternion, bias and sigma of tick `k`, which follows from the variances of the axes."""
    put_column(q_earth_sensor, (row, last, k, 0), q[0])
    put_column(q_earth_sensor, (row, last, k, 1), q[1])
    put_column(q_earth_sensor, (row, last, k, 2), q[2])
    put_column(q_earth_sensor, (row, last, k, 3), q[3])
    put_column(bias_out, (row, last, k, 0), bias[0])
    put_column(bias_out, (row, last, k, 1), bias[1])
    put_column(bias_out, (row, last, k, 2), bias[2])
    put_column(sigma_rad, (row, last, k, 0), sigma_of(variance[0]))
    put_column(sigma_rad, (row, last, k, 1), sigma_of(variance[1]))
    put_column(sigma_rad, (row, last, k, 2), sigma_of(variance[2]))


__all__ = [
    "arcsine",
    "direction_lanes",
    "either_quaternion",
    "either_vector",
    "far_direction",
    "multiply_lanes",
    "put_quaternions",
    "put_results",
    "put_three",
    "quaternions",
    "rotate_lanes",
    "three",
    "turn_lanes",
]
