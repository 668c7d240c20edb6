"""How the module is turned before markers tell: strapdown alone, and level by gravity."""

import numpy as np

from estimators import orientation, rotation
from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.recording import Float, ImuChunk


@kernel("void(float64[:, ::1], float64, float64[:, ::1])")
def integrate(gyroscope_radps: Float, time_step_s: float, q: Float) -> None:
    """Turn on from `q[0]` with the mean rate of neighbouring samples; a missing one counts as rest."""
    for k in range(1, len(q)):
        w = np.empty(3)
        for i in range(3):
            value = 0.5 * time_step_s * (gyroscope_radps[k - 1, i] + gyroscope_radps[k, i])
            w[i] = value if np.isfinite(value) else 0.0
        turn = exponential(w[0], w[1], w[2])
        c = multiply(q[k - 1, 0], q[k - 1, 1], q[k - 1, 2], q[k - 1, 3], turn[0], turn[1], turn[2], turn[3])
        c = normalized(c[0], c[1], c[2], c[3])
        q[k, 0], q[k, 1], q[k, 2], q[k, 3] = c


def strapdown(gyroscope_radps: Float, time_step_s: float) -> Float:
    """Return the attitude of a sensor relative to its first sample, shape (K, 4); it drifts."""
    q = np.empty((len(gyroscope_radps), 4))
    q[:1] = rotation.identity()
    integrate(np.ascontiguousarray(gyroscope_radps, dtype=np.float64), time_step_s, q)
    return q


def level_attitude(
    gyroscope_radps: Float, accelerometer_mps2: Float, time_step_s: float
) -> tuple[Float, Float]:
    """Return attitude level by gravity, any heading, and gyroscope bias; shapes (K, 4) and (K, 3)."""
    chunk = ImuChunk(
        0,
        time_step_s,
        np.ascontiguousarray(gyroscope_radps[None]),
        np.ascontiguousarray(accelerometer_mps2[None]),
        None,
        np.zeros((1, len(gyroscope_radps)), np.uint8),
    )
    # Both ways: a filter alone is tilted for seconds when it begins amid movement.
    found = orientation.smooth("telemotion_smoother", chunk).orientation
    return found.q_earth_sensor[0], found.gyroscope_bias_radps[0]
