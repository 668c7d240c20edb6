"""Prediction and scalar correction of orientation and offset errors, shared by the compiled filters.

The state begins with the orientation error in the earth frame, estimate = Exp(xi) truth, and the offset error
in the sensor frame. Of the covariance only the upper triangle is kept up to date inside a loop over ticks;
`mirror` completes it.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._strapdown_steps import start_variance, turn
from estimators.recording import Float

Row = tuple[float, float, float, float, float, float, float, float, float]
"""Nine numbers: a matrix by rows, or a column of the covariance."""

# Numba freezes globals, not attributes of modules.
_RATE, _GAP_VARIANCE = steps.RATE, steps.GAP_VARIANCE
_STEP_S, _RATE_VARIANCE, _BIAS_VARIANCE = steps.STEP_S, steps.RATE_VARIANCE, steps.BIAS_VARIANCE
_ACCELERATION, _STARTED, _COLLECTED = steps.ACCELERATION, steps.STARTED, steps.COLLECTED
_RUNNING, _UNKNOWN = steps.RUNNING, steps.UNKNOWN


@kernel(
    "UniTuple(float64, 9)(float64[:, ::1], float64[:, ::1], int64, float64[::1], float64[::1])", inlined=True
)
def turn_by_rate(q: Float, bias: Float, s: int, sample: Float, settings: Float) -> Row:
    """Turn the estimate by the rate of the sample (A3) and return T R by rows."""
    step = settings[_STEP_S]
    tw, tx, ty, tz = turn(
        (sample[_RATE] - bias[s, 0]) * step,
        (sample[_RATE + 1] - bias[s, 1]) * step,
        (sample[_RATE + 2] - bias[s, 2]) * step,
    )
    w, x, y, z = multiply(q[s, 0], q[s, 1], q[s, 2], q[s, 3], tw, tx, ty, tz)
    # One Newton step keeps the norm: it is off by rounding only.
    norm = 1.5 - 0.5 * (w * w + x * x + y * y + z * z)
    w, x, y, z = w * norm, x * norm, y * norm, z * norm
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = w, x, y, z
    a, b, c = 2.0 * step * x, 2.0 * step * y, 2.0 * step * z
    xx, yy, zz, xy, xz, yz = a * x, b * y, c * z, a * y, a * z, b * z
    wx, wy, wz = a * w, b * w, c * w
    return (
        step - yy - zz,
        xy - wz,
        xz + wy,
        xy + wz,
        step - xx - zz,
        yz - wx,
        xz - wy,
        yz + wx,
        step - xx - yy,
    )


@kernel("void(float64[:, ::1], UniTuple(float64, 9), float64[::1], float64[::1])", inlined=True)
def predict_covariance(
    p: Float,
    turned: Row,
    sample: Float,
    settings: Float,
) -> None:
    """P' = F P F' + Q with F = [[I, -T R], [0, I]] over orientation and offset (A5.1).

    Written as P_xx' = P_xx - (T R) C' - N (T R)', with C the old and N the new cross covariance.
    """
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turned
    step = settings[_STEP_S]
    b00, b01, b02, b11, b12, b22 = p[3, 3], p[3, 4], p[3, 5], p[4, 4], p[4, 5], p[5, 5]
    c00, c01, c02 = p[0, 3], p[0, 4], p[0, 5]
    c10, c11, c12 = p[1, 3], p[1, 4], p[1, 5]
    c20, c21, c22 = p[2, 3], p[2, 4], p[2, 5]
    n00 = c00 - (r00 * b00 + r01 * b01 + r02 * b02)
    n01 = c01 - (r00 * b01 + r01 * b11 + r02 * b12)
    n02 = c02 - (r00 * b02 + r01 * b12 + r02 * b22)
    n10 = c10 - (r10 * b00 + r11 * b01 + r12 * b02)
    n11 = c11 - (r10 * b01 + r11 * b11 + r12 * b12)
    n12 = c12 - (r10 * b02 + r11 * b12 + r12 * b22)
    n20 = c20 - (r20 * b00 + r21 * b01 + r22 * b02)
    n21 = c21 - (r20 * b01 + r21 * b11 + r22 * b12)
    n22 = c22 - (r20 * b02 + r21 * b12 + r22 * b22)
    noise = settings[_RATE_VARIANCE] * step * step + sample[_GAP_VARIANCE]
    # The sums C + N of the diagonal save three products each.
    p[0, 0] += noise - (r00 * (c00 + n00) + r01 * (c01 + n01) + r02 * (c02 + n02))
    p[1, 1] += noise - (r10 * (c10 + n10) + r11 * (c11 + n11) + r12 * (c12 + n12))
    p[2, 2] += noise - (r20 * (c20 + n20) + r21 * (c21 + n21) + r22 * (c22 + n22))
    p[0, 1] -= (r00 * c10 + r01 * c11 + r02 * c12) + (r10 * n00 + r11 * n01 + r12 * n02)
    p[0, 2] -= (r00 * c20 + r01 * c21 + r02 * c22) + (r20 * n00 + r21 * n01 + r22 * n02)
    p[1, 2] -= (r10 * c20 + r11 * c21 + r12 * c22) + (r20 * n10 + r21 * n11 + r22 * n12)
    p[0, 3], p[0, 4], p[0, 5] = n00, n01, n02
    p[1, 3], p[1, 4], p[1, 5] = n10, n11, n12
    p[2, 3], p[2, 4], p[2, 5] = n20, n21, n22
    drift = settings[_BIAS_VARIANCE]
    p[3, 3], p[4, 4], p[5, 5] = b00 + drift, b11 + drift, b22 + drift


@kernel(
    "void(float64[:, ::1], float64, float64, float64, float64, float64, float64, float64)",
    inlined=True,
)
def lessen(
    p: Float, inverse: float, h0: float, h1: float, h2: float, h3: float, h4: float, h5: float
) -> None:
    """Take h h' times `inverse` from the upper triangle of the first six states."""
    g = inverse * h0
    p[0, 0] -= g * h0
    p[0, 1] -= g * h1
    p[0, 2] -= g * h2
    p[0, 3] -= g * h3
    p[0, 4] -= g * h4
    p[0, 5] -= g * h5
    g = inverse * h1
    p[1, 1] -= g * h1
    p[1, 2] -= g * h2
    p[1, 3] -= g * h3
    p[1, 4] -= g * h4
    p[1, 5] -= g * h5
    g = inverse * h2
    p[2, 2] -= g * h2
    p[2, 3] -= g * h3
    p[2, 4] -= g * h4
    p[2, 5] -= g * h5
    g = inverse * h3
    p[3, 3] -= g * h3
    p[3, 4] -= g * h4
    p[3, 5] -= g * h5
    g = inverse * h4
    p[4, 4] -= g * h4
    p[4, 5] -= g * h5
    p[5, 5] -= inverse * h5 * h5


@kernel(
    "void(float64[:, ::1], float64[:, ::1], int64, float64, float64, float64, float64, float64, float64)",
    inlined=True,
)
def inject(
    q: Float, bias: Float, s: int, e0: float, e1: float, e2: float, e3: float, e4: float, e5: float
) -> None:
    """Take the estimated errors out of the estimate: R = Exp(-xi) R, b = b - b_e (A5.4)."""
    tw, tx, ty, tz = turn(-e0, -e1, -e2)
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = multiply(tw, tx, ty, tz, q[s, 0], q[s, 1], q[s, 2], q[s, 3])
    bias[s, 0] -= e3
    bias[s, 1] -= e4
    bias[s, 2] -= e5


@kernel("void(int64, float64[:, ::1], float64[:, ::1], int64[:, ::1], float64[::1])")
def begin(s: int, p: Float, memory: Float, counters: NDArray[np.int64], settings: Float) -> None:
    """Set the start covariance (A2.3), apart from that of the offset; after a gap the heading may be anything."""
    variance = start_variance(s, memory, counters, settings)
    for i in range(3):
        for j in range(p.shape[0]):
            p[i, j] = p[j, i] = 0.0
        p[i, i] = variance
        memory[s, _ACCELERATION + i] = 0.0
    if counters[s, _STARTED] > counters[s, _COLLECTED]:
        p[2, 2] = _UNKNOWN
    counters[s, _RUNNING] = 1


@kernel("void(float64[:, ::1])")
def mirror(p: Float) -> None:
    """Copy the upper triangle to the lower."""
    for i in range(p.shape[0]):
        for j in range(i):
            p[i, j] = p[j, i]


__all__ = ["Row", "begin", "inject", "lessen", "mirror", "predict_covariance", "turn_by_rate"]
