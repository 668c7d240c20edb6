"""The newest seconds of a session's samples in a ring, which compiled code may write as well."""

from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.recording import Float, ImuChunk

LATE_TICKS: Final = 320
"""Largest number of ticks written before the reader of the ring hears of the first of them."""


class RecentSamples:
    """A ring of ticks, each at its number modulo the length.

    Parameters
    ----------
    ticks : int
        Length.
    """

    def __init__(self, ticks: int) -> None:
        self.ticks = ticks
        self._signals: Float | None = None
        self._quality = np.empty((ticks, 0), dtype=np.uint8)
        self._waiting: deque[ImuChunk] = deque()
        """Chunks that were not written yet: while nobody reads the ring, references cost less."""

    def share(self, signals: Float, quality: NDArray[np.uint8]) -> None:
        """Go on over these arrays, shapes (ticks, channels, S, 3) and (ticks, S), which hold the ring from now on."""
        if self._signals is not None and self._signals.base is not signals.base:
            signals[...], quality[...] = self._signals, self._quality
        self._signals, self._quality = signals, quality
        self._write()

    def own(self) -> None:
        """Go on over arrays of its own."""
        self._write()
        if self._signals is not None:
            self._signals, self._quality = self._signals.copy(), self._quality.copy()

    def add(self, chunk: ImuChunk) -> None:
        """Take the newest ticks."""
        waiting = self._waiting
        waiting.append(chunk)
        if waiting[-1].first_tick - waiting[0].first_tick > self.ticks:
            waiting.popleft()

    def _write(self) -> None:
        while self._waiting:
            self._put(self._waiting.popleft())

    def _put(self, chunk: ImuChunk) -> None:
        fields = [chunk.gyroscope_radps, chunk.accelerometer_mps2]
        if chunk.magnetometer_t is not None:
            fields.append(chunk.magnetometer_t)
        if self._signals is None:
            self._signals = np.empty((self.ticks, len(fields), chunk.sensor_count, 3))
            self._quality = np.empty((self.ticks, chunk.sensor_count), dtype=np.uint8)
        skipped = max(0, chunk.tick_count - self.ticks)
        while skipped < chunk.tick_count:
            at = (chunk.first_tick + skipped) % self.ticks
            stop = min(chunk.tick_count, skipped + self.ticks - at)
            for channel, values in enumerate(fields):
                self._signals[at : at + stop - skipped, channel] = values[:, skipped:stop].transpose(1, 0, 2)
            self._quality[at : at + stop - skipped] = chunk.quality[:, skipped:stop].T
            skipped = stop

    def chunk(self, first_tick: int, stop_tick: int, time_step_s: float) -> ImuChunk:
        """Return a copy of ticks that are in the ring."""
        self._write()
        assert self._signals is not None
        at = np.arange(first_tick, stop_tick) % self.ticks
        fields = np.ascontiguousarray(self._signals[at].transpose(1, 2, 0, 3))
        return ImuChunk(
            first_tick,
            time_step_s,
            fields[0],
            fields[1],
            fields[2] if len(fields) == 3 else None,
            np.ascontiguousarray(self._quality[at].T),
        )
