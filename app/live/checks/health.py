"""Link and signal health of one live session, over about the last two seconds."""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.live.messages import SensorHealth
from estimators.orientation._contract import OrientationFlag
from estimators.recording import ImuChunk, SampleQuality

LOST_AFTER_S = 0.5
"""A sensor without samples for so long is reported as lost."""
_NOISY_LOSS_PERCENT = 5.0
_WINDOW_S = 1.0
_LATENCIES = 200
_DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_STARTING = int(OrientationFlag.CONVERGING)
JITTER_STEP_MS: Final = 1.0
"""Jitter is shown again once it is further from what was shown: it moves a little with every packet."""


@dataclass
class _Window:
    """Counts over one second."""

    sensors: int
    ticks: int = 0
    lost: NDArray[np.int64] = field(init=False)
    saturated: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        self.lost = np.zeros(self.sensors, dtype=np.int64)
        self.saturated = np.zeros(self.sensors, dtype=np.bool_)


@dataclass(frozen=True)
class SensorChange:
    """A sensor was lost or came back; reported once."""

    placement: str
    is_lost: bool
    tick: int


class LinkHealth:
    """Counts what the live view shows beside the patient.

    Parameters
    ----------
    placements : sequence of str
        Sensors in the order of the packets.
    """

    def __init__(self, placements: Sequence[str], time_step_s: float) -> None:
        self.placements = tuple(placements)
        self._step_s = time_step_s
        self._present = _Window(len(placements))
        self._previous = _Window(len(placements))
        self._missing_ticks = np.zeros(len(placements), dtype=np.int64)
        self._is_lost = np.zeros(len(placements), dtype=np.bool_)
        self._transit_s: float | None = None
        self._jitter_s = 0.0
        self._jitter_ms = 0.0
        self._has_gaps = False
        self._segments: Sequence[str] = ()
        self._segment_flags: NDArray[np.uint8] | None = None
        self.latencies_s: deque[float] = deque(maxlen=_LATENCIES)
        """Not yet taken."""
        self._taken_s: deque[float] = deque(maxlen=_LATENCIES)
        self._shown: tuple[tuple[object, ...], list[SensorHealth]] = ((), [])

    def add_packets(self, arrived: Iterable[tuple[float, float]]) -> None:
        """Take device time and monotonic arrival time, s, of packets that came as they were measured.

        Jitter is the running mean change of transit time, RFC 3550 section 6.4.1.
        """
        before_s, jitter_s = self._transit_s, self._jitter_s
        for device_s, arrival_s in arrived:
            transit_s = arrival_s - device_s
            if before_s is not None:
                change_s = transit_s - before_s if transit_s > before_s else before_s - transit_s
                jitter_s += ((change_s if change_s < 1.0 else 1.0) - jitter_s) / 16.0
            before_s = transit_s
        self._transit_s, self._jitter_s = before_s, jitter_s

    def add_chunk(self, chunk: ImuChunk) -> list[SensorChange]:
        """Take aligned ticks; return the sensors that were lost or came back with them."""
        if self._present.ticks * self._step_s >= _WINDOW_S:
            self._previous, self._present = self._present, _Window(len(self.placements))
        quality = chunk.quality
        self._present.ticks += quality.shape[1]
        if not quality.any():
            if self._has_gaps:
                return self._changes(np.zeros_like(self._missing_ticks), chunk.first_tick)
            return []
        missing = (quality & SampleQuality.MISSING) != 0
        bad = missing | ((quality & SampleQuality.BRIDGED) != 0)
        self._present.lost += bad.sum(axis=1)
        self._present.saturated |= ((quality & SampleQuality.SATURATED) != 0).any(axis=1)
        # Missing ticks at the end of the chunk; the run goes on only when all of it is missing.
        trailing = np.where(missing.all(axis=1), chunk.tick_count, np.argmax(~missing[:, ::-1], axis=1))
        run = np.where(missing.all(axis=1), self._missing_ticks + trailing, trailing)
        return self._changes(run, chunk.first_tick + chunk.tick_count)

    @property
    def has_gaps(self) -> bool:
        """Whether a sensor gives nothing at present: the next ticks must be looked at."""
        return self._has_gaps

    def add_whole(self, chunks: Iterable[int]) -> None:
        """Take ticks of chunks in which every sample was measured, while `has_gaps` is false."""
        for ticks in chunks:
            if self._present.ticks * self._step_s >= _WINDOW_S:
                self._previous, self._present = self._present, _Window(len(self.placements))
            self._present.ticks += ticks

    def _changes(self, run: NDArray[np.int64], tick: int) -> list[SensorChange]:
        self._missing_ticks = run
        lost = run * self._step_s >= LOST_AFTER_S
        back = self._is_lost & (run == 0)
        changed = np.flatnonzero((lost & ~self._is_lost) | back)
        self._is_lost = (self._is_lost | lost) & ~back
        self._has_gaps = bool(run.any() or self._is_lost.any())
        return [
            SensorChange(self.placements[i], bool(lost[i]), tick - int(run[i]) if lost[i] else tick)
            for i in changed
        ]

    def set_flags(self, segments: Sequence[str], flags: NDArray[np.uint8]) -> None:
        """Take the orientation flags of the newest ticks, shape (K, G), by segment; read when somebody asks."""
        if len(flags):
            self._segments, self._segment_flags = segments, flags

    def take_latencies(self) -> list[float]:
        """Return what was measured since the last call; what is asked for a median keeps the last ones."""
        taken = list(self.latencies_s)
        self.latencies_s.clear()
        self._taken_s.extend(taken)
        return taken

    def latency_ms(self) -> tuple[float | None, float | None]:
        """Return median and 99th percentile of the last latencies, packet arrival to published frame."""
        known = [*self._taken_s, *self.latencies_s][-_LATENCIES:]
        if not known:
            return None, None
        ordered = sorted(known)
        median, high = ordered[len(ordered) // 2], ordered[min(len(ordered) - 1, round(0.99 * len(ordered)))]
        return round(1e3 * median, 3), round(1e3 * high, 3)

    def sensors(self, link_is_up: bool) -> list[SensorHealth]:
        """Return the health of every sensor; the same list while nothing has changed."""
        ticks = max(1, self._present.ticks + self._previous.ticks)
        loss = 100.0 * (self._present.lost + self._previous.lost) / ticks
        saturated = self._present.saturated | self._previous.saturated
        newest = [] if self._segment_flags is None else self._segment_flags[-1].tolist()
        if abs(1e3 * self._jitter_s - self._jitter_ms) > JITTER_STEP_MS:
            self._jitter_ms = round(2e3 * self._jitter_s) / 2
        each = tuple(
            zip(self.placements, loss.tolist(), saturated.tolist(), self._is_lost.tolist(), strict=True)
        )
        key = (link_is_up, self._jitter_ms, self._segments, newest, each)
        if key == self._shown[0]:
            return self._shown[1]
        flags_of = dict(zip(self._segments, newest, strict=True))
        found = []
        for placement, percent, is_saturated, is_lost in each:
            flags = flags_of.get(placement, 0)
            is_noisy = percent > _NOISY_LOSS_PERCENT or is_saturated
            found.append(
                # Twice a second for every sensor of every session: its types are known here.
                SensorHealth.model_construct(
                    placement=placement,
                    status="lost" if is_lost or not link_is_up else "noisy" if is_noisy else "ok",
                    loss_percent=round(percent, 2),
                    jitter_ms=self._jitter_ms,
                    saturated=is_saturated,
                    magnetic_disturbance=flags & _DISTURBED != 0,
                    heading_trusted=flags & _NO_HEADING == 0,
                    is_starting=flags & _STARTING != 0,
                )
            )
        self._shown = (key, found)
        return found
