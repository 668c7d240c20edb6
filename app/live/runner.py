"""One live session: packets to the store, to the common tick, to frames, to the store and the bus.

Everything here runs on the event loop's thread unless it says otherwise. An error in the estimation fails
this session's live view only: packets are stored all the same.
"""

import asyncio
import logging
import time
from dataclasses import fields, replace
from functools import partial

from sqlalchemy import Engine

from app.errors import CalibrationFailed, Conflict, TelemotionError, Unavailable
from app.ingest.alignment import Aligner
from app.ingest.clock import PacketClock, SkewEstimator
from app.ingest.declaration import Declaration
from app.ingest.packet import Packet, PacketFlag
from app.live import repository
from app.live.blocks import PublishedFrames, layout_message
from app.live.bus import Bus, topic
from app.live.estimation import EstimationLine
from app.live.health import LinkHealth
from app.live.ledger import SequenceLedger
from app.live.messages import AcknowledgeMessage, EventMessage, HealthMessage, LayoutMessage, StateMessage
from app.live.pose import PoseCollector
from app.live.saver import Saver
from app.live.states import OPEN, STREAMING, StateMachine, streaming_state
from app.recordings import GroupCommitWriter, RawPacket, SequenceRanges
from app.recordings.schemas import CalibrationOut, SessionEventOut, SessionState
from estimators.errors import CalibrationError
from estimators.pipelines import Calibration, Frames, Pipeline
from estimators.recording import ImuChunk

logger = logging.getLogger(__name__)

BACKLOG_S = 120.0
"""Estimation may lag so far behind storage before the gateway is asked to wait."""
_FRAME_FIELDS = tuple(field.name for field in fields(Frames))


class LiveSession:
    """The live side of one session.

    Parameters
    ----------
    stored : StoredSession
    declaration : Declaration
        From the hello, with the clock epochs known.
    pipeline : Pipeline
    engine, writer, bus
        Resources of the service.
    result_id : str
        The live result.
    first_unstored_tick : int
        Frames before it are stored already.
    """

    def __init__(
        self,
        stored: repository.StoredSession,
        declaration: Declaration,
        pipeline: Pipeline,
        *,
        engine: Engine,
        writer: GroupCommitWriter,
        bus: Bus,
        result_id: str,
        first_unstored_tick: int = 0,
        first_tick: int = 0,
    ) -> None:
        self.id = stored.id
        self.stored = stored
        self.pipeline = pipeline
        self.result_id = result_id
        self.machine = StateMachine(stored.state, stored.state_reason)
        self.clock = PacketClock(declaration)
        self.aligner = Aligner(declaration, first_tick=first_tick)
        self.ledger = SequenceLedger()
        self.skew = SkewEstimator()
        self.health = LinkHealth(declaration.placements, declaration.time_step_s)
        self.recording_start_s = stored.recording_start_s
        self.recording_end_s = stored.recording_end_s
        self.last_arrival_s = time.monotonic()
        self.duplicates = 0
        self.is_finished = False
        """Closed, and everything that came is stored."""
        self._engine, self._writer, self._bus = engine, writer, bus
        self._topics = {
            name: topic(self.id, name) for name in ("frames", "state", "health", "event", "layout")
        }
        self._unstored_tick = first_unstored_tick
        self._epochs_saved = len(declaration.clock_epochs)
        self._saver = Saver(self.id)
        self._pose = PoseCollector(declaration.placements, declaration.time_step_s)
        self.line = EstimationLine(pipeline, self._after, self._fail)
        self._loop = asyncio.get_running_loop()

    @property
    def declaration(self) -> Declaration:
        """The network, with every clock epoch met."""
        return self.clock.declaration

    @property
    def state(self) -> SessionState:
        """The present state."""
        return self.machine.state

    @property
    def session_time_s(self) -> float:
        """End of the newest packet."""
        return self.clock.session_time_us * 1e-6

    # --- packets ----------------------------------------------------------------------------------------

    def receive(self, packet: Packet, arrival_s: float, arrival_ns: int) -> bool:
        """Take one decoded packet; False when it was here before.

        Parameters
        ----------
        packet : Packet
        arrival_s : float
            Monotonic.
        arrival_ns : int
            Since the epoch, stored with the packet.

        Raises
        ------
        PacketError
            It has no place in this session.
        Unavailable
            The store or the estimation is behind; wait and give the same packet again.
        Conflict
            The session takes no packets any more.
        """
        if self.machine.state not in OPEN:
            raise Conflict("This session is closed; create another one.", state=self.machine.state)
        if self.line.waiting_ticks > BACKLOG_S * self.declaration.rate_hz:
            raise Unavailable("The estimation is behind; wait a moment.", retry_after_s=1, reason="behind")
        place = self.clock.admit(packet, arrival_s)
        if not self._writer.append_packet(self.id, RawPacket.from_packet(packet, arrival_ns, place.sequence)):
            self.duplicates += 1
            return False
        self.ledger.received.add(place.sequence)
        self.last_arrival_s = arrival_s
        if len(self.declaration.clock_epochs) != self._epochs_saved:
            self._epochs_saved = len(self.declaration.clock_epochs)
            self.skew.reset()
            self._saver.save(
                partial(repository.save_hello, self._engine, self.id, self.declaration.to_dict())
            )
        is_live = not packet.flags & PacketFlag.BACKFILLED
        if is_live:
            end_s = (place.time_us + packet.tick_count * packet.tick_interval_us) * 1e-6
            self.health.add_packet(end_s, arrival_s)
            self.skew.add(end_s, arrival_s)
        if self.machine.state == "link_lost":
            self._link_back()
        if self.line.is_running:
            chunk = self.aligner.push(packet, place.sequence, place.time_us)
            if chunk is not None:
                self.line.push(chunk, arrival_s if is_live else None)
        return True

    def _after(self, chunk: ImuChunk, frames: Frames, arrival_s: float | None) -> None:
        """Publish and store what the pipeline found."""
        frames = PublishedFrames(
            **{name: getattr(frames, name) for name in _FRAME_FIELDS}, published_at_s=time.time()
        )
        self._bus.publish(self._topics["frames"], frames)
        if arrival_s is not None:
            self.health.latencies_s.append(time.monotonic() - arrival_s)
        self.store_frames(frames)
        self.health.set_flags(frames.layout.segments, frames.segment_flags[-1])
        self._tell_changes(chunk)
        self._watch_pose(chunk)

    def store_frames(self, frames: Frames) -> None:
        """Store frames unless that was done before a restart."""
        if frames.first_tick >= self._unstored_tick:
            self._writer.append_frames(self.id, self.result_id, frames)

    def _tell_changes(self, chunk: ImuChunk) -> None:
        changes = self.health.add_chunk(chunk)
        step_s = chunk.time_step_s
        # All sensors at once are a gap of the link, told as one below.
        if len(changes) < max(2, len(self.health.placements)):
            for change in changes:
                kind = "sensor_lost" if change.is_lost else "sensor_back"
                self.add_event(kind, change.tick * step_s, placement=change.placement)
        if self.aligner.gaps:
            for gap in self.aligner.gaps:
                if not gap.is_bridged:
                    text = f"{gap.tick_count * step_s:.2f} s missing"
                    self.add_event("gap", gap.first_tick * step_s, gap.tick_count * step_s, text=text)
            self.aligner.gaps.clear()

    def silent(self) -> None:
        """Give up waiting for reordered packets: nothing has come for a while."""
        if self.aligner.waiting and self.line.is_running:
            chunk = self.aligner.drain()
            if chunk is not None:
                self.line.push(chunk, None)

    # --- calibration ------------------------------------------------------------------------------------

    def calibrate(self) -> None:
        """Begin to look for three still seconds.

        Raises
        ------
        Conflict
            No packets come, or a recording runs.
        """
        if self.machine.state not in {"calibrating", "ready"}:
            raise Conflict(
                "Calibration needs a connected body network and no running recording; stop the recording or"
                " connect first.",
                state=self.machine.state,
            )
        self._pose.begin()
        self._change("calibrating", "Hold the pose.")

    def _watch_pose(self, chunk: ImuChunk) -> None:
        before = self._pose.hint, round(self._pose.progress or 0.0, 1)
        pose = self._pose.add(chunk)
        if pose is not None:
            self.line.call(partial(self._calibrate, pose))
        elif (self._pose.hint, round(self._pose.progress or 0.0, 1)) != before:
            self._publish_state()

    def _calibrate(self, pose: ImuChunk) -> None:
        """Run the pipeline's calibration; called in the worker's thread, between two steps."""
        try:
            found = self.pipeline.calibrate(pose)
        except CalibrationError as error:
            self._loop.call_soon_threadsafe(self._calibration_failed, str(error), pose)
        else:
            self._loop.call_soon_threadsafe(self._calibrated, found, pose)

    def _calibration_failed(self, message: str, pose: ImuChunk) -> None:
        self._pose.end(message)
        self.add_event("error", pose.first_tick * pose.time_step_s, text=CalibrationFailed(message).message)
        self.machine.reason = message[:500]
        self._publish_state()

    def _calibrated(self, found: Calibration, pose: ImuChunk) -> None:
        setup = self.pipeline.setup
        self.stored = replace(self.stored, setup=setup.to_dict())
        self._saver.save(partial(repository.save_calibration, self._engine, self.id, self.result_id, setup))
        self.add_event(
            "calibration",
            pose.first_tick * pose.time_step_s,
            pose.tick_count * pose.time_step_s,
            text="; ".join(found.reasons),
        )
        self._bus.publish(self._topics["layout"], self.layout())
        if self.machine.state == "calibrating":
            self._change("ready", f"Calibrated, score {found.score:.2f}.")
        else:
            self._publish_state()

    # --- steering ---------------------------------------------------------------------------------------

    def record(self) -> None:
        """Begin the interval in which repetitions count; only from `ready`."""
        if self.machine.state != "ready":
            raise Conflict(
                "Recording begins when the session is ready: connected and calibrated.", state=self.state
            )
        self.recording_start_s, self.recording_end_s = self.session_time_s, None
        self._save_recording()
        self._change("recording", "")

    def stop(self) -> None:
        """End the interval; only while recording, or when the link broke during a recording."""
        if not self._is_recording:
            raise Conflict("Nothing is being recorded.", state=self.state)
        self.recording_end_s = self.session_time_s
        self._save_recording()
        if self.machine.state == "recording":
            self._change("ready", "Recording stopped.")
        else:
            self._publish_state()

    def mark(self, text: str) -> None:
        """Put a note on the time line at the present session time."""
        self.add_event("mark", self.session_time_s, text=text)

    @property
    def _is_recording(self) -> bool:
        return self.recording_start_s is not None and self.recording_end_s is None

    def connected(self) -> None:
        """Enter the streaming state: a gateway said hello."""
        self.clock.begin_connection()
        self.last_arrival_s = time.monotonic()
        if self.machine.state in {"created", "link_lost"}:
            self._link_back()

    def link_lost(self, reason: str) -> None:
        """Note that packets have stopped coming."""
        if self.machine.state in STREAMING:
            self._pose.end()
            self._change("link_lost", reason)

    def _link_back(self) -> None:
        is_calibrated = self.pipeline.setup.calibration is not None
        following = streaming_state(is_calibrated=is_calibrated, is_recording=self._is_recording)
        reasons: dict[SessionState, str] = {
            "calibrating": "Connected; calibrate when the patient holds the pose.",
            "ready": "Connected.",
        }
        self._change(following, reasons.get(following, ""))

    def _fail(self, error: Exception) -> None:
        """Tell that the estimation has stopped; storing goes on."""
        self._pose.end()
        logger.error("the estimation of session %s failed", self.id, exc_info=error)
        reason = "The live estimation failed; what the sensors send is stored and can be analysed afterwards."
        if isinstance(error, TelemotionError):
            reason = error.message
        self.add_event("error", self.session_time_s, text=reason)
        if self.machine.may("failed"):
            self._change("failed", reason)

    # --- telling ----------------------------------------------------------------------------------------

    def _change(self, state: SessionState, reason: str) -> None:
        changed = self.machine.to(state, reason)
        self._saver.save(partial(repository.save_state, self._engine, self.id, state, reason))
        if changed:
            logger.info("session %s is %s", self.id, state)
            self.add_event("state", self.session_time_s, text=state)
        self._publish_state()

    def _publish_state(self) -> None:
        self._bus.publish(self._topics["state"], self.state_message())

    def state_message(self) -> StateMessage:
        """Return the state for people."""
        calibration = self.pipeline.setup.calibration
        return StateMessage(
            state=self.machine.state,
            reason=self.machine.reason,
            session_time_s=self.session_time_s,
            recording_start_s=self.recording_start_s if self._is_recording else None,
            calibration=None
            if calibration is None
            else CalibrationOut(
                method=calibration.method, score=calibration.score, reasons=list(calibration.reasons)
            ),
            calibration_progress=self._pose.progress,
            calibration_hint=self._pose.hint,
        )

    def health_message(self) -> HealthMessage:
        """Return link health."""
        median, high = self.health.latency_ms()
        return HealthMessage(
            sensors=self.health.sensors(self.machine.state in STREAMING or self.machine.state == "failed"),
            packets_stored=len(self.ledger.received),
            packets_missing=self.ledger.missing_count,
            latency_ms_median=median,
            latency_ms_p99=high,
            clock_skew_ppm=self.skew.skew_ppm,
        )

    def publish_health(self) -> None:
        """Publish link health when somebody listens."""
        if self._bus.has_listeners(self._topics["health"]):
            self._bus.publish(self._topics["health"], self.health_message())

    def layout(self) -> LayoutMessage:
        """Return the columns of the frames."""
        return layout_message(self.id, self.pipeline.layout, self.declaration.rate_hz)

    def add_event(
        self,
        kind: str,
        time_s: float,
        duration_s: float = 0.0,
        *,
        placement: str | None = None,
        text: str = "",
    ) -> None:
        """Store and publish something on the time line."""
        self._writer.add_event(self.id, kind, time_s, duration_s=duration_s, placement=placement, text=text)
        event = SessionEventOut(
            kind=kind, time_s=time_s, duration_s=duration_s, placement=placement, text=text[:500]
        )
        self._bus.publish(self._topics["event"], EventMessage(event=event))

    def acknowledge(self, missing: list[tuple[int, int]]) -> AcknowledgeMessage:
        """Return what the gateway may forget."""
        highest = self.ledger.highest
        return AcknowledgeMessage(
            session_id=self.id,
            acknowledged=self.ledger.acknowledged,
            highest=highest,
            missing=[(start, min(stop, highest)) for start, stop in missing if start < highest],
            state=self.machine.state,
        )

    def on_durable(self, durable: SequenceRanges) -> None:
        """Take the committed set; called from the writer's thread."""
        self._loop.call_soon_threadsafe(setattr, self.ledger, "durable", durable)

    def on_store_failure(self, error: TelemotionError) -> None:
        """Stop: nothing of this session can be stored any more; called from the writer's thread."""
        self._loop.call_soon_threadsafe(self._store_failed, error)

    def _store_failed(self, error: TelemotionError) -> None:
        self.line.is_running = False
        if self.machine.may("failed"):
            self.machine.to("failed", error.message)
        self._publish_state()

    # --- saving and ending ------------------------------------------------------------------------------

    def _save_recording(self) -> None:
        self._saver.save(
            partial(
                repository.save_recording, self._engine, self.id, self.recording_start_s, self.recording_end_s
            )
        )

    async def saved(self) -> None:
        """Wait until every change so far is in the database."""
        await self._saver.saved()

    async def finish(self) -> None:
        """Estimate what still waits, then store everything; the state is `closing` before."""
        self._pose.end()
        self.silent()
        await self.line.drained()
        await asyncio.wrap_future(self._writer.flush(self.id))
        await self._saver.saved()
        await asyncio.to_thread(
            repository.finish_stream,
            self._engine,
            self.id,
            self.result_id,
            self.session_time_s,
            self.ledger.missing_count,
        )
        self._writer.close_session(self.id)

    def begin_closing(self, reason: str) -> None:
        """Take no more packets."""
        if self._is_recording:
            self.recording_end_s = self.session_time_s
            self._save_recording()
        self._change("closing", reason)
