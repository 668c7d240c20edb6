"""The loops of the improved centre of mass: a three-state Kalman filter for x and y, and its smoother.

State of one axis: position, velocity and error of the acceleration. Both axes have the same noise and so
share one covariance.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, step
from estimators.recording import Float

STATES = 3
STEP, FORCE2, BIAS2, ANCHOR2, STANDING2, STARTED, LAST, SETTINGS = 0, 1, 2, 3, 4, 5, 6, 8
"""Settings: the step, variance densities of acceleration, of its error and of the anchor, variance of "standing",
whether anything was seen yet, and the last acceleration of x and y."""


@step("void(float64[:, ::1], float64, float64, float64, float64[:, ::1])", inlined=True)
def _predict_covariance(p: Float, h: float, force_variance: float, bias_variance: float, out: Float) -> None:
    """Return F P F' + Q for F = [[1, h, -h^2/2], [0, 1, -h], [0, 0, 1]]."""
    g = -0.5 * h * h
    a0 = p[0, 0] + h * p[1, 0] + g * p[2, 0]
    a1 = p[0, 1] + h * p[1, 1] + g * p[2, 1]
    a2 = p[0, 2] + h * p[1, 2] + g * p[2, 2]
    b1 = p[1, 1] - h * p[2, 1]
    b2 = p[1, 2] - h * p[2, 2]
    out[0, 0] = a0 + h * a1 + g * a2 + force_variance * h * h * h / 3.0
    out[0, 1] = a1 - h * a2 + force_variance * h * h / 2.0
    out[0, 2] = a2
    out[1, 1] = b1 - h * b2 + force_variance * h
    out[1, 2] = b2
    out[2, 2] = p[2, 2] + bias_variance * h
    out[1, 0] = out[0, 1]
    out[2, 0] = out[0, 2]
    out[2, 1] = out[1, 2]


@step("void(float64[:, ::1], float64[:, ::1], int64, float64, float64, float64)", inlined=True)
def _measure(x: Float, p: Float, row: int, value_x: float, value_y: float, variance: float) -> None:
    """Update both axes with a direct measurement of one state."""
    total = p[row, row] + variance
    k0, k1, k2 = p[0, row] / total, p[1, row] / total, p[2, row] / total
    for axis in range(2):
        rest = (value_x if axis == 0 else value_y) - x[axis, row]
        x[axis, 0] += k0 * rest
        x[axis, 1] += k1 * rest
        x[axis, 2] += k2 * rest
    r0, r1, r2 = p[row, 0], p[row, 1], p[row, 2]
    p[0, 0] -= k0 * r0
    p[0, 1] -= k0 * r1
    p[0, 2] -= k0 * r2
    p[1, 1] -= k1 * r1
    p[1, 2] -= k1 * r2
    p[2, 2] -= k2 * r2
    p[1, 0] = p[0, 1]
    p[2, 0] = p[0, 2]
    p[2, 1] = p[1, 2]


@kernel(
    "void(float64[::1], float64[:, ::1], float64[:, ::1], uint8[::1], float64[:, ::1], float64[:, ::1],"
    " float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1])"
)
def forward(
    settings: Float,
    acceleration: Float,
    anchor: Float,
    bits: NDArray[np.uint8],
    x: Float,
    p: Float,
    predicted: Float,
    predicted_covariance: Float,
    filtered: Float,
    filtered_covariance: Float,
) -> None:
    """Run the filter over a chunk; `x`, `p` and the last two of `settings` go on from call to call.

    Parameters
    ----------
    settings : ndarray, shape (SETTINGS,)
    acceleration, anchor : ndarray, shape (K, 2)
    bits : ndarray of uint8, shape (K,)
        1: the anchor may be used; 2: the person stands.
    x : ndarray, shape (2, 3)
    p : ndarray, shape (3, 3)
    predicted, filtered : ndarray, shape (K, 2, 3)
    predicted_covariance, filtered_covariance : ndarray, shape (K, 3, 3)
        Results.
    """
    h = settings[STEP]
    for i in range(acceleration.shape[0]):
        if settings[STARTED] > 0.0:
            # The acceleration between two samples is taken for linear, as the trapezoids of (4.6) do.
            for axis in range(2):
                before, now = settings[LAST + axis], acceleration[i, axis]
                error = x[axis, 2]
                x[axis, 0] += h * x[axis, 1] + h * h * (before / 3.0 + now / 6.0 - 0.5 * error)
                x[axis, 1] += h * (0.5 * (before + now) - error)
            _predict_covariance(p, h, settings[FORCE2], settings[BIAS2], filtered_covariance[i])
            for r in range(3):
                for c in range(3):
                    p[r, c] = filtered_covariance[i, r, c]
        elif bits[i] & 1:
            x[0, 0], x[1, 0] = anchor[i, 0], anchor[i, 1]
            settings[STARTED] = 1.0
        settings[LAST], settings[LAST + 1] = acceleration[i, 0], acceleration[i, 1]
        for axis in range(2):
            for r in range(3):
                predicted[i, axis, r] = x[axis, r]
        for r in range(3):
            for c in range(3):
                predicted_covariance[i, r, c] = p[r, c]
        if bits[i] & 1:
            _measure(x, p, 0, anchor[i, 0], anchor[i, 1], settings[ANCHOR2] / h)
        if bits[i] & 2:
            _measure(x, p, 1, 0.0, 0.0, settings[STANDING2] / h)
        for axis in range(2):
            for r in range(3):
                filtered[i, axis, r] = x[axis, r]
        for r in range(3):
            for c in range(3):
                filtered_covariance[i, r, c] = p[r, c]
