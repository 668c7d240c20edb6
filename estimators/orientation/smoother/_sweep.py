"""Sums of blocks along a known trajectory: what our own smoother works on, sensor by sensor."""

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.kernels import VOID, Record, rows
from estimators.orientation.telemotion._records import (
    BIAS,
    DELAY,
    GAIN,
    OFFSET,
    SAMPLE,
    SETTINGS,
    STATE,
    SUMS,
)
from estimators.orientation.telemotion._samples import clear_sums, integrate
from estimators.recording import Float

_F1, _F2 = types.float64[::1], types.float64[:, ::1]


@kernel(VOID(rows(SAMPLE), types.int64, _F2, _F1, _F1, _F2, numba.from_dtype(SETTINGS), rows(SUMS), _F2, _F2))
def sweep(
    samples: NDArray[np.void],
    block_ticks: int,
    q_ends: Float,
    q_first: Float,
    constants: Float,
    iron: Float,
    settings: Record,
    sums: NDArray[np.void],
    q_open: Float,
    q_nominal: Float,
) -> None:
    """Turn through the samples, from the known attitude at the start of every block, and sum up the blocks.

    Parameters
    ----------
    samples : ndarray of SAMPLE, shape (K,)
    q_ends : ndarray, shape (B, 4)
        Attitude at the end of each block, where the next begins.
    q_first : ndarray, shape (4,)
    constants : ndarray, shape (STATES,)
        Nominal bias, gain and delay, in place.
    iron : ndarray, shape (B, 3)
        Nominal hard iron in each block.
    sums : ndarray of SUMS, shape (B,)
        Filled.
    q_open : ndarray, shape (B, 4)
        Filled: where the turn through a block arrives, before `q_ends`.
    q_nominal : ndarray, shape (K, 4)
        Filled: the attitude at every sample.
    """
    states = np.zeros(1, STATE)
    x = states[0]
    x.q[:] = q_first
    x.bias[:] = constants[BIAS : BIAS + 3]
    x.gain[:] = constants[GAIN : GAIN + 9]
    x.delay = constants[DELAY]
    x.force_offset[:] = constants[OFFSET : OFFSET + 3]
    for block in range(q_ends.shape[0]):
        clear_sums(sums[block])
        x.iron[:] = iron[block]
        for k in range(block * block_ticks, min((block + 1) * block_ticks, samples.shape[0])):
            integrate(x, sums[block], samples[k], settings)
            for i in range(4):
                q_nominal[k, i] = x.q[i]
        for i in range(4):
            q_open[block, i] = x.q[i]
            x.q[i] = q_ends[block, i]


@kernel("void(float64[:, ::1], float64[:, ::1], float64[:, ::1], int64)")
def turn_on(q_nominal: Float, opening: Float, closing: Float, block_ticks: int) -> None:
    """Turn every sample of a trajectory by the error of its time, in place.

    `opening` and `closing`, shape (B, 3), are the errors at both ends of each block, rad; between them
    the error is taken as linear in time.
    """
    for k in range(q_nominal.shape[0]):
        block = k // block_ticks
        after = (k - block * block_ticks + 1.0) / min(block_ticks, q_nominal.shape[0] - block * block_ticks)
        before = 1.0 - after
        tw, tx, ty, tz = exponential(
            before * opening[block, 0] + after * closing[block, 0],
            before * opening[block, 1] + after * closing[block, 1],
            before * opening[block, 2] + after * closing[block, 2],
        )
        q = q_nominal[k]
        w, x, y, z = multiply(tw, tx, ty, tz, q[0], q[1], q[2], q[3])
        q[0], q[1], q[2], q[3] = normalized(w, x, y, z)
