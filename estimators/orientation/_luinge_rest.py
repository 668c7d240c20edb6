"""Rest: where gyroscope and accelerometer do not vary, the gyroscope reads its offset (A5.6, not published).

The window is made of five blocks; a new verdict comes with each block, and every sample must besides lie
near the mean of the window, so that the first one of a movement is not taken for an offset.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.orientation import _strapdown_steps as steps
from estimators.recording import Float

BLOCKS = 5
_SUMS = 12

# Columns of the memory after the shared ones: six means, sums and squares of the block, those of the window.
MEAN = steps.MEMORY
BLOCK = MEAN + 6
WINDOW = BLOCK + _SUMS
MEMORY = WINDOW + BLOCKS * _SUMS

# Columns of the counters after the shared ones.
IN_BLOCK, BLOCKS_KEPT, QUIET, AT_REST = range(steps.COUNTERS, steps.COUNTERS + 4)
COUNTERS = steps.COUNTERS + 4

# Positions in the settings after the shared ones and the variance of inclination. No ticks: no rest update.
BLOCK_TICKS, RATE_LIMIT, FORCE_LIMIT = range(steps.SHARED_SETTINGS + 1, steps.SHARED_SETTINGS + 4)

# Numba freezes globals, not attributes of modules.
_RATE, _FORCE, _RATE_VARIANCE = steps.RATE, steps.FORCE, steps.RATE_VARIANCE
_NEAR = 2.0
"""A sample counts as rest within this many limits (themselves two deviations) of the mean."""


@kernel("void(int64, float64[::1], float64[:, ::1], int64[:, ::1])")
def judge_block(s: int, settings: Float, memory: Float, counters: NDArray[np.int64]) -> None:
    """Take the full block into the window and judge the window."""
    kept, count = memory[s], counters[s]
    slot = WINDOW + (count[BLOCKS_KEPT] % BLOCKS) * _SUMS
    for i in range(_SUMS):
        kept[slot + i] = kept[BLOCK + i]
        kept[BLOCK + i] = 0.0
    count[IN_BLOCK] = 0
    count[BLOCKS_KEPT] += 1
    if count[BLOCKS_KEPT] < BLOCKS:
        return
    samples = BLOCKS * settings[BLOCK_TICKS]
    quiet = True
    for axis in range(6):
        total = square = 0.0
        for block in range(BLOCKS):
            total += kept[WINDOW + block * _SUMS + axis]
            square += kept[WINDOW + block * _SUMS + 6 + axis]
        mean = total / samples
        kept[MEAN + axis] = mean
        limit = settings[RATE_LIMIT] if axis < 3 else settings[FORCE_LIMIT]
        quiet &= square / samples - mean * mean <= limit * limit
    count[QUIET] = 1 if quiet else 0


@kernel("void(int64, float64[::1], float64[::1], float64[:, ::1], int64[:, ::1])", inlined=True)
def watch_rest(s: int, sample: Float, settings: Float, memory: Float, counters: NDArray[np.int64]) -> None:
    """Count this sample and say in `AT_REST` whether it is one of rest."""
    if settings[BLOCK_TICKS] == 0.0:
        return
    for i in range(6):
        value = sample[_RATE + i]
        memory[s, BLOCK + i] += value
        memory[s, BLOCK + 6 + i] += value * value
    counters[s, IN_BLOCK] += 1
    if counters[s, IN_BLOCK] >= settings[BLOCK_TICKS]:
        judge_block(s, settings, memory, counters)
    at_rest = counters[s, QUIET] != 0
    if at_rest:
        rate_limit, force_limit = _NEAR * settings[RATE_LIMIT], _NEAR * settings[FORCE_LIMIT]
        for axis in range(3):
            at_rest &= abs(sample[_RATE + axis] - memory[s, MEAN + axis]) <= rate_limit
            at_rest &= abs(sample[_FORCE + axis] - memory[s, MEAN + 3 + axis]) <= force_limit
    counters[s, AT_REST] = 1 if at_rest else 0


@kernel("void(int64, float64[:, ::1], int64[:, ::1])")
def forget_rest(s: int, memory: Float, counters: NDArray[np.int64]) -> None:
    """Begin a new window, after a start."""
    for i in range(MEAN, MEMORY):
        memory[s, i] = 0.0
    for i in range(IN_BLOCK, COUNTERS):
        counters[s, i] = 0


@kernel("void(float64[:, ::1], int64, float64[:, ::1], float64[::1], float64[::1], float64[::1])")
def measure_rest(bias: Float, s: int, p: Float, sample: Float, settings: Float, error: Float) -> None:
    """Measure the offset by this sample's rate, axis by axis; the errors found are left in `error` (6)."""
    for j in range(6):
        error[j] = 0.0
    for axis in range(3):
        row = 3 + axis
        inverse = 1.0 / (p[row, row] + settings[_RATE_VARIANCE])
        gain = inverse * (bias[s, axis] - sample[_RATE + axis] - error[row])
        column = (p[0, row], p[1, row], p[2, row], p[3, row], p[min(4, row), max(4, row)], p[row, 5])
        for i, h in enumerate(column):
            error[i] += h * gain
            for j, other in enumerate(column):
                if j >= i:
                    p[i, j] -= inverse * h * other


__all__ = [
    "AT_REST",
    "BLOCK_TICKS",
    "COUNTERS",
    "FORCE_LIMIT",
    "MEAN",
    "MEMORY",
    "RATE_LIMIT",
    "forget_rest",
    "measure_rest",
    "watch_rest",
]
