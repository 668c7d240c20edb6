"""One foot's sensor, live: the filter's delay, and the way back over the last moments."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.gait._stance import Windows
from estimators.gait.foot import kernel
from estimators.gait.foot import layout as at
from estimators.gait.foot.filter import root, settings_of, start_covariance, start_state
from estimators.gait.foot.kernel import FootState, FootTicks, Trace
from estimators.gait.foot.live.judged import JudgedSamples
from estimators.gait.foot.live.rows import BRIDGED, CLIPPED, MISSING, FootRows, Sizes
from estimators.gait.foot.live.samples import FootSamples
from estimators.gait.foot.lost_places import LostPlace, begin_anew, gap_lengths, long_gap_ticks
from estimators.gait.foot.parameters import FootParameters
from estimators.gait.foot.trajectory import COAST_S, FootFlag
from estimators.recording import Float

TILT_KNOWN_RAD = 0.1
"""Begun in mid-stride or again after a long gap, no stance counts before the vertical is as certain as this: then a
swing of half a second goes wrong by a tenth of a metre."""
_NO_STANCE, _INVALID = int(FootFlag.NO_STANCE), int(FootFlag.INVALID)
_BRIDGED, _SATURATED = int(FootFlag.BRIDGED), int(FootFlag.SATURATED)


class FootStream:
    """The samples of one sensor on their way through detector, filter and fixed-lag smoother.

    All ticks are counted from the start of the stream. Everything is a function of the samples up to a fixed number
    of ticks ahead, so it does not matter in what pieces they come.

    Parameters
    ----------
    rows : FootRows
        Hold everything; `ordinary_kernel` may go on as well where nothing is missing.
    number : int
        Of the foot.
    """

    def __init__(
        self,
        rate_hz: float,
        parameters: FootParameters,
        windows: Windows,
        sizes: Sizes,
        rows: FootRows,
        number: int,
    ) -> None:
        self.rate_hz, self.parameters, self.windows = rate_hz, parameters, windows
        self._sizes, self.block, self.lag = sizes, sizes.block, sizes.lag
        self.samples = FootSamples(rate_hz, parameters, windows, rows, number)
        self.judged = JudgedSamples(rate_hz, parameters, windows, rows, number)
        self.settings = settings_of(parameters)
        self._at: Any = rows.foot[number]
        self._x, self._p, self._memory = rows.x[number], rows.p[number], rows.memory[number]
        self._marks: Any = rows.mark[number]
        self._mark_values = (rows.mark_x[number], rows.mark_p[number], rows.mark_memory[number])
        self._trace = Trace(
            rows.prior[number],
            rows.prior_p[number],
            rows.steps[number],
            rows.row_count[number],
            rows.measured[number],
            rows.gains[number],
            rows.ratios[number],
            rows.posterior[number],
            rows.spread[number],
        )
        self._lost = LostPlace(rate_hz, parameters, rows.lost[number])
        self._long_gap = long_gap_ticks(rate_hz, parameters)
        self._with_field: dict[int, bool] = {}

    def over(self, rows: FootRows, number: int) -> "FootStream":
        """Return the same stream over other rows that hold what its own do."""
        moved = FootStream(self.rate_hz, self.parameters, self.windows, self._sizes, rows, number)
        moved._with_field = self._with_field
        return moved

    @property
    def filtered(self) -> int:
        """Ticks filtered."""
        return int(self._at["filtered"])

    @property
    def released(self) -> int:
        """Ticks given away."""
        return int(self._at["released"])

    @property
    def is_plain(self) -> bool:
        """Whether nothing of a new stretch is still to be released."""
        return not self._with_field

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
            self._at["filtered"] = self.samples.origin

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
            return np.empty((0, at.COLUMNS)), np.empty(0, dtype=np.uint8)
        if first >= 0 and end > max(self.filtered, first):
            self.samples.find_statistic(is_end)
            known = max(first, self._origin + self.judged.count)
            if end > known:
                self.judged.judge(self.samples, known, end)
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
            return np.empty((0, at.COLUMNS)), np.empty(0, dtype=np.uint8)
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
            self._mark(start)
            missing, run = (samples.kind[samples.place(start, stop)] & MISSING) != 0, int(self._at["gap"])
            if run or missing.any():
                gap, block = gap_lengths(missing, run), start
                self._at["gap"] = int(gap[-1]) if missing[-1] else 0
                for again in np.flatnonzero(~missing & (gap >= self._long_gap)).tolist():
                    self._forward(start, block + again)
                    start = block + again
                    self._begin_anew(start, float(gap[again]) / self.rate_hz)
            self._forward(start, stop)
            start = self._at["filtered"] = stop

    def _mark(self, start: int) -> None:
        """Note where the filter stands at the start of a block."""
        count = int(self._at["marks"])
        mark = self._marks[count]
        mark["start"], mark["gap"], mark["wary"] = start, self._at["gap"], self._at["wary"]
        for values, now in zip(self._mark_values, (self._x, self._p, self._memory), strict=True):
            values[count] = now
        self._at["marks"] = count + 1

    def _leave_marks(self, upto: int) -> None:
        """Forget the starts of blocks before the one that holds the first tick not released."""
        count, passed = int(self._at["marks"]), 0
        while passed + 1 < count and self._marks[passed + 1]["start"] <= upto:
            passed += 1
        if passed:
            for values in (self._marks, *self._mark_values):
                values[: count - passed] = values[passed:count].copy()
            self._at["marks"] = count - passed

    def _begin_anew(self, tick: int, gap_s: float) -> None:
        self._with_field[tick] = begin_anew(
            self._x, self._p, self._memory, *self.samples.start(tick), gap_s, self.parameters
        )
        self._at["wary"] = tick + round(self.parameters.reference_before_s * self.rate_hz)

    def _forward(self, start: int, stop: int) -> None:
        if stop == start:
            return
        samples, found = self.samples, self.judged
        place, raw = slice(start - self._origin, stop - self._origin), samples.place(start, stop)
        wary = int(self._at["wary"])
        if start < wary:
            upto = min(stop, wary)
            is_measured = (samples.kind[samples.place(start, upto)] & MISSING) == 0
            found.be_wary(slice(start - self._origin, upto - self._origin), is_measured)
        base = int(self._at["base"])
        kernel.forward(
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
            self.settings,
            FootState(self._memory, self._x, self._p),
            Trace._make(values[base + place.start : base + place.stop] for values in self._trace),
        )

    def _release(self, boundary: int, upto: int) -> tuple[Float, NDArray[np.uint8]]:
        """Smooth back from a boundary and give away the ticks up to `upto`."""
        count = upto - self.released
        values = np.zeros((count, at.COLUMNS))
        values[:, at.Q] = 1.0
        values[:, at.SIGMAS] = np.inf
        flags = np.full(count, _INVALID | _NO_STANCE, dtype=np.uint8)
        first = self.samples.first
        known = max(self.released, first)
        if first >= 0 and upto > known:
            given = upto - known
            place = slice(count - given, count)
            flags[place] = self._smooth(known, boundary, upto, values[place])
            base = int(self._at["base"]) + given
            if base + self.lag + 2 * self.block > len(self._trace.spread):
                for name, records in self._trace._asdict().items():
                    if name != "posterior":
                        records[: boundary - upto] = records[base : base + boundary - upto].copy()
                base = 0
            self._at["base"] = base
            self.judged.forget(given)
        self._at["released"] = upto
        self._leave_marks(upto)
        return values, flags

    def _smooth(self, first: int, boundary: int, upto: int, values: Float) -> NDArray[np.uint8]:
        """Write the ticks `[first, upto)`, judged by those up to a boundary, and return their flags."""
        given = upto - first
        state = np.empty((given, at.STATE))
        base, sigma = int(self._at["base"]), values[:, at.SIGMAS]
        kernel.backward(base, base + given, base + boundary - first, self._trace, np.zeros(at.ERRORS), state)
        values[:, : at.STATE] = state
        sigma[:] = root(self._trace.spread[base : base + given])
        kind = self.samples.kind[self.samples.place(first, upto)]
        is_level = np.asarray((sigma[:, at.SIGMA_ATTITUDE : at.SIGMA_HEADING] < TILT_KNOWN_RAD).all(axis=1))
        stands, last = self._believed(first, self.judged.stands(given), is_level)
        values[:, at.STATISTIC] = self.judged.inputs[1, :given]
        values[:, at.STANDS] = stands
        flags = self._flags(first, last, kind) | self._lost.widen(
            state[:, at.P : at.P + 3], sigma, (kind & MISSING) != 0, first, self._with_field
        )
        self._with_field = {tick: known for tick, known in self._with_field.items() if tick >= upto}
        return flags

    def widen(self, first: int, values: Float, flags: NDArray[np.uint8]) -> None:
        """Add to what compiled code released from a tick on what a long gap before has cost, in place.

        Parameters
        ----------
        values : ndarray, shape (K, COLUMNS)
        flags : ndarray of uint8, shape (K,)
        """
        if self._lost.is_lost:
            sigma = values[:, at.SIGMAS]
            flags |= self._lost.widen(
                values[:, at.P : at.P + 3], sigma, np.zeros(len(flags), dtype=np.bool_), first, {}
            )

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
                self._at["last_stance"] = -1
            before = int(self._at["last_stance"])
            if before < 0:
                stands[piece] &= np.logical_or.accumulate(stands[piece] & is_level[piece])
            ticks = np.arange(first + start, first + stop)
            last[piece] = np.maximum.accumulate(np.where(stands[piece], ticks, before))
            self._at["last_stance"] = last[stop - 1]
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
        needed = min(self.released, self.filtered, self._origin + self.judged.count) - self.windows.back
        # At least a few of the first samples are retained until the filter has started from them.
        start = int(self._marks[0]["start"]) if self._at["marks"] else self.samples.first
        self.samples.forget(min(needed - 1, start))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that later samples depend on; records are made again from it."""
        now, marked = self._at, bool(self._at["marks"])
        if marked:
            mark, (x, p, memory) = self._marks[0].copy(), (values[0] for values in self._mark_values)
        else:
            mark, (x, p, memory) = np.zeros(1, dtype=self._marks.dtype)[0], (self._x, self._p, self._memory)
            mark["start"], mark["gap"], mark["wary"] = now["filtered"], now["gap"], now["wary"]
        counters = [now[n] for n in ("first", "origin", "stop", "filtered", "released", "last_stance")]
        own = {
            "lost": self._lost.memory.copy(),
            "counters": np.array([*counters, *mark.tolist()], dtype=np.int64),
            "x": x.copy(),
            "p": p.copy(),
            "memory": memory.copy(),
        }
        return own | self.samples.state() | self.judged.state()

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state`."""
        first, origin, stop, filtered, released, last_stance, mark, gap, wary = (
            int(v) for v in state["counters"]
        )
        now = self._at
        now["released"], now["last_stance"], now["gap"], now["wary"] = released, last_stance, gap, wary
        self.samples.restore(state, first, origin, stop)
        self.judged.restore(state)
        self._x[:], self._p[:], self._memory[:] = (state[name] for name in ("x", "p", "memory"))
        self._lost.memory[:] = state["lost"]
        self._with_field = {}
        now["marks"] = now["base"] = 0
        now["filtered"] = mark
        if filtered > mark:
            self._filter(filtered)
