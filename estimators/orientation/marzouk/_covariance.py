"""Covariance of attitude and offset errors held in scalars, for the two quaternion filters of the thesis.

The attitude error is a small rotation of the earth frame U, `truth = Exp(xi) estimate`, and the offset error that
of the sensor's axes. A turn of the sensor leaves xi alone, so that prediction is `xi' = xi - Ts R b`, and tilt,
heading and the angles of the thesis read few of its components.

The 21 numbers of the upper triangle travel as a tuple: attitude (6), cross terms by rows (9), offset (6). Arrays
may overlap as far as the compiler knows, and every store to one would make it read the others again.
"""

from estimators._kernels import Scalars3, Scalars4, kernel, multiply
from estimators.kernels import turn
from estimators.recording import Float

Upper = tuple[float, ...]
"""The 21 numbers."""
Row = tuple[float, float, float, float, float, float, float, float, float]
Errors = tuple[float, float, float, float, float, float]

UPPER, ROW, ERRORS = "UniTuple(float64, 21)", "UniTuple(float64, 9)", "UniTuple(float64, 6)"
_TURNED = f"Tuple((UniTuple(float64, 4), {ROW}))"


@kernel(f"{UPPER}(float64[:, ::1])", inlined=True)
def loaded(p: Float) -> Upper:
    """Read the upper triangle of a 6 x 6 matrix."""
    return (
        p[0, 0],
        p[0, 1],
        p[0, 2],
        p[1, 1],
        p[1, 2],
        p[2, 2],
        p[0, 3],
        p[0, 4],
        p[0, 5],
        p[1, 3],
        p[1, 4],
        p[1, 5],
        p[2, 3],
        p[2, 4],
        p[2, 5],
        p[3, 3],
        p[3, 4],
        p[3, 5],
        p[4, 4],
        p[4, 5],
        p[5, 5],
    )


@kernel(f"void(float64[:, ::1], {UPPER})", inlined=True)
def keep(p: Float, upper: Upper) -> None:
    """Write the upper triangle of a 6 x 6 matrix."""
    p[0, 0], p[0, 1], p[0, 2], p[1, 1], p[1, 2], p[2, 2] = upper[:6]
    p[0, 3], p[0, 4], p[0, 5], p[1, 3], p[1, 4], p[1, 5], p[2, 3], p[2, 4], p[2, 5] = upper[6:15]
    p[3, 3], p[3, 4], p[3, 5], p[4, 4], p[4, 5], p[5, 5] = upper[15:]


@kernel(f"{_TURNED}(UniTuple(float64, 4), float64, float64, float64, float64)", inlined=True)
def turned_by_rate(q: Scalars4, rx: float, ry: float, rz: float, step_s: float) -> tuple[Scalars4, Row]:
    """Turn an attitude by a rate over a step; also return Ts R of the new one, by rows."""
    tw, tx, ty, tz = turn(rx * step_s, ry * step_s, rz * step_s)
    w, x, y, z = multiply(q[0], q[1], q[2], q[3], tw, tx, ty, tz)
    # One Newton step keeps the norm: it is off by rounding only.
    norm = 1.5 - 0.5 * (w * w + x * x + y * y + z * z)
    w, x, y, z = w * norm, x * norm, y * norm, z * norm
    a, b, c = 2.0 * step_s * x, 2.0 * step_s * y, 2.0 * step_s * z
    xx, yy, zz, xy, xz, yz = a * x, b * y, c * z, a * y, a * z, b * z
    wx, wy, wz = a * w, b * w, c * w
    return (w, x, y, z), (
        step_s - yy - zz,
        xy - wz,
        xz + wy,
        xy + wz,
        step_s - xx - zz,
        yz - wx,
        xz - wy,
        yz + wx,
        step_s - xx - yy,
    )


@kernel(f"{UPPER}({UPPER}, {ROW}, {ERRORS}, UniTuple(float64, 3))", inlined=True)
def predicted(p: Upper, turned: Row, noise: Errors, drift: Scalars3) -> Upper:
    """P' = F P F' + Q with F = [[I, -Ts R], [0, I]]; `noise` is the upper triangle of its attitude block.

    Written as P_xx' = P_xx - (Ts R) C' - N (Ts R)', with C the old and N the new cross terms.
    """
    (
        a00,
        a01,
        a02,
        a11,
        a12,
        a22,
        c00,
        c01,
        c02,
        c10,
        c11,
        c12,
        c20,
        c21,
        c22,
        b00,
        b01,
        b02,
        b11,
        b12,
        b22,
    ) = p
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turned
    n00 = c00 - (r00 * b00 + r01 * b01 + r02 * b02)
    n01 = c01 - (r00 * b01 + r01 * b11 + r02 * b12)
    n02 = c02 - (r00 * b02 + r01 * b12 + r02 * b22)
    n10 = c10 - (r10 * b00 + r11 * b01 + r12 * b02)
    n11 = c11 - (r10 * b01 + r11 * b11 + r12 * b12)
    n12 = c12 - (r10 * b02 + r11 * b12 + r12 * b22)
    n20 = c20 - (r20 * b00 + r21 * b01 + r22 * b02)
    n21 = c21 - (r20 * b01 + r21 * b11 + r22 * b12)
    n22 = c22 - (r20 * b02 + r21 * b12 + r22 * b22)
    return (
        # The sums C + N of the diagonal save three products each.
        a00 + (noise[0] - (r00 * (c00 + n00) + r01 * (c01 + n01) + r02 * (c02 + n02))),
        a01 + (noise[1] - (r00 * c10 + r01 * c11 + r02 * c12) - (r10 * n00 + r11 * n01 + r12 * n02)),
        a02 + (noise[2] - (r00 * c20 + r01 * c21 + r02 * c22) - (r20 * n00 + r21 * n01 + r22 * n02)),
        a11 + (noise[3] - (r10 * (c10 + n10) + r11 * (c11 + n11) + r12 * (c12 + n12))),
        a12 + (noise[4] - (r10 * c20 + r11 * c21 + r12 * c22) - (r20 * n10 + r21 * n11 + r22 * n12)),
        a22 + (noise[5] - (r20 * (c20 + n20) + r21 * (c21 + n21) + r22 * (c22 + n22))),
        n00,
        n01,
        n02,
        n10,
        n11,
        n12,
        n20,
        n21,
        n22,
        b00 + drift[0],
        b01,
        b02,
        b11 + drift[1],
        b12,
        b22 + drift[2],
    )


@kernel(f"{UPPER}({UPPER}, float64, {ERRORS})", inlined=True)
def lessened(p: Upper, inverse: float, h: Errors) -> Upper:
    """Take h h' times `inverse` from the covariance: a scalar measurement with h = P H' and S = 1 / inverse."""
    h0, h1, h2, h3, h4, h5 = h
    g0, g1, g2, g3, g4, g5 = (
        inverse * h0,
        inverse * h1,
        inverse * h2,
        inverse * h3,
        inverse * h4,
        inverse * h5,
    )
    return (
        p[0] - g0 * h0,
        p[1] - g0 * h1,
        p[2] - g0 * h2,
        p[3] - g1 * h1,
        p[4] - g1 * h2,
        p[5] - g2 * h2,
        p[6] - g0 * h3,
        p[7] - g0 * h4,
        p[8] - g0 * h5,
        p[9] - g1 * h3,
        p[10] - g1 * h4,
        p[11] - g1 * h5,
        p[12] - g2 * h3,
        p[13] - g2 * h4,
        p[14] - g2 * h5,
        p[15] - g3 * h3,
        p[16] - g3 * h4,
        p[17] - g3 * h5,
        p[18] - g4 * h4,
        p[19] - g4 * h5,
        p[20] - g5 * h5,
    )


@kernel(f"{ERRORS}({UPPER}, float64, float64, float64)", inlined=True)
def seen(p: Upper, x: float, y: float, z: float) -> Errors:
    """Return P H' of a measurement of the attitude error alone, row (x, y, z)."""
    return (
        x * p[0] + y * p[1] + z * p[2],
        x * p[1] + y * p[3] + z * p[4],
        x * p[2] + y * p[4] + z * p[5],
        x * p[6] + y * p[9] + z * p[12],
        x * p[7] + y * p[10] + z * p[13],
        x * p[8] + y * p[11] + z * p[14],
    )


__all__ = [
    "ERRORS",
    "ROW",
    "UPPER",
    "Errors",
    "Row",
    "Upper",
    "keep",
    "lessened",
    "loaded",
    "predicted",
    "seen",
    "turned_by_rate",
]
