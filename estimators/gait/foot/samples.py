"""One foot's samples as they come, live: what was not measured stands in at rest, and what is old is forgotten."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.gait._stance import Windows, write_statistic
from estimators.gait.foot.cut_off import CutOffAxes
from estimators.gait.foot.filter import START_S
from estimators.gait.foot.parameters import FootParameters
from estimators.recording import Float

BRIDGED, MISSING, CLIPPED, FIELD = 1, 2, 4, 8
"""What there is to say of a sample: how it came about, and whether a magnetic field came with it; the bits above are
those of the axes that were cut off (`CutOffAxes`)."""

_ALL_MEASURED: Final = np.empty(0)
_UPRIGHT: Final = np.array([0.0, 0.0, GRAVITY_MPS2])


class FootSamples:
    """A buffer of samples, from a few before the first that is still judged on. Ticks count from the stream's start.

    Attributes
    ----------
    gyroscope, force, field : ndarray, shape (N, 3)
        Of the ticks `[origin, origin + N)`; zeros where there is no field.
    kind : ndarray of uint8, shape (N,)
    statistic : ndarray, shape (M,)
        T of the first M <= N of them, as far as the samples around are known.
    origin, stop : int
        Tick of the first buffered sample, and of the one that comes next.
    first : int
        The first measured tick; -1 before there is one.
    """

    def __init__(self, rate_hz: float, parameters: FootParameters, windows: Windows) -> None:
        self._rate_hz, self._parameters, self._windows = rate_hz, parameters, windows
        self.first = -1
        self.origin = self.stop = 0
        self.gyroscope, self.force, self.field = (np.empty((0, 3)) for _ in range(3))
        self.kind = np.empty(0, dtype=np.uint8)
        self.statistic = np.empty(0)
        self._last_good = _UPRIGHT.copy()
        self._cut_off = CutOffAxes()

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
            self.origin = self.stop
            if len(measured):
                self.first = self.stop
        self.gyroscope = np.concatenate([self.gyroscope, gyroscope[skipped:]])
        self.force = np.concatenate([self.force, accelerometer[skipped:]])
        self.field = np.concatenate([self.field, field[skipped:]])
        self.kind = np.concatenate([self.kind, kind[skipped:]])
        self.stop += count - skipped

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
        known = self.origin + len(self.statistic)
        stop = self.stop if is_end else self.stop - self._windows.half
        if stop > known:
            grown = np.empty(stop - self.origin)
            grown[: len(self.statistic)] = self.statistic
            missing = (self.kind & MISSING) != 0
            span = (known - self.origin, stop - self.origin)
            write_statistic(
                self.gyroscope, self.force, missing, *span, self._windows, self._parameters, grown
            )
            self.statistic = grown

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
        drop = before - self.origin
        if drop > 0:
            self.gyroscope, self.force = self.gyroscope[drop:], self.force[drop:]
            self.field, self.kind = self.field[drop:], self.kind[drop:]
            self.statistic = self.statistic[drop:]
            self.origin += drop

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
        self.first, self.origin, self.stop = first, origin, stop
        self.gyroscope, self.force, self.field = (
            np.ascontiguousarray(state["raw"][:, i : i + 3]) for i in (0, 3, 6)
        )
        self.kind, self.statistic = np.array(state["kind"]), np.array(state["statistic"])
        self._last_good = np.array(state["last_good"])
        self._cut_off.largest = np.array(state["largest"])


def _at_rest(accelerometer: Float) -> Float:
    """Return the specific force of a foot that rests the way it was last seen."""
    return np.asarray(accelerometer * (GRAVITY_MPS2 / max(float(np.linalg.norm(accelerometer)), 1.0)))


__all__ = ["BRIDGED", "CLIPPED", "FIELD", "MISSING", "FootSamples"]
