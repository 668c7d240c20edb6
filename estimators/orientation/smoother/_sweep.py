"""Sums of blocks along a known trajectory: what our own smoother works on, sensor by sensor."""

import numpy as np

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.orientation.telemotion._layout import (
    BIAS,
    COUNT,
    COUNTERS,
    DELAY,
    FIELD_COUNT,
    GAIN,
    GAP_SPEED_VARIANCE,
    IRON,
    MEMORY,
    SAMPLE,
    SUM_ROTATION,
)
from estimators.orientation.telemotion._samples import clear_sums, integrate
from estimators.recording import Float

SUMS = GAP_SPEED_VARIANCE + 3 - SUM_ROTATION


@kernel(
    "void(float64[:, ::1], int64, float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])"
)
def sweep(
    samples: Float,
    block_ticks: int,
    q_ends: Float,
    q_first: Float,
    constants: Float,
    iron: Float,
    settings: Float,
    sums: Float,
    parts: Float,
    q_open: Float,
    q_nominal: Float,
) -> None:
    """Turn through the samples, from the known attitude at the start of every block, and sum up the blocks.

    Parameters
    ----------
    samples : ndarray, shape (K, SAMPLE)
    q_ends : ndarray, shape (B, 4)
        Attitude at the end of each block, where the next begins.
    q_first : ndarray, shape (4,)
    constants : ndarray, shape (STATES,)
        Nominal bias, gain and delay, in place.
    iron : ndarray, shape (B, 3)
        Nominal hard iron in each block.
    sums, parts : ndarray, shape (B, SUMS) and (B, 2)
        Filled: the sums, and how many samples and samples with field they hold.
    q_open : ndarray, shape (B, 4)
        Filled: where the turn through a block arrives, before `q_ends`.
    q_nominal : ndarray, shape (K, 4)
        Filled: the attitude at every sample.
    """
    memory, counts = np.zeros(MEMORY), np.zeros(COUNTERS, dtype=np.int64)
    bias, q = constants[BIAS : BIAS + 3].copy(), q_first.copy()
    for i in range(GAIN, GAIN + 9):
        memory[i] = constants[i]
    memory[DELAY] = constants[DELAY]
    for block in range(q_ends.shape[0]):
        clear_sums(memory, counts)
        for a in range(3):
            memory[IRON + a] = iron[block, a]
        for k in range(block * block_ticks, min((block + 1) * block_ticks, samples.shape[0])):
            integrate(q, bias, memory, counts, samples[k, :SAMPLE], settings)
            for i in range(4):
                q_nominal[k, i] = q[i]
        for i in range(SUMS):
            sums[block, i] = memory[SUM_ROTATION + i]
        parts[block, 0], parts[block, 1] = counts[COUNT], counts[FIELD_COUNT]
        for i in range(4):
            q_open[block, i] = q[i]
            q[i] = q_ends[block, i]


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


__all__ = ["SUMS", "sweep", "turn_on"]
