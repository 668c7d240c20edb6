"""One foot's sensor, live: buffers, the filter's delay, and the way back over the last moments."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.gait import _foot_layout as at
from estimators.gait._bridge_kernel import BESIDE_S, add_bridge_noise
from estimators.gait._cut_off import CutOffAxes
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
from estimators.gait._lost_places import LostPlace, begin_anew, gap_lengths, long_gap_ticks
from estimators.gait._stance import (
    NOT_CUT_OFF,
    UNREST,
    Windows,
    decide,
    decision_settings,
    noise_settings,
    write_statistic,
)
from estimators.gait._stance_kernel import noise_densities
from estimators.recording import Float

BRIDGED, MISSING, CLIPPED, FIELD = 1, 2, 4, 8
"""What there is to say of a sample: how it came about, and whether a magnetic field came with it; the bits above are
those of the axes that were cut off (`CutOffAxes`)."""

COLUMNS = at.STATE + 6 + 2
"""What is released of a sample: state, sigma of position and attitude, T, and whether it is stance."""
_ALL_MEASURED = np.empty(0)
_ROOM = 18
"""Blocks of records beyond the lag, so that they are moved rarely."""
_NO_STANCE, _INVALID = int(FootFlag.NO_STANCE), int(FootFlag.INVALID)
_BRIDGED, _SATURATED = int(FootFlag.BRIDGED), int(FootFlag.SATURATED)
_UPRIGHT = np.array([0.0, 0.0, GRAVITY_MPS2])
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
        self._settings = settings_of(parameters)
        self._records = Records(self.lag + _ROOM * self.block)
        self._base = 0  # record of the first tick not yet released
        self.first = -1  # no measured sample yet
        self.origin = 0  # tick of the first buffered sample
        self.stop = 0  # ticks taken
        self.judged = 0  # ticks filtered
        self.released = 0
        self._gyroscope, self._force, self._field = (np.empty((0, 3)) for _ in range(3))
        self._kind = np.empty(0, dtype=np.uint8)
        self._statistic = np.empty(0)
        self._last_good = _UPRIGHT.copy()
        self._cut_off = CutOffAxes()
        # Judged and not yet released: standard deviation, T, noise of force; bits; noise of turning.
        self._inputs = np.empty((3, 0))
        self._bits = np.empty(0, dtype=np.uint8)
        self._rate_variance = np.empty((0, 3))
        self._decision = decision_settings(rate_hz, parameters)
        self._noise = noise_settings(parameters)
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

    def take(
        self, gyroscope: Float, accelerometer: Float, field: Float | None, kind: NDArray[np.uint8]
    ) -> None:
        """Append samples, each (K, 3), that are measured, bridged or missing."""
        count = len(kind)
        if field is not None:
            has_field = np.asarray(np.isfinite(field).all(axis=1))
            field = np.where(has_field[:, None], field, 0.0)
            kind = np.asarray(kind | has_field * np.uint8(FIELD))
        else:
            field = np.zeros((count, 3))
        is_missing = (kind & MISSING) != 0
        if is_missing.any():
            gyroscope, accelerometer = gyroscope.copy(), accelerometer.copy()
            for k in np.flatnonzero(is_missing).tolist():
                if k and not is_missing[k - 1]:
                    self._last_good = accelerometer[k - 1].copy()
                gyroscope[k], accelerometer[k] = 0.0, _at_rest(self._last_good)
        if count and not is_missing[-1]:
            self._last_good = accelerometer[-1].copy()
        is_marked = (kind & (CLIPPED | MISSING)) == CLIPPED
        kind = np.asarray(kind | self._cut_off.find(gyroscope, accelerometer, is_marked))
        skipped = 0
        if self.first < 0:
            measured = np.flatnonzero(~is_missing)
            skipped = int(measured[0]) if len(measured) else count
            self.stop += skipped
            self.origin = self.judged = self.stop
            if len(measured):
                self.first = self.stop
        self._gyroscope = np.concatenate([self._gyroscope, gyroscope[skipped:]])
        self._force = np.concatenate([self._force, accelerometer[skipped:]])
        self._field = np.concatenate([self._field, field[skipped:]])
        self._kind = np.concatenate([self._kind, kind[skipped:]])
        self.stop += count - skipped

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
            missing = (self._kind & MISSING) != 0
            span = (known - self.origin, stop - self.origin)
            write_statistic(
                self._gyroscope, self._force, missing, *span, self.windows, self.parameters, grown
            )
            self._statistic = grown
        first = max(self.first, self.origin_of_inputs + len(self._bits))
        if end <= first:
            return
        count = end - first
        # Nothing beyond the ticks that every chunking has seen may count.
        horizon = min(len(self._statistic), end - self.origin + self.windows.ahead - self.windows.half)
        inputs, reference = np.empty((3, count)), np.empty(count)
        bits, rate_variance = np.empty(count, dtype=np.uint8), np.empty((count, 3))
        place = slice(first - self.origin, end - self.origin)
        sigma = inputs[0]
        decide(
            self._statistic[:horizon],
            self.origin,
            first,
            end,
            self.windows,
            self._decision,
            reference,
            sigma,
            bits,
        )
        inputs[1] = self._statistic[place]
        noise_densities(
            self._gyroscope,
            self._force,
            self._gap_root(first, end),
            self._kind if ((self._kind & CLIPPED) != 0).any() else NOT_CUT_OFF,
            place.start,
            place.stop,
            self._noise,
            inputs[2],
            rate_variance,
        )
        kind = self._kind[place]
        if kind.any():
            add_bridge_noise(
                self._gyroscope,
                self._force,
                (self._kind & (BRIDGED | MISSING)) == BRIDGED,
                (self._kind & (BRIDGED | MISSING)) != 0,
                place.start,
                place.stop,
                max(1, round(BESIDE_S * self.rate_hz)),
                1,
                1.0 / self.rate_hz,
                inputs[2],
                rate_variance,
            )
            has_field = (kind & FIELD != 0) & (bits & at.STANCE != 0)
            missing = (kind & MISSING) != 0
            bits |= has_field * np.uint8(at.HEADING)
            bits[missing] = at.STANCE
            sigma[missing] = LOST_SIGMA_MPS
        self._inputs = np.concatenate([self._inputs, inputs], axis=1)
        self._bits = np.concatenate([self._bits, bits])
        self._rate_variance = np.concatenate([self._rate_variance, rate_variance])

    @property
    def origin_of_inputs(self) -> int:
        """Tick of the first judged sample that is kept."""
        return max(self.released, self.first)

    def _gap_root(self, first: int, end: int) -> Float:
        """Return the root of the length of the gaps that nothing bridges, as far as may be known; for all ticks.

        Right for the ticks `[first - 1, end]`.
        """
        filled = (self._kind & MISSING) != 0
        if not filled.any():
            return _ALL_MEASURED
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
        return np.asarray(np.sqrt(length / (self.rate_hz * self.parameters.gap_scale_s)))

    def _filter(self, boundary: int) -> None:
        """Run the filter up to a boundary."""
        start = max(self.judged, self.first)
        if start == self.first and not self._memory[at.STARTED]:
            head = self._head(self.first)
            self._x[:] = start_state(self._force[head].mean(axis=0), np.zeros(3))
            self._p[:] = start_covariance(float(self._statistic[head].mean()), self.parameters)
        while start < boundary:
            # Block by block, so that a stored state can start again at the first sample not yet released.
            stop = min(start + self.block - start % self.block, boundary)
            mark = (self._gap, self._wary)
            self._marks.append((start, self._x.copy(), self._p.copy(), self._memory.copy(), mark))
            missing = (self._kind[start - self.origin : stop - self.origin] & MISSING) != 0
            if self._gap or missing.any():
                gap, block = gap_lengths(missing, self._gap), start
                self._gap = int(gap[-1]) if missing[-1] else 0
                for again in np.flatnonzero(~missing & (gap >= self._long_gap)).tolist():
                    self._forward(start, block + again)
                    start = block + again
                    self._begin_anew(start, float(gap[again]) / self.rate_hz)
            self._forward(start, stop)
            start = self.judged = stop

    def _head(self, tick: int) -> slice:
        """Return the place of the first moment from a tick on."""
        return slice(tick - self.origin, tick - self.origin + max(1, round(START_S * self.rate_hz)))

    def _begin_anew(self, tick: int, gap_s: float) -> None:
        head = self._head(tick)
        self._with_field[tick] = begin_anew(
            self._x,
            self._p,
            self._memory,
            self._force[head].mean(axis=0),
            float(self._statistic[head].mean()),
            gap_s,
            self.parameters,
        )
        self._wary = tick + round(self.parameters.reference_before_s * self.rate_hz)

    def _be_wary(self, start: int, stop: int) -> None:
        """Believe no stance that is one only against the moments around it: those before are missing."""
        place = slice(start - self.origin_of_inputs, stop - self.origin_of_inputs)
        measured = (self._kind[start - self.origin : stop - self.origin] & MISSING) == 0
        limit = self.parameters.stance_ratio * self.parameters.reference_floor
        self._bits[place][measured & (self._inputs[1, place] >= limit)] = 0

    def _forward(self, start: int, stop: int) -> None:
        if stop == start:
            return
        origin = self.origin_of_inputs
        if start < self._wary:
            self._be_wary(start, min(stop, self._wary))
        place, raw = slice(start - origin, stop - origin), slice(start - self.origin, stop - self.origin)
        self._records.forward(
            slice(self._base + place.start, self._base + place.stop),
            np.full(stop - start, 1.0 / self.rate_hz),
            self._gyroscope[raw],
            self._force[raw],
            self._inputs[0, place],
            self._bits[place],
            self._inputs[2, place],
            self._rate_variance[place],
            self._field[raw],
            self._settings,
            self._memory,
            self._x,
            self._p,
        )

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
            place = slice(count - given, count)
            values[place, : at.STATE] = state
            values[place, at.STATE : at.STATE + 6] = root(self._records.spread[base : base + given])
            values[place, at.STATE + 6] = self._inputs[1, :given]
            kind = self._kind[known - self.origin : upto - self.origin]
            is_level = np.asarray((values[place, at.STATE + 3 : at.STATE + 5] < _TILT_KNOWN_RAD).all(axis=1))
            stands, last = self._believed(known, self._stands(given), is_level)
            values[place, at.STATE + 7] = stands
            flags[place] = self._flags(known, last, kind)
            flags[place] |= self._lost.widen(
                state[:, at.P : at.P + 3],
                values[place, at.STATE : at.STATE + 6],
                (kind & MISSING) != 0,
                known,
                self._with_field,
            )
            self._with_field = {tick: known for tick, known in self._with_field.items() if tick >= upto}
            self._base += given
            if self._base + self.lag + 2 * self.block > len(self._records.spread):
                self._records.move_to_front(self._base, end)
                self._base = 0
            self._inputs, self._bits = self._inputs[:, given:], self._bits[given:]
            self._rate_variance = self._rate_variance[given:]
        self.released = upto
        while len(self._marks) > 1 and self._marks[1][0] <= upto:
            self._marks.pop(0)
        return values, flags

    def _stands(self, count: int) -> NDArray[np.bool_]:
        """Return for the first ticks not yet released whether a stance was measured and believed."""
        return np.asarray(((self._bits[:count] & at.STANCE) != 0) & (self._inputs[1, :count] < UNREST))

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
        if self.first < 0:
            return
        needed = min(self.released, self.judged, self.origin_of_inputs + len(self._bits)) - self.windows.back
        # At least a few of the first samples are kept until the filter has started from them.
        drop = min(needed - 1, self._marks[0][0] if self._marks else self.first) - self.origin
        if drop > 0:
            self._gyroscope, self._force = self._gyroscope[drop:], self._force[drop:]
            self._field, self._kind = self._field[drop:], self._kind[drop:]
            self._statistic = self._statistic[drop:]
            self.origin += drop

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that later samples depend on; records are made again from it."""
        mark = (
            self._marks[0]
            if self._marks
            else (self.judged, self._x, self._p, self._memory, (self._gap, self._wary))
        )
        counters = (
            self.first,
            self.origin,
            self.stop,
            self.judged,
            self.released,
            self._last_stance,
            mark[0],
            *mark[4],
        )
        return {
            "lost": self._lost.memory.copy(),
            "counters": np.array(counters, dtype=np.int64),
            "raw": np.concatenate([self._gyroscope, self._force, self._field], axis=1),
            "kind": self._kind.copy(),
            "statistic": self._statistic.copy(),
            "inputs": self._inputs.copy(),
            "bits": self._bits.copy(),
            "rate_variance": self._rate_variance.copy(),
            "last_good": self._last_good.copy(),
            "largest": self._cut_off.largest.copy(),
            "x": mark[1].copy(),
            "p": mark[2].copy(),
            "memory": mark[3].copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state`."""
        first, origin, stop, judged, released, last_stance, mark, self._gap, self._wary = (
            int(v) for v in state["counters"]
        )
        self.first, self.origin, self.stop, self.released = first, origin, stop, released
        self._last_stance = last_stance
        self._gyroscope, self._force, self._field = (
            np.ascontiguousarray(state["raw"][:, i : i + 3]) for i in (0, 3, 6)
        )
        self._kind, self._statistic = np.array(state["kind"]), np.array(state["statistic"])
        self._inputs, self._bits = np.array(state["inputs"]), np.array(state["bits"])
        self._rate_variance = np.array(state["rate_variance"])
        self._last_good = np.array(state["last_good"])
        self._cut_off.largest = np.array(state["largest"])
        self._x, self._p, self._memory = (np.array(state[name]) for name in ("x", "p", "memory"))
        self._lost.memory = np.array(state["lost"])
        self._marks, self._base, self._with_field = [], 0, {}
        self.judged = mark
        if judged > mark:
            self._filter(judged)


def _at_rest(accelerometer: Float) -> Float:
    """Return the specific force of a foot that rests the way it was last seen."""
    return np.asarray(accelerometer * (GRAVITY_MPS2 / max(float(np.linalg.norm(accelerometer)), 1.0)))


__all__ = ["BRIDGED", "CLIPPED", "COLUMNS", "MISSING", "FootStream"]
