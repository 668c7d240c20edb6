"""One foot's sensor, live: buffers, the filter's delay, and the way back over the last moments."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.gait import _foot_layout as at
from estimators.gait._foot_filter import (
    START_S,
    Records,
    root,
    settings_of,
    start_covariance,
    start_state,
)
from estimators.gait._foot_parameters import FootParameters
from estimators.gait._foot_trajectory import COAST_S, LOST_SIGMA_MPS, FootFlag
from estimators.gait._stance import UNREST, Windows, judge, noise, write_statistic
from estimators.recording import Float

BRIDGED, MISSING, CLIPPED, FIELD = 1, 2, 4, 8
"""What there is to say of a sample: how it came about, and whether a magnetic field came with it."""

COLUMNS = at.STATE + 6 + 2
"""What is released of a sample: state, sigma of position and attitude, T, and whether it is stance."""
_RAW = 9
_ROOM = 18
"""Blocks of records beyond the lag, so that they are moved rarely."""
_NO_STANCE, _INVALID = int(FootFlag.NO_STANCE), int(FootFlag.INVALID)
_BRIDGED, _SATURATED = int(FootFlag.BRIDGED), int(FootFlag.SATURATED)
_UPRIGHT = np.array([0.0, 0.0, GRAVITY_MPS2])


class FootStream:
    """The samples of one sensor on their way through detector, filter and fixed-lag smoother.

    All ticks are counted from the start of the stream. Everything is a function of the samples up to a fixed number
    of ticks ahead, so it does not matter in what pieces they come.

    Parameters
    ----------
    rate_hz : float
    parameters : FootParameters
    """

    def __init__(self, rate_hz: float, parameters: FootParameters) -> None:
        self.rate_hz, self.parameters = rate_hz, parameters
        self.windows = Windows.at_rate(rate_hz, parameters)
        self.block = max(1, round(parameters.release_s * rate_hz))
        self.lag = self.block * max(1, round(parameters.lag_s / parameters.release_s))
        self._settings = settings_of(parameters)
        self._records = Records(self.lag + _ROOM * self.block)
        self._base = 0  # record of the first tick not yet released
        self.first = -1  # no measured sample yet
        self.origin = 0  # tick of the first buffered sample
        self.stop = 0  # ticks taken
        self.judged = 0  # ticks filtered
        self.released = 0
        self._raw = np.empty((0, _RAW))
        self._kind = np.empty(0, dtype=np.uint8)
        self._statistic = np.empty(0)
        self._last_good = _UPRIGHT.copy()
        # Judged and not yet released: standard deviation, bits, T, noise of force (1) and turning (3).
        self._inputs = np.empty((0, 7))
        self._x, self._p, self._memory = np.zeros(at.STATE), np.zeros((at.ERRORS,) * 2), np.zeros(at.MEMORY)
        self._marks: list[tuple[int, Float, Float, Float]] = []
        self._last_stance = -1

    @property
    def delay(self) -> int:
        """Most ticks between a sample and its release."""
        return self.windows.ahead + self.lag + self.block

    def take(
        self, gyroscope: Float, accelerometer: Float, field: Float | None, kind: NDArray[np.uint8]
    ) -> None:
        """Append samples, each (K, 3), that are measured, bridged or missing."""
        count = len(kind)
        raw = np.zeros((count, _RAW))
        raw[:, 0:3], raw[:, 3:6] = gyroscope, accelerometer
        if field is not None:
            has_field = np.isfinite(field).all(axis=1)
            raw[has_field, 6:9] = field[has_field]
            kind = np.asarray(kind | has_field * np.uint8(FIELD))
        is_missing = (kind & MISSING) != 0
        if is_missing.any():
            for k in np.flatnonzero(is_missing):
                if k and not is_missing[k - 1]:
                    self._last_good = accelerometer[k - 1] * (
                        GRAVITY_MPS2 / max(float(np.linalg.norm(accelerometer[k - 1])), 1.0)
                    )
                raw[k, 0:3], raw[k, 3:6] = 0.0, self._last_good
        if count and not is_missing[-1]:
            norm = max(float(np.linalg.norm(accelerometer[-1])), 1.0)
            self._last_good = accelerometer[-1] * (GRAVITY_MPS2 / norm)
        if self.first < 0:
            measured = np.flatnonzero(~is_missing)
            skipped = int(measured[0]) if len(measured) else count
            raw, kind = raw[skipped:], kind[skipped:]
            self.stop += skipped
            self.origin = self.judged = self.stop
            if len(measured):
                self.first = self.stop
        self._raw = np.concatenate([self._raw, raw])
        self._kind = np.concatenate([self._kind, kind])
        self.stop += len(kind)

    def advance(self, is_end: bool) -> tuple[Float, NDArray[np.uint8]]:
        """Estimate as far as the samples taken allow, and return what is released.

        Returns
        -------
        values : ndarray, shape (K, COLUMNS)
        flags : ndarray of uint8, shape (K,)
            K is at most the ticks since the last call plus the delay, and does not depend on the samples.
        """
        end = self.stop if is_end else max(self.stop - self.windows.ahead, 0)
        values, flags = [], []
        if not is_end and end < self.released + self.lag + self.block:
            return np.empty((0, COLUMNS)), np.empty(0, dtype=np.uint8)
        if self.first >= 0 and end > max(self.judged, self.first):
            self._find(end, is_end)
        while self.released < self.stop:
            boundary = self.released + self.lag + self.block
            if boundary > end:
                if not is_end:
                    break
                boundary = end
            upto = self.stop if is_end and boundary == end else boundary - self.lag
            if self.first >= 0 and boundary > self.first:
                self._filter(boundary)
            piece, marks = self._release(boundary, upto)
            values.append(piece)
            flags.append(marks)
        self._trim()
        if not values:
            return np.empty((0, COLUMNS)), np.empty(0, dtype=np.uint8)
        return np.concatenate(values), np.concatenate(flags)

    def _find(self, end: int, is_end: bool) -> None:
        """Bring detector and noise up to tick `end`."""
        known = self.origin + len(self._statistic)
        stop = self.stop if is_end else self.stop - self.windows.half
        if stop > known:
            grown = np.empty(stop - self.origin)
            grown[: len(self._statistic)] = self._statistic
            gyroscope = np.ascontiguousarray(self._raw[:, 0:3])
            force = np.ascontiguousarray(self._raw[:, 3:6])
            missing = (self._kind & MISSING) != 0
            span = (known - self.origin, stop - self.origin)
            write_statistic(gyroscope, force, missing, *span, self.windows, self.parameters, grown)
            self._statistic = grown
        first = max(self.first, self.origin_of_inputs + len(self._inputs))
        if end <= first:
            return
        # Nothing beyond the ticks that every chunking has seen may count.
        horizon = min(len(self._statistic), end - self.origin + self.windows.ahead - self.windows.half)
        found = judge(
            self._statistic[:horizon], self.origin, first, end, self.rate_hz, self.windows, self.parameters
        )
        near = np.clip(np.arange(first - 1, end + 1) - self.origin, 0, len(self._raw) - 1)
        force_variance, rate_variance = noise(
            self._raw[near, 0:3], self._raw[near, 3:6], self._gap_s(first, end), self.parameters
        )
        inputs = np.empty((end - first, 7))
        bits, sigma = found.bits, found.sigma_mps.copy()
        has_field = self._kind[first - self.origin : end - self.origin] & FIELD != 0
        bits = np.asarray(bits | (has_field & found.is_stance) * np.uint8(at.HEADING))
        missing = (self._kind[first - self.origin : end - self.origin] & MISSING) != 0
        bits[missing] = at.STANCE
        sigma[missing] = LOST_SIGMA_MPS
        inputs[:, 0], inputs[:, 1], inputs[:, 2] = sigma, bits, found.statistic
        inputs[:, 3], inputs[:, 4:7] = force_variance, rate_variance
        self._inputs = np.concatenate([self._inputs, inputs])

    @property
    def origin_of_inputs(self) -> int:
        """Tick of the first judged sample that is kept."""
        return max(self.released, self.first)

    def _gap_s(self, first: int, end: int) -> Float:
        """Return for ticks `[first - 1, end]` the length of the gap they fill, as far as may be known."""
        filled = (self._kind & (BRIDGED | MISSING)) != 0
        if not filled.any():
            return np.zeros(end + 2 - first)
        count = len(filled)
        places = np.arange(count)
        before = places - np.maximum.accumulate(np.where(filled, -1, places))
        ahead = np.minimum.accumulate(np.where(filled, count, places)[::-1])[::-1] - places
        # Every chunking has seen `ahead` ticks further than the one judged, and kept `back` before it.
        length = np.where(
            filled,
            np.minimum(before, self.windows.back) + np.minimum(ahead - 1, self.windows.half),
            0,
        )
        near = np.clip(np.arange(first - 1, end + 1) - self.origin, 0, count - 1)
        return np.asarray(length[near] / self.rate_hz)

    def _filter(self, boundary: int) -> None:
        """Run the filter up to a boundary."""
        start = max(self.judged, self.first)
        if start == self.first and not self._memory[at.STARTED]:
            count = max(1, round(START_S * self.rate_hz))
            head = slice(self.first - self.origin, self.first - self.origin + count)
            self._x[:] = start_state(self._raw[head, 3:6].mean(axis=0), np.zeros(3))
            self._p[:] = start_covariance(float(self._statistic[head].mean()), self.parameters)
        while start < boundary:
            # Block by block, so that a stored state can start again at the first sample not yet released.
            stop = min(start + self.block - start % self.block, boundary)
            self._marks.append((start, self._x.copy(), self._p.copy(), self._memory.copy()))
            self._forward(start, stop)
            start = self.judged = stop

    def _forward(self, start: int, stop: int) -> None:
        origin = self.origin_of_inputs
        inputs = self._inputs[start - origin : stop - origin]
        raw = self._raw[start - self.origin : stop - self.origin]
        bits = inputs[:, 1].astype(np.uint8)
        self._records.forward(
            slice(self._base + start - origin, self._base + stop - origin),
            np.full(stop - start, 1.0 / self.rate_hz),
            np.ascontiguousarray(raw[:, 0:3]),
            np.ascontiguousarray(raw[:, 3:6]),
            np.ascontiguousarray(inputs[:, 0]),
            bits,
            np.ascontiguousarray(inputs[:, 3]),
            np.ascontiguousarray(inputs[:, 4:7]),
            np.ascontiguousarray(raw[:, 6:9]),
            self._settings,
            self._memory,
            self._x,
            self._p,
        )
        inputs[:, 1] = bits

    def _release(self, boundary: int, upto: int) -> tuple[Float, NDArray[np.uint8]]:
        """Smooth back from a boundary and give away the ticks up to `upto`."""
        count = upto - self.released
        values = np.zeros((count, COLUMNS))
        values[:, at.Q] = 1.0
        values[:, at.STATE : at.STATE + 6] = np.inf
        flags = np.full(count, _INVALID | _NO_STANCE, dtype=np.uint8)
        known = max(self.released, self.first)
        if self.first >= 0 and upto > known:
            origin = self.origin_of_inputs
            given = upto - known
            state = np.empty((given, at.STATE))
            base, end = self._base, self._base + boundary - origin
            self._records.backward(base, base + given, end, np.zeros(at.ERRORS), state)
            inputs = self._inputs[: boundary - origin]
            place = slice(count - given, count)
            values[place, : at.STATE] = state
            values[place, at.STATE : at.STATE + 6] = root(self._records.spread[base : base + given])
            values[place, at.STATE + 6] = inputs[:given, 2]
            values[place, at.STATE + 7] = _stands(inputs[:given])
            kind = self._kind[known - self.origin : upto - self.origin]
            flags[place] = self._flags(known, upto, inputs, kind)
            self._base += given
            if self._base + self.lag + 2 * self.block > len(self._records.spread):
                self._records.move_to_front(self._base, end)
                self._base = 0
            self._inputs = self._inputs[given:]
        self.released = upto
        while len(self._marks) > 1 and self._marks[1][0] <= upto:
            self._marks.pop(0)
        return values, flags

    def _flags(self, first: int, stop: int, inputs: Float, kind: NDArray[np.uint8]) -> NDArray[np.uint8]:
        missing = (kind & MISSING) != 0
        stands = _stands(inputs)
        ticks = np.arange(first, first + len(stands))
        last = np.maximum.accumulate(np.where(stands, ticks, self._last_stance))[: stop - first]
        lost = (last < 0) | (ticks[: stop - first] - last > COAST_S * self.rate_hz)
        self._last_stance = int(last[-1])
        flags = lost * _NO_STANCE + missing * _INVALID
        flags = flags + ((kind & BRIDGED) != 0) * _BRIDGED + ((kind & CLIPPED) != 0) * _SATURATED
        return np.asarray(flags, dtype=np.uint8)

    def _trim(self) -> None:
        """Forget samples that nothing to come looks back at."""
        if self.first < 0:
            return
        needed = (
            min(self.released, self.judged, self.origin_of_inputs + len(self._inputs)) - self.windows.back
        )
        # At least a few of the first samples are kept until the filter has started from them.
        drop = min(needed - 1, self._marks[0][0] if self._marks else self.first) - self.origin
        if drop > 0:
            self._raw, self._kind = self._raw[drop:], self._kind[drop:]
            self._statistic = self._statistic[drop:]
            self.origin += drop

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that later samples depend on; records are made again from it."""
        mark = self._marks[0] if self._marks else (self.judged, self._x, self._p, self._memory)
        counters = (
            self.first,
            self.origin,
            self.stop,
            self.judged,
            self.released,
            self._last_stance,
            mark[0],
        )
        return {
            "counters": np.array(counters, dtype=np.int64),
            "raw": self._raw.copy(),
            "kind": self._kind.copy(),
            "statistic": self._statistic.copy(),
            "inputs": self._inputs.copy(),
            "last_good": self._last_good.copy(),
            "x": mark[1].copy(),
            "p": mark[2].copy(),
            "memory": mark[3].copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state`."""
        first, origin, stop, judged, released, last_stance, mark = (int(v) for v in state["counters"])
        self.first, self.origin, self.stop, self.released = first, origin, stop, released
        self._last_stance = last_stance
        self._raw, self._kind = np.array(state["raw"]), np.array(state["kind"])
        self._statistic, self._inputs = np.array(state["statistic"]), np.array(state["inputs"])
        self._last_good = np.array(state["last_good"])
        self._x, self._p, self._memory = (np.array(state[name]) for name in ("x", "p", "memory"))
        self._marks, self._base = [], 0
        self.judged = mark
        if judged > mark:
            self._filter(judged)


def _stands(inputs: Float) -> NDArray[np.bool_]:
    return np.asarray(((inputs[:, 1].astype(np.uint8) & at.STANCE) != 0) & (inputs[:, 2] < UNREST))


__all__ = ["BRIDGED", "CLIPPED", "COLUMNS", "MISSING", "FootStream"]
