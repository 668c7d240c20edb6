"""The part of a live session that the pooled engine moves on: what is done for packets that compiled code took."""

import contextlib
import math
import time
from collections.abc import Sequence

import numpy as np

from app.errors import Conflict, Unavailable
from app.live.blocks import PublishedFrames
from app.live.calibration.calibrated_session import CalibratedSession
from app.live.checks.first_seconds import FirstSeconds
from app.live.checks.force_watch import ForceWatch
from app.live.checks.health import LinkHealth
from app.live.checks.recent import RecentSamples
from app.live.checks.unexpected_emission import UnexpectedEmission
from app.live.engine.lane import ARRIVAL_S, Lane, Parts, TakenPacket
from app.live.engine.pools import DURATION_US, TIME_US
from app.live.guidance.controller import GuidanceController
from app.live.session.actuation import Actuation
from app.live.session.ledger import SequenceLedger
from app.network.alignment import Aligner
from app.network.clock import PacketClock, SkewEstimator
from app.network.packet_run import PacketRun
from estimators.pipelines import Frames, Pipeline
from estimators.recording import Float, ImuChunk
from estimators.sentences import say


class PooledSession(CalibratedSession):
    """A session whose packets come one by one, or many at a time by way of the pooled engine."""

    now: Parts
    """As they stood when the session was last settled; whoever wants them as they stand asks for `parts`."""
    lane: Lane | None
    """Its place in the pooled engine, once it has one."""
    actuation: Actuation | None
    duplicates: int
    guidance: GuidanceController | None
    _forces: ForceWatch | None
    _stray: UnexpectedEmission
    _first_seconds: FirstSeconds
    _has_store_failed: bool
    _last_arrival_s: float
    _unstored_tick: int

    def _cut_off(self, levels: Float) -> None:
        raise NotImplementedError

    @property
    def parts(self) -> Parts:
        """What packets move on, with every packet that has been taken."""
        self.settle()
        return self.now

    def settle(self) -> None:
        """Carry everything on over the packets that have been taken; the lane looks again before the next."""
        if self.lane is not None:
            self.lane.settle()
            self.lane.is_sure = False

    @property
    def clock(self) -> PacketClock:
        """Where packets stand in time."""
        return self.parts.clock

    @property
    def aligner(self) -> Aligner:
        """What puts samples on common ticks."""
        return self.parts.aligner

    @aligner.setter
    def aligner(self, aligner: Aligner) -> None:
        self.parts.aligner = aligner

    @property
    def ledger(self) -> SequenceLedger:
        """Which packets are here and which are safe."""
        return self.parts.ledger

    @property
    def skew(self) -> SkewEstimator:
        """How fast the device's clock runs."""
        return self.parts.skew

    @property
    def health(self) -> LinkHealth:
        """Of link and sensors."""
        return self.parts.health

    @property
    def pipeline(self) -> Pipeline:
        """The session's estimators."""
        return self.parts.pipeline

    @property
    def last_arrival_s(self) -> float:
        """Monotonic time at which the newest packet came."""
        return max(self._last_arrival_s, -math.inf if self.lane is None else self.lane.newest_arrival_s)

    @property
    def is_plain(self) -> bool:
        """Whether all that happens to the next packet is what the pooled engine does.

        What ends it begins with `parts` or `settle`, but for what `Lane.is_ready` asks each time.
        """
        return (
            self.line.is_idle
            and not self._calibration.is_active
            and not self._has_store_failed
            and self._writer.has_room(self.id)
        )

    @property
    def recent(self) -> RecentSamples:
        """The newest seconds of its samples."""
        return self._first_seconds.recent

    def show(self, frames: Frames, *, is_live: bool) -> None:
        """Give frames to whoever wants them at once; `is_live` where they came as they were measured."""
        if self.channels["frames"].listeners:
            self.channels["frames"].publish(PublishedFrames(frames, time.time()))
        if self.guidance is not None:
            self.guidance.see(frames, is_counting=self._is_counting, is_live=is_live)
        if self.actuation is not None:
            self.actuation.take(frames, self.now.clock.declaration, is_live=is_live)

    def watch_source(self, first_tick: int, coil_state: Float | None) -> None:
        """Look whether a coil is on that nobody asked for; `coil_state` of (S, K) ticks, None where none was sent."""
        if coil_state is not None or self.actuation is not None:
            declaration = self.now.clock.declaration
            allowed = None if self.actuation is None else self.actuation.is_allowed
            step_s = declaration.time_step_s
            self._stray.add(first_tick * step_s, step_s, coil_state, declaration.placements, allowed)

    def _watch_forces(self, frames: Frames) -> None:
        if self._forces is None:
            return
        for change in self._forces.add(frames):
            kind = "forces_lost" if change.is_lost else "forces_back"
            at_s = change.tick * frames.time_step_s
            self.add_event(kind, at_s, placement=f"foot_{change.side}", text=change.text)

    def took(self, taken: Sequence[TakenPacket], runs: Sequence[PacketRun], *, is_live: bool) -> None:
        """Store and count packets that were placed in order; `is_live` where they came as they were measured."""
        parts = self.now
        came_s, self._last_arrival_s = taken[0][ARRIVAL_S], taken[-1][ARRIVAL_S]
        for run in runs:
            with contextlib.suppress(Conflict, Unavailable):
                # One that was not stored is not acknowledged: the gateway brings it again, and it is stored late.
                self.duplicates += len(run.messages) - self._writer.append_run(self.id, run, came_s)
                parts.ledger.received.add_range(run.first_sequence, run.stop_sequence)
        if is_live:
            arrived = [
                ((row[TIME_US] + row[DURATION_US]) * 1e-6, arrival_s) for row, _, arrival_s, _ in taken
            ]
            parts.health.add_packets(arrived)
            parts.skew.add(arrived)

    def after_pooled(self, frames: Frames, whole: Sequence[int], chunk: ImuChunk | None) -> None:
        """Store and count what the pooled engine found; whoever wants frames at once has seen them.

        `whole` has the ticks of each packet whose samples were all measured; `chunk` those of the last that is not so.
        """
        health, ticks = self.now.health, frames.tick_count
        if self.guidance is not None and not self.guidance.is_following:
            # It takes note of the time alone.
            self.guidance.see(frames, is_counting=self._is_counting, is_live=False)
        self.store_frames(frames)
        health.set_flags(frames.layout.segments, frames.segment_flags)
        health.add_whole(whole)
        if chunk is not None:
            self._tell_changes(chunk)
        self._watch_forces(frames)
        self._watch_worn(frames, self.now.pipeline)
        self._first_seconds.seen(frames.first_tick, frames.first_tick + ticks)

    def store_frames(self, frames: Frames) -> None:
        """Store frames except the ticks that were stored before a restart."""
        if frames.first_tick < self._unstored_tick:
            frames = frames.ticks(self._unstored_tick - frames.first_tick, frames.tick_count)
        if frames.tick_count:
            with contextlib.suppress(Conflict, Unavailable):
                # A session that cannot be stored hears of it once, from `on_store_failure`.
                taken = self._writer.append_frames(self.id, self.result_id, frames.as_stored_live())
                self._lacks_frames = not taken

    def _tell_changes(self, chunk: ImuChunk) -> None:
        changes = self.now.health.add_chunk(chunk)
        step_s = chunk.time_step_s
        # All sensors at once are a gap of the link, reported as one below.
        if changes and len(changes) < max(2, len(self.now.health.placements)):
            for change in changes:
                kind = "sensor_lost" if change.is_lost else "sensor_back"
                if not change.is_lost:
                    self._first_seconds.restart(change.placement)
                    levels = self.now.aligner.clip_levels.copy()
                    levels[self.now.clock.declaration.placements.index(change.placement)] = np.inf
                    self._cut_off(levels)
                self.add_event(kind, change.tick * step_s, placement=change.placement)
        for gap in self.now.aligner.gaps:
            if not gap.is_bridged:
                text = say("live.gap", missing_s=gap.tick_count * step_s)
                self.add_event("gap", gap.first_tick * step_s, gap.tick_count * step_s, text=text)
        self.now.aligner.gaps.clear()
