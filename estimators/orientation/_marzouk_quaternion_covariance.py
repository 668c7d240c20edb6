"""Covariance of quaternion and offset held in registers, for the quaternion filter of the thesis.

Of the 7 x 7 matrix the 28 numbers of the upper triangle, each the `Lanes` of some sensors, travel as a tuple:
quaternion (10, by rows), cross terms (12, by rows), offset (6). Arrays may overlap as far as the compiler knows, and
every store to one would make it read the others again.
"""

from numba import types

from estimators._kernels import Scalars3, Scalars4
from estimators._lanes import LANES_TYPE, QUATERNION_TYPE, column, in_lanes, put_column
from estimators.recording import Float

Upper = tuple[float, ...]
"""The 28 numbers."""
Cross = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
Noise = tuple[float, float, float, float, float, float, float, float, float, float]
Seen = tuple[float, float, float, float, float, float, float]

UPPER, CROSS, NOISE = (
    types.UniTuple(LANES_TYPE, 28),
    types.UniTuple(LANES_TYPE, 12),
    types.UniTuple(LANES_TYPE, 10),
)
SEEN = types.UniTuple(LANES_TYPE, 7)
_ALIKE = types.UniTuple(types.float64, 3)
_FLAT = types.float64[:, ::1]


@in_lanes(UPPER(_FLAT, types.intp, types.intp))
def loaded(p: Float, row: int, last: int) -> Upper:
    """Read the upper triangles of sensors side by side from covariances by rows, (S, 49)."""
    return (
        column(p, (row, last, 0)),
        column(p, (row, last, 1)),
        column(p, (row, last, 2)),
        column(p, (row, last, 3)),
        column(p, (row, last, 8)),
        column(p, (row, last, 9)),
        column(p, (row, last, 10)),
        column(p, (row, last, 16)),
        column(p, (row, last, 17)),
        column(p, (row, last, 24)),
        column(p, (row, last, 4)),
        column(p, (row, last, 5)),
        column(p, (row, last, 6)),
        column(p, (row, last, 11)),
        column(p, (row, last, 12)),
        column(p, (row, last, 13)),
        column(p, (row, last, 18)),
        column(p, (row, last, 19)),
        column(p, (row, last, 20)),
        column(p, (row, last, 25)),
        column(p, (row, last, 26)),
        column(p, (row, last, 27)),
        column(p, (row, last, 32)),
        column(p, (row, last, 33)),
        column(p, (row, last, 34)),
        column(p, (row, last, 40)),
        column(p, (row, last, 41)),
        column(p, (row, last, 48)),
    )


@in_lanes(types.void(_FLAT, types.intp, types.intp, UPPER))
def keep(p: Float, row: int, last: int, upper: Upper) -> None:
    """Write the covariances of sensors side by side."""
    put_column(p, (row, last, 0), upper[0])
    put_column(p, (row, last, 1), upper[1])
    put_column(p, (row, last, 2), upper[2])
    put_column(p, (row, last, 3), upper[3])
    put_column(p, (row, last, 8), upper[4])
    put_column(p, (row, last, 9), upper[5])
    put_column(p, (row, last, 10), upper[6])
    put_column(p, (row, last, 16), upper[7])
    put_column(p, (row, last, 17), upper[8])
    put_column(p, (row, last, 24), upper[9])
    put_column(p, (row, last, 4), upper[10])
    put_column(p, (row, last, 5), upper[11])
    put_column(p, (row, last, 6), upper[12])
    put_column(p, (row, last, 11), upper[13])
    put_column(p, (row, last, 12), upper[14])
    put_column(p, (row, last, 13), upper[15])
    put_column(p, (row, last, 18), upper[16])
    put_column(p, (row, last, 19), upper[17])
    put_column(p, (row, last, 20), upper[18])
    put_column(p, (row, last, 25), upper[19])
    put_column(p, (row, last, 26), upper[20])
    put_column(p, (row, last, 27), upper[21])
    put_column(p, (row, last, 32), upper[22])
    put_column(p, (row, last, 33), upper[23])
    put_column(p, (row, last, 34), upper[24])
    put_column(p, (row, last, 40), upper[25])
    put_column(p, (row, last, 41), upper[26])
    put_column(p, (row, last, 48), upper[27])
    for s in range(row, last + 1):
        for i in range(7):
            for j in range(i):
                p[s, 7 * i + j] = p[s, 7 * j + i]


@in_lanes(UPPER(UPPER, QUATERNION_TYPE, CROSS, NOISE, _ALIKE))
def predicted(p: Upper, turned: Scalars4, right: Cross, noise: Noise, drift: Scalars3) -> Upper:
    """P' = Phi P Phi' + Q, with Phi = [[Omega, right], [0, I]] and Omega of `turned`, which multiplies from the right.

    Written as P_qq' = Omega P_qq Omega' + N right' + right G', with G = Omega C of the old cross terms C and
    N = G + right P_bb the new ones.
    """
    a00, a01, a02, a03, a11, a12, a13, a22, a23, a33 = p[:10]
    c00, c01, c02, c10, c11, c12, c20, c21, c22, c30, c31, c32 = p[10:22]
    b00, b01, b02, b11, b12, b22 = p[22:]
    a, x, y, z = turned
    r00, r01, r02, r10, r11, r12, r20, r21, r22, r30, r31, r32 = right
    l00 = a * a00 - x * a01 - y * a02 - z * a03
    l01 = a * a01 - x * a11 - y * a12 - z * a13
    l02 = a * a02 - x * a12 - y * a22 - z * a23
    l03 = a * a03 - x * a13 - y * a23 - z * a33
    l10 = x * a00 + a * a01 + z * a02 - y * a03
    l11 = x * a01 + a * a11 + z * a12 - y * a13
    l12 = x * a02 + a * a12 + z * a22 - y * a23
    l13 = x * a03 + a * a13 + z * a23 - y * a33
    l20 = y * a00 - z * a01 + a * a02 + x * a03
    l21 = y * a01 - z * a11 + a * a12 + x * a13
    l22 = y * a02 - z * a12 + a * a22 + x * a23
    l23 = y * a03 - z * a13 + a * a23 + x * a33
    l30 = z * a00 + y * a01 - x * a02 + a * a03
    l31 = z * a01 + y * a11 - x * a12 + a * a13
    l32 = z * a02 + y * a12 - x * a22 + a * a23
    l33 = z * a03 + y * a13 - x * a23 + a * a33
    g00 = a * c00 - x * c10 - y * c20 - z * c30
    g01 = a * c01 - x * c11 - y * c21 - z * c31
    g02 = a * c02 - x * c12 - y * c22 - z * c32
    g10 = x * c00 + a * c10 + z * c20 - y * c30
    g11 = x * c01 + a * c11 + z * c21 - y * c31
    g12 = x * c02 + a * c12 + z * c22 - y * c32
    g20 = y * c00 - z * c10 + a * c20 + x * c30
    g21 = y * c01 - z * c11 + a * c21 + x * c31
    g22 = y * c02 - z * c12 + a * c22 + x * c32
    g30 = z * c00 + y * c10 - x * c20 + a * c30
    g31 = z * c01 + y * c11 - x * c21 + a * c31
    g32 = z * c02 + y * c12 - x * c22 + a * c32
    n00 = g00 + (r00 * b00 + r01 * b01 + r02 * b02)
    n01 = g01 + (r00 * b01 + r01 * b11 + r02 * b12)
    n02 = g02 + (r00 * b02 + r01 * b12 + r02 * b22)
    n10 = g10 + (r10 * b00 + r11 * b01 + r12 * b02)
    n11 = g11 + (r10 * b01 + r11 * b11 + r12 * b12)
    n12 = g12 + (r10 * b02 + r11 * b12 + r12 * b22)
    n20 = g20 + (r20 * b00 + r21 * b01 + r22 * b02)
    n21 = g21 + (r20 * b01 + r21 * b11 + r22 * b12)
    n22 = g22 + (r20 * b02 + r21 * b12 + r22 * b22)
    n30 = g30 + (r30 * b00 + r31 * b01 + r32 * b02)
    n31 = g31 + (r30 * b01 + r31 * b11 + r32 * b12)
    n32 = g32 + (r30 * b02 + r31 * b12 + r32 * b22)
    return (
        (a * l00 - x * l01 - y * l02 - z * l03)
        + (r00 * (n00 + g00) + r01 * (n01 + g01) + r02 * (n02 + g02))
        + noise[0],
        (x * l00 + a * l01 + z * l02 - y * l03)
        + ((n00 * r10 + n01 * r11 + n02 * r12) + (r00 * g10 + r01 * g11 + r02 * g12))
        + noise[1],
        (y * l00 - z * l01 + a * l02 + x * l03)
        + ((n00 * r20 + n01 * r21 + n02 * r22) + (r00 * g20 + r01 * g21 + r02 * g22))
        + noise[2],
        (z * l00 + y * l01 - x * l02 + a * l03)
        + ((n00 * r30 + n01 * r31 + n02 * r32) + (r00 * g30 + r01 * g31 + r02 * g32))
        + noise[3],
        (x * l10 + a * l11 + z * l12 - y * l13)
        + (r10 * (n10 + g10) + r11 * (n11 + g11) + r12 * (n12 + g12))
        + noise[4],
        (y * l10 - z * l11 + a * l12 + x * l13)
        + ((n10 * r20 + n11 * r21 + n12 * r22) + (r10 * g20 + r11 * g21 + r12 * g22))
        + noise[5],
        (z * l10 + y * l11 - x * l12 + a * l13)
        + ((n10 * r30 + n11 * r31 + n12 * r32) + (r10 * g30 + r11 * g31 + r12 * g32))
        + noise[6],
        (y * l20 - z * l21 + a * l22 + x * l23)
        + (r20 * (n20 + g20) + r21 * (n21 + g21) + r22 * (n22 + g22))
        + noise[7],
        (z * l20 + y * l21 - x * l22 + a * l23)
        + ((n20 * r30 + n21 * r31 + n22 * r32) + (r20 * g30 + r21 * g31 + r22 * g32))
        + noise[8],
        (z * l30 + y * l31 - x * l32 + a * l33)
        + (r30 * (n30 + g30) + r31 * (n31 + g31) + r32 * (n32 + g32))
        + noise[9],
        n00,
        n01,
        n02,
        n10,
        n11,
        n12,
        n20,
        n21,
        n22,
        n30,
        n31,
        n32,
        b00 + drift[0],
        b01,
        b02,
        b11 + drift[1],
        b12,
        b22 + drift[2],
    )


@in_lanes(SEEN(UPPER, QUATERNION_TYPE))
def seen(p: Upper, row: Scalars4) -> Seen:
    """Return P H' of a measurement of the quaternion alone."""
    a, b, c, d = row
    return (
        a * p[0] + b * p[1] + c * p[2] + d * p[3],
        a * p[1] + b * p[4] + c * p[5] + d * p[6],
        a * p[2] + b * p[5] + c * p[7] + d * p[8],
        a * p[3] + b * p[6] + c * p[8] + d * p[9],
        a * p[10] + b * p[13] + c * p[16] + d * p[19],
        a * p[11] + b * p[14] + c * p[17] + d * p[20],
        a * p[12] + b * p[15] + c * p[18] + d * p[21],
    )


@in_lanes(UPPER(UPPER, LANES_TYPE, SEEN))
def lessened(p: Upper, inverse: float, h: Seen) -> Upper:
    """Take h h' times `inverse` from the covariance: a scalar measurement with h = P H' and S = 1 / inverse."""
    h0, h1, h2, h3, h4, h5, h6 = h
    g0 = inverse * h0
    g1 = inverse * h1
    g2 = inverse * h2
    g3 = inverse * h3
    g4 = inverse * h4
    g5 = inverse * h5
    g6 = inverse * h6
    return (
        p[0] - g0 * h0,
        p[1] - g0 * h1,
        p[2] - g0 * h2,
        p[3] - g0 * h3,
        p[4] - g1 * h1,
        p[5] - g1 * h2,
        p[6] - g1 * h3,
        p[7] - g2 * h2,
        p[8] - g2 * h3,
        p[9] - g3 * h3,
        p[10] - g0 * h4,
        p[11] - g0 * h5,
        p[12] - g0 * h6,
        p[13] - g1 * h4,
        p[14] - g1 * h5,
        p[15] - g1 * h6,
        p[16] - g2 * h4,
        p[17] - g2 * h5,
        p[18] - g2 * h6,
        p[19] - g3 * h4,
        p[20] - g3 * h5,
        p[21] - g3 * h6,
        p[22] - g4 * h4,
        p[23] - g4 * h5,
        p[24] - g4 * h6,
        p[25] - g5 * h5,
        p[26] - g5 * h6,
        p[27] - g6 * h6,
    )


@in_lanes(LANES_TYPE(UPPER, LANES_TYPE, LANES_TYPE, LANES_TYPE, LANES_TYPE))
def quadratic(p: Upper, g0: float, g1: float, g2: float, g3: float) -> float:
    """Return g' P g over the quaternion block."""
    first = g0 * (g0 * p[0] + 2.0 * (g1 * p[1] + g2 * p[2] + g3 * p[3]))
    second = g1 * (g1 * p[4] + 2.0 * (g2 * p[5] + g3 * p[6]))
    return first + second + g2 * (g2 * p[7] + 2.0 * g3 * p[8]) + g3 * g3 * p[9]


__all__ = [
    "CROSS",
    "NOISE",
    "SEEN",
    "UPPER",
    "Cross",
    "Upper",
    "keep",
    "lessened",
    "loaded",
    "predicted",
    "quadratic",
    "seen",
]
