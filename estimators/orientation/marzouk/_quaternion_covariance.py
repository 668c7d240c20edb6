"""Covariance of quaternion and offset held in registers, for the quaternion filter of the thesis.

Of the 7 x 7 matrix the 28 numbers of the upper triangle travel as a tuple:
quaternion (10, by rows), cross terms (12, by rows), offset (6). Arrays may overlap as far as the compiler knows, and
every store to one would make it read the others again.
"""

from estimators._kernels import Scalars3, Scalars4, kernel
from estimators.recording import Float

Upper = tuple[float, ...]
"""The 28 numbers."""
Cross = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
Noise = tuple[float, float, float, float, float, float, float, float, float, float]
Seen = tuple[float, float, float, float, float, float, float]

UPPER, CROSS, NOISE, SEEN = (f"UniTuple(float64, {count})" for count in (28, 12, 10, 7))
QUATERNION, VECTOR = "UniTuple(float64, 4)", "UniTuple(float64, 3)"


@kernel(f"{UPPER}(float64[:, ::1])", inlined=True)
def loaded(p: Float) -> Upper:
    """Read the upper triangle of a 7 x 7 matrix."""
    return (
        p[0, 0],
        p[0, 1],
        p[0, 2],
        p[0, 3],
        p[1, 1],
        p[1, 2],
        p[1, 3],
        p[2, 2],
        p[2, 3],
        p[3, 3],
        p[0, 4],
        p[0, 5],
        p[0, 6],
        p[1, 4],
        p[1, 5],
        p[1, 6],
        p[2, 4],
        p[2, 5],
        p[2, 6],
        p[3, 4],
        p[3, 5],
        p[3, 6],
        p[4, 4],
        p[4, 5],
        p[4, 6],
        p[5, 5],
        p[5, 6],
        p[6, 6],
    )


@kernel(f"void(float64[:, ::1], {UPPER})", inlined=True)
def keep(p: Float, upper: Upper) -> None:
    """Write the upper triangle of a 7 x 7 matrix."""
    p[0, 0], p[0, 1], p[0, 2], p[0, 3], p[1, 1], p[1, 2], p[1, 3], p[2, 2], p[2, 3], p[3, 3] = upper[:10]
    p[0, 4], p[0, 5], p[0, 6], p[1, 4], p[1, 5], p[1, 6] = upper[10:16]
    p[2, 4], p[2, 5], p[2, 6], p[3, 4], p[3, 5], p[3, 6] = upper[16:22]
    p[4, 4], p[4, 5], p[4, 6], p[5, 5], p[5, 6], p[6, 6] = upper[22:]


@kernel(f"{UPPER}({UPPER}, {QUATERNION}, {CROSS}, {NOISE}, {VECTOR})", inlined=True)
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


@kernel(f"{SEEN}({UPPER}, {QUATERNION})", inlined=True)
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


@kernel(f"{UPPER}({UPPER}, float64, {SEEN})", inlined=True)
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


@kernel(f"float64({UPPER}, float64, float64, float64, float64)", inlined=True)
def quadratic(p: Upper, g0: float, g1: float, g2: float, g3: float) -> float:
    """Return g' P g over the quaternion block."""
    first = g0 * (g0 * p[0] + 2.0 * (g1 * p[1] + g2 * p[2] + g3 * p[3]))
    second = g1 * (g1 * p[4] + 2.0 * (g2 * p[5] + g3 * p[6]))
    return first + second + g2 * (g2 * p[7] + 2.0 * g3 * p[8]) + g3 * g3 * p[9]


__all__ = [
    "QUATERNION",
    "UPPER",
    "VECTOR",
    "Cross",
    "Upper",
    "keep",
    "lessened",
    "loaded",
    "predicted",
    "quadratic",
    "seen",
]
