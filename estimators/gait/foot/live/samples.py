"""One foot's samples as they come, live: what was not measured stands in at rest, and what is old is forgotten."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.gait._stance import Windows, write_statistic
from estimators.gait.foot.filter import START_S
from estimators.gait.foot.live.cut_off import CutOffAxes
from estimators.gait.foot.live.rows import CLIPPED, FIELD, MISSING, FootRows
from estimators.gait.foot.parameters import FootParameters
from estimators.recording import Float

_ALL_MEASURED: Final = np.empty(0)


class FootSamples:
    """A buffer of samples, from a few before the first that is still judged on. Ticks count from the stream's start.

    Parameters
    ----------
    rows : FootRows
        Hold everything; compiled code may take the next samples as well.
    number : int
        Of the foot.
    """

    def __init__(
        self, rate_hz: float, parameters: FootParameters, windows: Windows, rows: FootRows, number: int
    ) -> None:
        self._rate_hz, self._parameters, self._windows = rate_hz, parameters, windows
        self._at: Any = rows.foot[number]
        self._room: tuple[Float, Float, Float] = (
            rows.gyroscope[number],
            rows.force[number],
            rows.field[number],
        )
        self._kinds: NDArray[np.uint8] = rows.kind[number]
        self._statistics: Float = rows.statistic[number]
        self._last_good = rows.last_good[number]
        self._cut_off = CutOffAxes(rows.largest[number])

    @property
    def first(self) -> int:
        """The first measured tick; -1 before there is one."""
        return int(self._at["first"])

    @property
    def origin(self) -> int:
        """Tick of the first buffered sample."""
        return int(self._at["origin"])

    @property
    def stop(self) -> int:
        """Tick that comes next."""
        return int(self._at["stop"])

    @property
    def _buffered(self) -> slice:
        start = int(self._at["place"])
        return slice(start, start + self.stop - self.origin)

    @property
    def gyroscope(self) -> Float:
        """Of the ticks `[origin, stop)`, shape (N, 3)."""
        return self._room[0][self._buffered]

    @property
    def force(self) -> Float:
        """Specific force, shape (N, 3)."""
        return self._room[1][self._buffered]

    @property
    def field(self) -> Float:
        """Magnetic field, shape (N, 3); zeros where there is none."""
        return self._room[2][self._buffered]

    @property
    def kind(self) -> NDArray[np.uint8]:
        """What there is to say of each, shape (N,)."""
        return self._kinds[self._buffered]

    @property
    def statistic(self) -> Float:
        """T of the first M <= N of them, as far as the samples around are known, shape (M,)."""
        start = int(self._at["place"])
        return self._statistics[start : start + int(self._at["known"])]

    def take(
        self, gyroscope: Float, accelerometer: Float, field: Float | None, kind: NDArray[np.uint8]
    ) -> None:
        """Append samples, each (K, 3) with K <= PIECE_TICKS, that are measured, bridged or missing."""
        at, count = self._at, len(kind)
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
                    self._last_good[:] = accelerometer[k - 1]
                gyroscope[k], accelerometer[k] = 0.0, _at_rest(self._last_good)
        if count and not is_missing[-1]:
            self._last_good[:] = accelerometer[-1]
        is_marked = (kind & (CLIPPED | MISSING)) == CLIPPED
        kind = np.asarray(kind | self._cut_off.find(gyroscope, accelerometer, is_marked))
        skipped = 0
        if at["first"] < 0:
            measured = np.flatnonzero(~is_missing)
            skipped = int(measured[0]) if len(measured) else count
            at["stop"] += skipped
            at["origin"] = at["stop"]
            if len(measured):
                at["first"] = at["stop"]
        self._append((gyroscope, accelerometer, field), kind, skipped)
        flawed = np.flatnonzero(kind[skipped:] & ~np.uint8(FIELD))
        if len(flawed):
            at["flawed_stop"] = at["stop"] + int(flawed[-1]) + 1
        at["stop"] += count - skipped

    def _append(self, values: tuple[Float, Float, Float], kind: NDArray[np.uint8], skipped: int) -> None:
        start, buffered, count = int(self._at["place"]), self._buffered, len(kind) - skipped
        if buffered.stop + count > len(self._kinds):
            front = slice(buffered.stop - start)
            for room in (*self._room, self._kinds, self._statistics):
                room[front] = room[buffered]
            self._at["place"], buffered = 0, front
        place = slice(buffered.stop, buffered.stop + count)
        for room, new in zip(self._room, values, strict=True):
            room[place] = new[skipped:]
        self._kinds[place] = kind[skipped:]

    def place(self, first: int, stop: int) -> slice:
        """Return where the ticks `[first, stop)` are in the buffer."""
        return slice(first - self.origin, stop - self.origin)

    def head(self, tick: int) -> slice:
        """Return the place of the first moment from a tick on."""
        return self.place(tick, tick + max(1, round(START_S * self._rate_hz)))

    def start(self, tick: int) -> tuple[Float, float]:
        """Return what a filter that starts at a tick begins from: mean specific force (3,) and mean T."""
        head = self.head(tick)
        return self.force[head].mean(axis=0), float(self.statistic[head].mean())

    def find_statistic(self, is_end: bool) -> None:
        """Bring T as far as the samples go."""
        known, count = int(self._at["known"]), self.stop - self.origin
        stop = count if is_end else count - self._windows.half
        if stop > known:
            self._at["known"] = stop
            missing = (self.kind & MISSING) != 0
            write_statistic(
                self.gyroscope,
                self.force,
                missing,
                known,
                stop,
                self._windows,
                self._parameters,
                self.statistic,
            )

    def gap_root(self) -> Float:
        """Return the root of the length of the gaps that nothing bridges, as far as may be known; for all ticks.

        Right for the ticks that are judged, and the one before them.
        """
        filled = (self.kind & MISSING) != 0
        if not filled.any():
            return _ALL_MEASURED
        count = len(filled)
        places = np.arange(count)
        before = places - np.maximum.accumulate(np.where(filled, -1, places))
        ahead = np.minimum.accumulate(np.where(filled, count, places)[::-1])[::-1] - places
        # Every chunking has seen `ahead` ticks further than the one judged, and retained `back` before it.
        length = np.where(
            filled,
            np.minimum(before, self._windows.back) + np.minimum(ahead - 1, self._windows.half),
            0,
        )
        return np.asarray(np.sqrt(length / (self._rate_hz * self._parameters.gap_scale_s)))

    def forget(self, before: int) -> None:
        """Drop the samples before a tick."""
        at, drop = self._at, before - self.origin
        if drop > 0:
            at["place"] += drop
            at["known"] = max(int(at["known"]) - drop, 0)
            at["origin"] += drop

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything but the counters that later samples depend on."""
        return {
            "raw": np.concatenate([self.gyroscope, self.force, self.field], axis=1),
            "kind": self.kind.copy(),
            "statistic": self.statistic.copy(),
            "last_good": self._last_good.copy(),
            "largest": self._cut_off.largest.copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]], first: int, origin: int, stop: int) -> None:
        """Continue from `state` and the counters."""
        at, kind = self._at, np.asarray(state["kind"])
        at["place"], at["first"], at["origin"], at["stop"] = 0, first, origin, stop
        for room, i in zip(self._room, (0, 3, 6), strict=True):
            room[: len(kind)] = state["raw"][:, i : i + 3]
        self._kinds[: len(kind)] = kind
        at["known"] = len(state["statistic"])
        self.statistic[:] = state["statistic"]
        flawed = np.flatnonzero(kind & ~np.uint8(FIELD))
        at["flawed_stop"] = origin + int(flawed[-1]) + 1 if len(flawed) else 0
        self._last_good[:] = state["last_good"]
        self._cut_off.largest[:] = state["largest"]


def _at_rest(accelerometer: Float) -> Float:
    """Return the specific force of a foot that rests the way it was last seen."""
    return np.asarray(accelerometer * (GRAVITY_MPS2 / max(float(np.linalg.norm(accelerometer)), 1.0)))
