"""Rest: where gyroscope and accelerometer do not vary, the gyroscope reads its offset (A5.6, not published).

The window is made of five blocks; a new verdict comes with each block, and every sample must besides lie
near the mean of the window, so that the first one of a movement is not taken for an offset.
"""

from typing import Final

from estimators.kernels import Fields, Record, step
from estimators.recording import Float
from published._error_state import BASE, absorb

BLOCKS = 5
REST_SETTINGS: Final[Fields] = [
    ("block_ticks", "f8"),  # none: no rest update
    ("rate_limit", "f8"),
    ("force_limit", "f8"),
]
_RATE, _FORCE, _SUMS = 0, 3, 6
# Sums and squares are of rate and force; those of the window stand one block after the other.
REST_STATE: Final[Fields] = [
    ("mean", "f8", _SUMS),
    ("block_sum", "f8", _SUMS),
    ("block_square", "f8", _SUMS),
    ("window_sum", "f8", _SUMS * BLOCKS),
    ("window_square", "f8", _SUMS * BLOCKS),
    ("in_block", "i8"),
    ("blocks", "i8"),
    ("is_quiet", "i8"),
    ("is_at_rest", "i8"),
]
_NEAR = 2.0
"""A sample counts as rest within this many limits (themselves two deviations) of the mean."""


@step()
def judge_block(x: Record, c: Record) -> None:
    """Take the full block into the window and judge the window."""
    slot = _SUMS * (x.blocks % BLOCKS)
    for i in range(_SUMS):
        x.window_sum[slot + i], x.window_square[slot + i] = x.block_sum[i], x.block_square[i]
        x.block_sum[i] = x.block_square[i] = 0.0
    x.in_block = 0
    x.blocks += 1
    if x.blocks < BLOCKS:
        return
    samples = BLOCKS * c.block_ticks
    quiet = True
    for axis in range(_SUMS):
        total = square = 0.0
        for block in range(BLOCKS):
            total += x.window_sum[_SUMS * block + axis]
            square += x.window_square[_SUMS * block + axis]
        mean = total / samples
        x.mean[axis] = mean
        limit = c.rate_limit if axis < _FORCE else c.force_limit
        quiet &= square / samples - mean * mean <= limit * limit
    x.is_quiet = 1 if quiet else 0


@step(inlined=True)
def watch_rest(x: Record, sample: Record, c: Record) -> None:
    """Count this sample and say in `is_at_rest` whether it is one of rest."""
    if c.block_ticks == 0.0:
        return
    for i in range(3):
        rate, force = sample.rate[i], sample.force[i]
        x.block_sum[_RATE + i] += rate
        x.block_square[_RATE + i] += rate * rate
        x.block_sum[_FORCE + i] += force
        x.block_square[_FORCE + i] += force * force
    x.in_block += 1
    if x.in_block >= c.block_ticks:
        judge_block(x, c)
    at_rest = x.is_quiet != 0
    if at_rest:
        for axis in range(3):
            at_rest &= abs(sample.rate[axis] - x.mean[_RATE + axis]) <= _NEAR * c.rate_limit
            at_rest &= abs(sample.force[axis] - x.mean[_FORCE + axis]) <= _NEAR * c.force_limit
    x.is_at_rest = 1 if at_rest else 0


@step()
def forget_rest(x: Record) -> None:
    """Begin a new window, after a start."""
    for i in range(_SUMS):
        x.mean[i] = x.block_sum[i] = x.block_square[i] = 0.0
    for i in range(_SUMS * BLOCKS):
        x.window_sum[i] = x.window_square[i] = 0.0
    x.in_block = x.blocks = x.is_quiet = x.is_at_rest = 0


@step()
def measure_rest(x: Record, p: Float, sample: Record, c: Record, errors: Float, h: Float) -> None:
    """Measure the offset by this sample's rate, axis by axis; `errors` gather what is found."""
    for axis in range(3):
        row = 3 + axis
        for k in range(BASE):
            h[k] = p[min(k, row), max(k, row)]
        inverse = 1.0 / (p[row, row] + c.rate_variance)
        absorb(p, errors, h, x.bias[axis] - sample.rate[axis] - errors[row], inverse, 0.0)
