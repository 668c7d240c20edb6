"""Whether the gains of a gyroscope are those of a good device: two hypotheses on their spread."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators.kernels import Record, borrowing
from estimators.orientation.telemotion._block import INNOVATION, VARIANCE, absorb
from estimators.orientation.telemotion._records import GAIN, STATES
from estimators.recording import Float

_GAINS = 9
_SURE = math.log(9.0)
"""Log odds from which the good device is believed."""


@borrowing()
def settle_gains(
    p: Float,
    error: Float,
    rows: Float,
    memory: Record,
    index: NDArray[np.int64],
    value: Float,
    settings: Record,
    work: Float,
) -> None:
    """Once turning has shown that the gains are small, take that they were drawn from the narrow spread.

    The filter runs with the wide spread W. The narrow one, N, is one more measurement of each gain, zero, of variance
    1 / (1 / N - 1 / W); its likelihood against the wide one follows from the same numbers, one gain after another.
    """
    wide, narrow = settings.gain, settings.gain_narrow
    variance = 1.0 / (1.0 / narrow - 1.0 / wide)
    shift = _GAINS * _GAINS
    for i in range(_GAINS):
        source = STATES * (GAIN + i) + GAIN
        for j in range(_GAINS):
            work[_GAINS * i + j] = p[source + j]
        work[shift + i] = memory.gain[i] + error[GAIN + i]
    odds = 0.0
    for m in range(_GAINS):
        row = _GAINS * m
        inverse = 1.0 / (work[row + m] + variance)
        innovation = -work[shift + m]
        odds += 0.5 * (math.log(wide / narrow * variance * inverse) - innovation * innovation * inverse)
        for i in range(m + 1, _GAINS):
            factor = work[_GAINS * i + m] * inverse
            work[shift + i] += factor * innovation
            for j in range(m + 1, _GAINS):
                work[_GAINS * i + j] -= factor * work[row + j]
    if odds < _SURE:
        return
    memory.gains_settled = 1
    for first in range(0, _GAINS, 3):
        for a in range(3):
            index[a, 0], value[a, 0] = GAIN + first + a, 1.0
            rows[INNOVATION, a] = -memory.gain[first + a]
            rows[VARIANCE, a] = variance
        absorb(p, error, rows, index, value, 1)
