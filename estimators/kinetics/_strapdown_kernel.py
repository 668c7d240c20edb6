"""Rates to orientation, sample by sample: the one loop of the shoe's pose that cannot be vectorised."""

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.recording import Float


@kernel("void(float64[::1], float64[:, ::1], float64, float64[:, ::1])")
def integrate(start: Float, rate_radps: Float, step_s: float, q: Float) -> None:
    """Turn from `start` with the mean rate of neighbouring samples.

    Parameters
    ----------
    start : ndarray, shape (4,)
        `q_room_sensor` of the first sample.
    rate_radps : ndarray, shape (N, 3)
        Sensor axes.
    q : ndarray, shape (N, 4)
        Result.
    """
    half = 0.5 * step_s
    w, x, y, z = start[0], start[1], start[2], start[3]
    q[0, 0], q[0, 1], q[0, 2], q[0, 3] = w, x, y, z
    for i in range(1, rate_radps.shape[0]):
        a, b, c, d = exponential(
            half * (rate_radps[i - 1, 0] + rate_radps[i, 0]),
            half * (rate_radps[i - 1, 1] + rate_radps[i, 1]),
            half * (rate_radps[i - 1, 2] + rate_radps[i, 2]),
        )
        w, x, y, z = multiply(w, x, y, z, a, b, c, d)
        w, x, y, z = normalized(w, x, y, z)
        q[i, 0], q[i, 1], q[i, 2], q[i, 3] = w, x, y, z
