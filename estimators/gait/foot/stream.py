"""One foot's sensor, live: the filter's delay, and the way back over the last moments."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.gait._stance import Windows
from estimators.gait.foot import layout as at
from estimators.gait.foot.filter import Records, root, settings_of, start_covariance, start_state
from estimators.gait.foot.judged import JudgedSamples
from estimators.gait.foot.kernel import FootState, FootTicks
from estimators.gait.foot.lost_places import LostPlace, begin_anew, gap_lengths, long_gap_ticks
from estimators.gait.foot.parameters import FootParameters
from estimators.gait.foot.samples import BRIDGED, CLIPPED, MISSING, FootSamples
from estimators.gait.foot.trajectory import COAST_S, FootFlag
from estimators.recording import Float

COLUMNS = at.STATE + 6 + 2
"""What is released of a sample: state, sigma of position and attitude, T, and whether it is stance."""
_ROOM = 18
"""Blocks of records beyond the lag, so that they are moved rarely."""
_NO_STANCE, _INVALID = int(FootFlag.NO_STANCE), int(FootFlag.INVALID)
_BRIDGED, _SATURATED = int(FootFlag.BRIDGED), int(FootFlag.SATURATED)
_TILT_KNOWN_RAD = 0.1
"""Begun in mid-stride or anew after a long gap, no stance counts before the vertical is as certain as this: then a
swing of half a second goes wrong by a tenth of a metre."""


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
        self.samples = FootSamples(rate_hz, parameters, self.windows)
        self._found = JudgedSamples(rate_hz, parameters, self.windows)
        self.filtered = 0  # ticks filtered
        self.released = 0
        self._settings = settings_of(parameters)
        self._records = Records(self.lag + _ROOM * self.block)
        self._base = 0  # record of the first tick not yet released
        self._x, self._p, self._memory = np.zeros(at.STATE), np.zeros((at.ERRORS,) * 2), np.zeros(at.MEMORY)
        self._lost = LostPlace(rate_hz, parameters)
        self._long_gap = long_gap_ticks(rate_hz, parameters)
        self._gap = 0  # ticks missing in a row before the first that is not filtered yet
        self._wary = 0  # up to this tick only a foot that surely stands is believed to
        self._with_field: dict[int, bool] = {}
        self._marks: list[tuple[int, Float, Float, Float, tuple[int, int]]] = []
        self._last_stance = -1

    @property
    def delay(self) -> int:
        """Most ticks between a sample and its release."""
        return self.windows.ahead + self.lag + self.block

    @property
    def _origin(self) -> int:
        """Tick of the first judged sample that is not released."""
        return max(self.released, self.samples.first)

    def take(
        self, gyroscope: Float, accelerometer: Float, field: Float | None, kind: NDArray[np.uint8]
    ) -> None:
        """Append samples, each (K, 3), that are measured, bridged or missing."""
        is_before = self.samples.first < 0
        self.samples.take(gyroscope, accelerometer, field, kind)
        if is_before:
            self.filtered = self.samples.origin

    def advance(self, is_end: bool) -> tuple[Float, NDArray[np.uint8]]:
        """Estimate as far as the samples taken allow, and return what is released.

        Returns
        -------
        values : ndarray, shape (K, COLUMNS)
        flags : ndarray of uint8, shape (K,)
            K is at most the ticks since the last call plus the delay, and does not depend on the samples.
        """
        first, taken = self.samples.first, self.samples.stop
        end = taken if is_end else max(taken - self.windows.ahead, 0)
        values, flags = [], []
        if not is_end and end < self.released + self.lag + self.block:
            return np.empty((0, COLUMNS)), np.empty(0, dtype=np.uint8)
        if first >= 0 and end > max(self.filtered, first):
            self.samples.find_statistic(is_end)
            known = max(first, self._origin + len(self._found.bits))
            if end > known:
                self._found.judge(self.samples, known, end)
        while self.released < taken:
            boundary = self.released + self.lag + self.block
            if boundary > end:
                if not is_end:
                    break
                boundary = end
            upto = taken if is_end and boundary == end else boundary - self.lag
            if first >= 0 and boundary > first:
                self._filter(boundary)
            piece, marks = self._release(boundary, upto)
            values.append(piece)
            flags.append(marks)
        self._trim()
        if not values:
            return np.empty((0, COLUMNS)), np.empty(0, dtype=np.uint8)
        return np.concatenate(values), np.concatenate(flags)

    def _filter(self, boundary: int) -> None:
        """Run the filter up to a boundary."""
        samples = self.samples
        start = max(self.filtered, samples.first)
        if start == samples.first and not self._memory[at.STARTED]:
            force, statistic = samples.start(start)
            self._x[:] = start_state(force, np.zeros(3))
            self._p[:] = start_covariance(statistic, self.parameters)
        while start < boundary:
            # Block by block, so that a stored state can start again at the first sample not yet released.
            stop = min(start + self.block - start % self.block, boundary)
            mark = (self._gap, self._wary)
            self._marks.append((start, self._x.copy(), self._p.copy(), self._memory.copy(), mark))
            missing = (samples.kind[samples.place(start, stop)] & MISSING) != 0
            if self._gap or missing.any():
                gap, block = gap_lengths(missing, self._gap), start
                self._gap = int(gap[-1]) if missing[-1] else 0
                for again in np.flatnonzero(~missing & (gap >= self._long_gap)).tolist():
                    self._forward(start, block + again)
                    start = block + again
                    self._begin_anew(start, float(gap[again]) / self.rate_hz)
            self._forward(start, stop)
            start = self.filtered = stop

    def _begin_anew(self, tick: int, gap_s: float) -> None:
        self._with_field[tick] = begin_anew(
            self._x, self._p, self._memory, *self.samples.start(tick), gap_s, self.parameters
        )
        self._wary = tick + round(self.parameters.reference_before_s * self.rate_hz)

    def _forward(self, start: int, stop: int) -> None:
        if stop == start:
            return
        samples, found = self.samples, self._found
        place, raw = slice(start - self._origin, stop - self._origin), samples.place(start, stop)
        if start < self._wary:
            upto = min(stop, self._wary)
            is_measured = (samples.kind[samples.place(start, upto)] & MISSING) == 0
            found.be_wary(slice(start - self._origin, upto - self._origin), is_measured)
        self._records.forward(
            slice(self._base + place.start, self._base + place.stop),
            FootTicks(
                np.full(stop - start, 1.0 / self.rate_hz),
                samples.gyroscope[raw],
                samples.force[raw],
                found.inputs[0, place],
                found.bits[place],
                found.inputs[2, place],
                found.rate_variance[place],
                samples.field[raw],
            ),
            self._settings,
            FootState(self._memory, self._x, self._p),
        )

    def _release(self, boundary: int, upto: int) -> tuple[Float, NDArray[np.uint8]]:
        """Smooth back from a boundary and give away the ticks up to `upto`."""
        count = upto - self.released
        values = np.zeros((count, COLUMNS))
        values[:, at.Q] = 1.0
        values[:, at.STATE : at.STATE + 6] = np.inf
        flags = np.full(count, _INVALID | _NO_STANCE, dtype=np.uint8)
        first = self.samples.first
        known = max(self.released, first)
        if first >= 0 and upto > known:
            given = upto - known
            place = slice(count - given, count)
            flags[place] = self._smooth(known, boundary, upto, values[place])
            self._base += given
            if self._base + self.lag + 2 * self.block > len(self._records.trace.spread):
                self._records.move_to_front(self._base, self._base + boundary - upto)
                self._base = 0
            self._found.forget(given)
        self.released = upto
        while len(self._marks) > 1 and self._marks[1][0] <= upto:
            self._marks.pop(0)
        return values, flags

    def _smooth(self, first: int, boundary: int, upto: int, values: Float) -> NDArray[np.uint8]:
        """Write the ticks `[first, upto)`, judged by those up to a boundary, and return their flags."""
        given = upto - first
        state = np.empty((given, at.STATE))
        base, sigma = self._base, values[:, at.STATE : at.STATE + 6]
        self._records.backward(base, base + given, base + boundary - first, np.zeros(at.ERRORS), state)
        values[:, : at.STATE] = state
        sigma[:] = root(self._records.trace.spread[base : base + given])
        kind = self.samples.kind[self.samples.place(first, upto)]
        is_level = np.asarray((sigma[:, 3:5] < _TILT_KNOWN_RAD).all(axis=1))
        stands, last = self._believed(first, self._found.stands(given), is_level)
        values[:, at.STATE + 6] = self._found.inputs[1, :given]
        values[:, at.STATE + 7] = stands
        flags = self._flags(first, last, kind) | self._lost.widen(
            state[:, at.P : at.P + 3], sigma, (kind & MISSING) != 0, first, self._with_field
        )
        self._with_field = {tick: known for tick, known in self._with_field.items() if tick >= upto}
        return flags

    def _believed(
        self, first: int, stands: NDArray[np.bool_], is_level: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Return which stances count, and the tick of the last one up to each sample, -1 where there is none.

        At the start of the record, and of a new stretch after a long gap, none does before one has shown the
        vertical: what was integrated till then went astray by metres.
        """
        last = np.empty(len(stands), dtype=np.int64)
        begins = {tick - first for tick in self._with_field if first <= tick < first + len(stands)}
        starts = sorted({0} | begins)
        for start, stop in zip(starts, [*starts[1:], len(stands)], strict=True):
            piece = slice(start, stop)
            if start in begins:
                self._last_stance = -1
            if self._last_stance < 0:
                stands[piece] &= np.logical_or.accumulate(stands[piece] & is_level[piece])
            ticks = np.arange(first + start, first + stop)
            last[piece] = np.maximum.accumulate(np.where(stands[piece], ticks, self._last_stance))
            self._last_stance = int(last[stop - 1])
        return stands, last

    def _flags(self, first: int, last: NDArray[np.int64], kind: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the flags of the ticks from `first` on, given the last stance up to each."""
        ticks = np.arange(first, first + len(last))
        flags = ((last < 0) | (ticks - last > COAST_S * self.rate_hz)) * np.uint8(_NO_STANCE)
        if kind.any():
            flags = flags + ((kind & MISSING) != 0) * np.uint8(_INVALID)
            flags = flags + ((kind & BRIDGED) != 0) * np.uint8(_BRIDGED)
            flags = flags + ((kind & CLIPPED) != 0) * np.uint8(_SATURATED)
        return np.asarray(flags, dtype=np.uint8)

    def _trim(self) -> None:
        """Forget samples that nothing to come looks back at."""
        if self.samples.first < 0:
            return
        needed = min(self.released, self.filtered, self._origin + len(self._found.bits)) - self.windows.back
        # At least a few of the first samples are retained until the filter has started from them.
        self.samples.forget(min(needed - 1, self._marks[0][0] if self._marks else self.samples.first))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that later samples depend on; records are made again from it."""
        mark = (
            self._marks[0]
            if self._marks
            else (self.filtered, self._x, self._p, self._memory, (self._gap, self._wary))
        )
        counters = (
            self.samples.first,
            self.samples.origin,
            self.samples.stop,
            self.filtered,
            self.released,
            self._last_stance,
            mark[0],
            *mark[4],
        )
        own = {
            "lost": self._lost.memory.copy(),
            "counters": np.array(counters, dtype=np.int64),
            "x": mark[1].copy(),
            "p": mark[2].copy(),
            "memory": mark[3].copy(),
        }
        return own | self.samples.state() | self._found.state()

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state`."""
        first, origin, stop, filtered, self.released, self._last_stance, mark, self._gap, self._wary = (
            int(v) for v in state["counters"]
        )
        self.samples.restore(state, first, origin, stop)
        self._found.restore(state)
        self._x, self._p, self._memory = (np.array(state[name]) for name in ("x", "p", "memory"))
        self._lost.memory = np.array(state["lost"])
        self._marks, self._base, self._with_field = [], 0, {}
        self.filtered = mark
        if filtered > mark:
            self._filter(filtered)


__all__ = ["COLUMNS", "FootStream"]
