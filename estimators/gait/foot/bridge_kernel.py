"""How far a bridge over lost samples may be wrong, compiled: known from how the samples beside it change."""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.recording import Float

BESIDE_S = 0.05
"""How far beside a bridge the signals tell how fast they change."""


@kernel(
    "void(float64[:, ::1], float64[:, ::1], boolean[::1], boolean[::1], int64, int64, int64, int64,"
    " float64, float64[::1], float64[:, ::1])"
)
def add_bridge_noise(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    is_bridged: NDArray[np.bool_],
    is_filled: NDArray[np.bool_],
    first: int,
    stop: int,
    width: int,
    lag: int,
    step_s: float,
    force_variance: Float,
    rate_variance: Float,
) -> None:
    """Add to the noise densities squared of the samples `[first, stop)` what a bridge leaves open.

    Own: a signal that changes by at most j from sample to sample strays by j sqrt(n) over a bridge of n steps, all
    in one direction: a density squared of j^2 n D for its length D. In stance that is next to nothing, across an
    impact it is all there is.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
    is_bridged, is_filled : ndarray of bool, shape (N,)
        Samples that stand on a bridge; samples that were not measured for whatever reason.
    first, stop, width : int
        `width` samples on both sides of the bridge are looked at; bridges are followed for four times as many.
    lag : int
        Samples from one that the device took to the next; others between them stand in for a faster device.
    step_s : float
        From one to the next that the device took.
    force_variance : ndarray, shape (stop - first,)
        Added to, (m/s)^2/s.
    rate_variance : ndarray, shape (stop - first, 3)
        Added to, rad^2/s.
    """
    last = gyroscope_radps.shape[0] - 1
    longest = 4 * width
    for k in range(first, stop):
        if not is_bridged[k]:
            continue
        low, high = k, k
        while low > 0 and is_filled[low] and k - low < longest:
            low -= 1
        while high < last and is_filled[high] and high - k < longest:
            high += 1
        steps = float(high - low) / lag
        grown = steps * steps * step_s
        jolt = 0.0
        for axis in range(3):
            turning = 0.0
            for j in range(max(low - width, 0) + lag, min(high + width, last) + 1):
                if not (is_filled[j] or is_filled[j - lag]):
                    turning = max(turning, abs(gyroscope_radps[j, axis] - gyroscope_radps[j - lag, axis]))
                    jolt = max(jolt, abs(accelerometer_mps2[j, axis] - accelerometer_mps2[j - lag, axis]))
            rate_variance[k - first, axis] += turning * turning * grown
        force_variance[k - first] += jolt * jolt * grown
