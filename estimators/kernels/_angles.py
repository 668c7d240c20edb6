"""Angles and turns inside compiled loops, by series where they are exact to rounding."""

import math
from typing import Final

from estimators._kernels import Scalars4, step

_EIGHTH: Final = math.tan(math.pi / 8)


@step("UniTuple(float64, 4)(float64, float64, float64)", inlined=True)
def turn(rx: float, ry: float, rz: float) -> Scalars4:
    """Return the unit quaternion of a rotation vector; below half a radian by series exact to 1e-16."""
    square = 0.25 * (rx * rx + ry * ry + rz * rz)
    # sin(x)/x and cos(x) of x^2 = square; the terms left out are below 1e-16.
    if square < 1e-3:
        # Most samples and nearly all corrections: shorter series, of which attitude waits for the next.
        scale = 0.5 + square * (-1 / 12 + square * (1 / 240 - square * (1 / 10080)))
        cosine = 1.0 + square * (-1 / 2 + square * (1 / 24 + square * (-1 / 720 + square * (1 / 40320))))
        return cosine, rx * scale, ry * scale, rz * scale
    if square < 0.0625:
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
                + square
                * (-1 / 720 + square * (1 / 40320 + square * (-1 / 3628800 + square * (1 / 479001600))))
            )
        )
        return cosine, rx * scale, ry * scale, rz * scale
    half = math.sqrt(square)
    scale = 0.5 * math.sin(half) / half
    return math.cos(half), rx * scale, ry * scale, rz * scale


@step("float64(float64)", inlined=True)
def arcsine(sine: float) -> float:
    """Return asin of what lies within one, exact to 2e-16, without a call.

    Below a half asin x = x + x s P(s) with s = x^2, above pi/2 - 2 asin sqrt((1 - x) / 2). P interpolates the
    series at the thirteen Chebyshev points of s in [0, 1/4].
    """
    size = abs(sine)
    steep = size > 0.5
    s = 0.5 * (1.0 - size) if steep else size * size
    x = math.sqrt(s) if steep else size
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
    if steep:
        angle = 0.5 * math.pi - 2.0 * angle
    return -angle if sine < 0.0 else angle


@step("float64(float64, float64)", inlined=True)
def direction(y: float, x: float) -> float:
    """Return atan2(y, x) of finite numbers to a relative 4e-16, with one division and no call; zero where both are.

    Brought to within an eighth of a turn, atan t = t + t s P(s) with s = t^2. P interpolates the series at the eleven
    Chebyshev points of s in [0, tan(pi/8)^2].
    """
    across, along = abs(y), abs(x)
    small, large = min(across, along), max(across, along)
    steep = small > _EIGHTH * large
    above = small - large if steep else small
    below = small + large if steep else large
    t = above / below if below > 0.0 else 0.0
    s = t * t
    s2 = s * s
    s4 = s2 * s2
    first = (-0.3333333333333333 + s * 0.1999999999999552) + s2 * (
        -0.14285714284666542 + s * 0.11111111015256361
    )
    second = (-0.09090904578123903 + s * 0.07692183190826087) + s2 * (
        -0.06664511447381948 + s * 0.0585814891280221
    )
    third = (-0.0508544973794026 + s * 0.03923165829558719) - s2 * 0.01917688711906226
    angle = t + t * (s * (first + s4 * (second + s4 * third)))
    angle = 0.25 * math.pi + angle if steep else angle
    angle = 0.5 * math.pi - angle if across > along else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle
