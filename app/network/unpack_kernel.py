"""The loop over one packet's values: scales, clip levels, sensors that gave nothing."""

from typing import Any, Final

import numpy as np
from numba.core import types
from numpy.typing import NDArray

from estimators.kernels import borrowing
from estimators.recording import Float, SampleQuality

_MISSING: Final = int(SampleQuality.MISSING)
_SATURATED: Final = int(SampleQuality.SATURATED)


def unpack_python(
    values: NDArray[np.int16] | NDArray[np.float32],
    scales: Float,
    clips: Float,
    levels: Float,
    is_clipped: bool,
    every: int,
    stuck_ticks: int,
    last_sent: Float,
    same_ticks: NDArray[np.int64],
    signals: Float,
    quality: NDArray[np.uint8],
) -> None:
    """Write signals and quality of the next packet, and carry on what tells a sensor that stands still.

    Parameters
    ----------
    values : ndarray of int16 or float32, shape (K, S, W)
        As sent, gyroscope and accelerometer first.
    scales : ndarray, shape (U,)
        SI per unit of the first U of three channels.
    clips : ndarray, shape (2,)
        From which on gyroscope and accelerometer count as clipped, SI.
    levels : ndarray, shape (S, 2, 2, 3)
        The same as found in what each sensor sent: gyroscope and accelerometer, positive and negative side, axis.
    is_clipped : bool
        The device says so.
    every : int
        Quality bits of all samples.
    stuck_ticks : int
        A sensor that repeats itself for so long does not measure.
    last_sent : ndarray, shape (2, S, 3)
        Last values of the packet before, NaN before the first; left at those of this one.
    same_ticks : ndarray of int64, shape (S,)
        For how long each sensor has repeated itself; carried on.
    signals : ndarray, shape (C, S, K, 3)
    quality : ndarray of uint8, shape (S, K)
    """
    ticks, sensors, used = values.shape[0], values.shape[1], scales.shape[0]
    found = False
    for s in range(sensors):
        for c in range(signals.shape[0]):
            for k in range(ticks):
                for a in range(3):
                    signals[c, s, k, a] = values[k, s, 3 * c + a] * scales[c] if c < used else np.nan
        for k in range(ticks):
            flag = every
            for c in range(2):
                for a in range(3):
                    value = signals[c, s, k, a]
                    if abs(value) >= clips[c] or value >= levels[s, c, 0, a] or -value >= levels[s, c, 1, a]:
                        flag |= _SATURATED
                        found = True
            quality[s, k] = flag
    if is_clipped and not found:
        # The device knows that one of its sensors clipped, the values do not say which.
        for s in range(sensors):
            for k in range(ticks):
                quality[s, k] |= _SATURATED
    for s in range(sensors):
        for k in range(ticks):
            zeros = signals[1, s, k, 0] == 0.0 and signals[1, s, k, 1] == 0.0 and signals[1, s, k, 2] == 0.0
            same = True
            for c in range(2):
                for a in range(3):
                    same &= signals[c, s, k, a] == last_sent[c, s, a]
                    last_sent[c, s, a] = signals[c, s, k, a]
            same_ticks[s] = same_ticks[s] + 1 if same else 0
            if zeros or same_ticks[s] >= stuck_ticks:
                quality[s, k] |= _MISSING
                for c in range(signals.shape[0]):
                    for a in range(3):
                        signals[c, s, k, a] = np.nan


def _signature(number: Any) -> Any:
    return types.void(
        types.Array(number, 3, "C", readonly=True),
        types.float64[::1],
        types.float64[::1],
        types.float64[:, :, :, ::1],
        types.boolean,
        types.int64,
        types.int64,
        types.float64[:, :, ::1],
        types.int64[::1],
        types.float64[:, :, :, ::1],
        types.uint8[:, ::1],
    )


unpack = borrowing([_signature(types.int16), _signature(types.float32)], is_entry=True)(unpack_python)
