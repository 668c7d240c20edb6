"""The part of a live session that the pooled engine moves on: what is done for packets that compiled code took."""

import contextlib
import time

import numpy as np

from app.errors import Conflict, Unavailable
from app.live.blocks import PublishedBlock, PublishedFrames
from app.live.calibration.calibrated_session import CalibratedSession
from app.live.checks.first_seconds import FirstSeconds
from app.live.checks.force_watch import ForceWatch
from app.live.checks.health import LinkHealth
from app.live.checks.recent import RecentSamples
from app.live.engine.lane import Lane
from app.live.guidance.desk import GuidanceDesk
from app.live.session.actuation import Actuation
from app.live.session.ledger import SequenceLedger
from app.network.alignment import Aligner
from app.network.clock import PacketClock, SkewEstimator
from app.network.raw_packet import RawPacket
from app.sentences import say
from estimators.pipelines import Frames
from estimators.recording import Float, ImuChunk


class PooledSession(CalibratedSession):
    """A session whose packets come one by one, or many at a time by way of the pooled engine."""

    lane: Lane | None
    """Its place in the pooled engine, once it has one."""
    clock: PacketClock
    aligner: Aligner
    ledger: SequenceLedger
    skew: SkewEstimator
    health: LinkHealth
    actuation: Actuation | None
    last_arrival_s: float
    duplicates: int
    guidance: GuidanceDesk | None
    _forces: ForceWatch | None
    _first_seconds: FirstSeconds
    _has_store_failed: bool
    _unstored_tick: int

    def _cut_off(self, levels: Float) -> None:
        raise NotImplementedError

    @property
    def is_plain(self) -> bool:
        """Whether all that happens to the next packet is what the pooled engine does."""
        return (
            self.line.is_idle
            and not self._calibration.is_active
            and not self._has_store_failed
            and self.actuation is None
            and self._forces is None
            and self._writer.has_room(self.id)
        )

    @property
    def is_watched(self) -> bool:
        """Whether somebody wants blocks of its frames."""
        return self._bus.has_listeners(self._topics["blocks"])

    @property
    def recent(self) -> RecentSamples:
        """The newest seconds of its samples."""
        return self._first_seconds.recent

    def publish_block(self, block: PublishedBlock) -> None:
        """Give a block to whoever watches."""
        self._bus.publish(self._topics["blocks"], block)

    def took(self, raw: RawPacket, end_s: float, arrival_s: float) -> None:
        """Store and count a packet that is not back-filled and was placed in order; `end_s` is its session time."""
        self.last_arrival_s = arrival_s
        self.health.add_packet(end_s, arrival_s)
        self.skew.add(end_s, arrival_s)
        with contextlib.suppress(Conflict, Unavailable):
            # One that was not stored is not acknowledged: the gateway brings it again, and it is stored late.
            if self._writer.append_packet(self.id, raw):
                self.ledger.received.add(raw.sequence)
            else:
                self.duplicates += 1

    def after_pooled(self, frames: Frames, ticks: int, chunk: ImuChunk | None) -> None:
        """Publish and store what the pooled engine found; `chunk` where a sample is less than measured."""
        if self._bus.has_listeners(self._topics["frames"]):
            self._bus.publish(self._topics["frames"], PublishedFrames(frames, time.time()))
        if self.guidance is not None:
            self.guidance.see(frames, is_counting=self.state == "recording", is_live=True)
        if frames.first_tick < self._unstored_tick:
            self.store_frames(frames)
        else:
            with contextlib.suppress(Conflict, Unavailable):
                self._writer.append_frames(self.id, self.result_id, frames)
        self.health.set_flags(frames.layout.segments, frames.segment_flags)
        if chunk is None:
            self.health.add_whole(ticks)
        else:
            self._tell_changes(chunk)
        self._first_seconds.seen(frames.first_tick, frames.first_tick + ticks)

    def store_frames(self, frames: Frames) -> None:
        """Store frames except the ticks that were stored before a restart."""
        if frames.first_tick < self._unstored_tick:
            frames = frames.ticks(self._unstored_tick - frames.first_tick, frames.tick_count)
        if frames.tick_count:
            with contextlib.suppress(Conflict, Unavailable):
                # A session that cannot be stored hears of it once, from `on_store_failure`.
                self._writer.append_frames(self.id, self.result_id, frames.as_stored_live())

    def _tell_changes(self, chunk: ImuChunk) -> None:
        changes = self.health.add_chunk(chunk)
        step_s = chunk.time_step_s
        # All sensors at once are a gap of the link, reported as one below.
        if changes and len(changes) < max(2, len(self.health.placements)):
            for change in changes:
                kind = "sensor_lost" if change.is_lost else "sensor_back"
                if not change.is_lost:
                    self._first_seconds.restart(change.placement)
                    levels = self.aligner.clip_levels.copy()
                    levels[self.declaration.placements.index(change.placement)] = np.inf
                    self._cut_off(levels)
                self.add_event(kind, change.tick * step_s, placement=change.placement)
        for gap in self.aligner.gaps:
            if not gap.is_bridged:
                text = say("live.gap", missing_s=gap.tick_count * step_s)
                self.add_event("gap", gap.first_tick * step_s, gap.tick_count * step_s, text=text)
        self.aligner.gaps.clear()
