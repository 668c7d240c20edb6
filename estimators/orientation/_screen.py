"""Samples that cannot be true: values of no device, a rate that leaps alone, and a sensor that repeats itself."""

import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.kernels import borrowing
from estimators.orientation import _frozen
from estimators.orientation._frozen import forget, frozen
from estimators.recording import Float, ImuChunk, SampleQuality

LARGEST_RATE_RADPS: Final = 70.0
"""The widest gyroscopes end at 4000 deg/s."""
LARGEST_FORCE_MPS2: Final = 2000.0
"""The widest accelerometers that people wear end at 200 g."""
LARGEST_FIELD: Final = 1e6
"""In tesla, or in whatever unit a filter is given that asks only for the ratio: larger is no number of a device."""

_LEAP_RADPS: Final = 8.0
_LEAP_STEP_S: Final = 0.01
_LEAP_PER_RATE: Final = 1.5
_LEAP_PER_FORCE: Final = 0.2
_RECENT_S: Final = 0.5
_DOUBTED_S: Final = 0.04

_MISSING = int(SampleQuality.MISSING)
_LAST, _FORCE, _RECENT, _HAS_LAST, _DOUBTS = 0, 3, 6, 7, 8
_FROZEN = 9
MEMORY = _FROZEN + _frozen.MEMORY
"""Per sensor: last rate and force believed, largest recent rate, whether there is a last one, doubted in a row; and
what tells a freeze."""
_SAMPLE, _FIELD = 1, 2
_NO_FIELD: Final = np.empty((0, 0, 3))


@borrowing("void(uint8[::1], int64, float64, int64)")
def _mark_back(wild: NDArray[np.uint8], last: int, count: float, verdict: int) -> None:
    """Mark the last `count` ticks up to and with `last`, as far as they are not marked yet."""
    k, first = last, max(0, last + 1 - int(count))
    while k >= first and wild[k] & verdict == 0:
        wild[k] |= verdict
        k -= 1


@borrowing(
    "int64(float64[:, :, :], float64[:, :, :], float64[:, :, :], uint8[:, :], float64, boolean, float64[:, ::1],"
    "uint8[:, ::1])",
    is_entry=True,
)
def _judge(
    rate_radps: Float,
    force_mps2: Float,
    field_t: Float,
    quality: NDArray[np.uint8],
    step_s: float,
    is_whole: bool,
    memory: Float,
    wild: NDArray[np.uint8],
) -> int:
    """Mark what cannot be used in `wild` (S, K), carry `memory` on, and return how much was marked.

    A freeze is marked from where it is certain, or where these are all ticks, from its first repeated sample.
    """
    found = 0
    keep = math.exp(-step_s / _RECENT_S)
    least = _LEAP_RADPS * max(step_s / _LEAP_STEP_S, 1.0)
    has_field = field_t.shape[0] > 0
    most_doubted = max(math.floor(_DOUBTED_S / step_s + 1e-6), 1)
    for s in range(quality.shape[0]):
        m = memory[s]
        still = memory[s, _FROZEN:]
        for k in range(quality.shape[1]):
            verdict = 0
            largest_rate = largest_force = 0.0
            finite = (quality[s, k] & _MISSING) == 0
            for a in range(3):
                w, f = abs(rate_radps[s, k, a]), abs(force_mps2[s, k, a])
                finite &= math.isfinite(w) and math.isfinite(f)
                largest_rate, largest_force = max(largest_rate, w), max(largest_force, f)
            recent = keep * m[_RECENT]
            m[_RECENT] = recent
            lasts = field_lasts = 0.0
            if finite:
                # Without a magnetometer any three numbers stand for those that are not looked at.
                field = field_t[s, k] if has_field else force_mps2[s, k]
                lasts, field_lasts = frozen(
                    still, rate_radps[s, k], force_mps2[s, k], field, has_field, step_s
                )
            else:
                forget(still)
            if not finite:
                m[_HAS_LAST] = m[_DOUBTS] = 0.0
            elif largest_rate > LARGEST_RATE_RADPS or largest_force > LARGEST_FORCE_MPS2:
                verdict = _SAMPLE
            else:
                leap = jerk = norm = 0.0
                for a in range(3):
                    w = rate_radps[s, k, a]
                    norm += w * w
                    leap += (w - m[_LAST + a]) ** 2
                    jerk += (force_mps2[s, k, a] - m[_FORCE + a]) ** 2
                limit = least + _LEAP_PER_RATE * recent + _LEAP_PER_FORCE * math.sqrt(jerk)
                if m[_HAS_LAST] > 0.0 and leap > limit * limit and m[_DOUBTS] < most_doubted:
                    verdict = _SAMPLE
                    m[_DOUBTS] += 1.0
                else:
                    m[_HAS_LAST], m[_DOUBTS] = 1.0, 0.0
                    m[_RECENT] = max(recent, math.sqrt(norm))
                    for a in range(3):
                        m[_LAST + a] = rate_radps[s, k, a]
                        m[_FORCE + a] = force_mps2[s, k, a]
            if has_field:
                for a in range(3):
                    if abs(field_t[s, k, a]) > LARGEST_FIELD:
                        verdict |= _FIELD
            wild[s, k] = verdict
            if lasts > 0.0 or field_lasts > 0.0:
                _mark_back(wild[s], k, lasts if is_whole else min(lasts, 1.0), _SAMPLE)
                _mark_back(wild[s], k, field_lasts if is_whole else min(field_lasts, 1.0), _FIELD)
            if wild[s, k]:
                found += 1
    return found


class SampleScreen:
    """Takes out of a stream what cannot be true, so that every estimator meets a gap it can bridge and flag.

    A component beyond `LARGEST_RATE_RADPS` or `LARGEST_FORCE_MPS2` is of no device. A rate further from the last
    one believed than

        8 rad/s + 1.5 times the largest rate of the last half second + 0.2 s/m times the change of force

    is lost too. If rates stay so far away for longer than 40 ms, something did begin to turn, and they count. Below
    100 Hz the 8 rad/s grow with the time between samples. Blows come with a leap of the force and fast swings with
    rates before, which is why the limit grows with both: of the public recordings of fast hands, shaken legs, stairs
    and heel strikes none comes nearer to it than 5 rad/s.

    A sensor that repeats itself (`_frozen`) gives nothing either; its magnetometer alone may (`lost_field`).

    Only the past is looked at, so the cut of a stream into chunks cannot matter.

    Parameters
    ----------
    is_whole : bool
        The one chunk is the whole session: a freeze is marked from its first sample on, not from when it was certain.
    """

    def __init__(self, sensor_count: int, time_step_s: float, *, is_whole: bool = False) -> None:
        self._time_step_s, self._is_whole = time_step_s, is_whole
        self.memory = np.zeros((sensor_count, MEMORY))
        self.lost_field: NDArray[np.bool_] | None = None
        """Which samples of the last chunk lost their field alone, shape (S, K); None where none did."""

    def screened(self, chunk: ImuChunk) -> ImuChunk:
        """Return the next ticks with wild samples MISSING, values NaN; the same chunk where there are none."""
        rate = np.asarray(chunk.gyroscope_radps, dtype=np.float64)
        force = np.asarray(chunk.accelerometer_mps2, dtype=np.float64)
        field = chunk.magnetometer_t
        quality = np.asarray(chunk.quality, dtype=np.uint8)
        self.lost_field = None
        wild = np.empty(quality.shape, dtype=np.uint8)
        given = _NO_FIELD if field is None else np.asarray(field, dtype=np.float64)
        if not _judge(rate, force, given, quality, self._time_step_s, self._is_whole, self.memory, wild):
            return chunk
        lost = (wild & _SAMPLE) != 0
        self.lost_field = (wild == _FIELD) if (wild == _FIELD).any() else None
        return replace(
            chunk,
            gyroscope_radps=np.where(lost[..., None], np.nan, rate),
            accelerometer_mps2=np.where(lost[..., None], np.nan, force),
            magnetometer_t=None if field is None else np.where(wild[..., None] != 0, np.nan, given),
            quality=np.where(lost, quality | np.uint8(_MISSING), quality).astype(np.uint8),
        )
