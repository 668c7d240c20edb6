"""One live session: packets to the store, to the common tick, to frames, to the store and the bus.

Everything here runs on the event loop's thread unless it says otherwise. An error in the estimation fails
this session's live view only: packets are stored all the same.
"""

import asyncio
import logging
import time
from functools import partial

from sqlalchemy import Engine

from app.errors import Conflict, InvalidInput, TelemotionError, Unavailable
from app.live import repository
from app.live.blocks import PublishedFrames, layout_message
from app.live.bus import Bus
from app.live.calibration.device_rows import save_device_constants
from app.live.checks.first_seconds import ALL_SESSIONS, FirstSeconds
from app.live.checks.force_watch import ForceWatch
from app.live.checks.plausibility import Check, check
from app.live.checks.unexpected_emission import UnexpectedEmission
from app.live.checks.worn_watch import WornWatch
from app.live.engine.lane import Parts
from app.live.guidance.controller import GuidanceController
from app.live.messages import HealthMessage, LayoutMessage, StateMessage
from app.live.session.actuation import Actuation
from app.live.session.estimation import EstimationLine
from app.live.session.pooled import PooledSession
from app.live.session.saver import until_written
from app.live.session.states import OPEN, STREAMING, streaming_state
from app.network.declaration import Declaration
from app.network.packet import Packet, PacketFlag
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.recordings.analysis.kinds import kind_of
from app.recordings.models import DEAD_LINK
from app.recordings.schemas import CalibrationOut
from app.recordings.signals.group_commit import GroupCommitWriter
from app.schemas import SessionState
from estimators.calibration import Finding, Hemisphere
from estimators.pipelines import Frames, Pipeline
from estimators.recording import Float, ImuChunk
from estimators.sentences import CATALOGUE, say

logger = logging.getLogger(__name__)

BACKLOG_S = 120.0
"""Estimation may lag so far behind storage before the gateway is asked to wait."""
_BACKFILLED = int(PacketFlag.BACKFILLED)


class LiveSession(PooledSession):
    """The live side of one session.

    Parameters
    ----------
    declaration : Declaration
        From the hello, with the clock epochs known.
    engine, writer, bus
        Resources of the service.
    result_id : str
        The live result.
    first_unstored_tick : int
        Frames before it are stored already.
    hemisphere : {"north", "south", "unknown"}
        Of the place: which way the magnetic field must point.
    check : Check
        Runs the checks of the first seconds, called in a thread.
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
        hemisphere: Hemisphere = "north",
        check: Check = check,
    ) -> None:
        super().__init__(stored, engine, writer, bus)
        self.stored = stored
        self.result_id = result_id
        self.lane = None
        self.now = Parts(declaration, pipeline, first_tick)
        self.opened_s = self._last_arrival_s = time.monotonic()
        self.duplicates = 0
        self.rebuilt_ticks = 0
        """Estimated once more when it was opened: those behind its checkpoint."""
        self.is_finished = False
        """Closed, and everything that came is stored."""
        self._has_store_failed = self._lacks_frames = self._is_link_dead = False
        self._unstored_tick = first_unstored_tick
        self._saved_declaration = declaration
        self._backlog_ticks = BACKLOG_S * declaration.rate_hz
        self.line = EstimationLine(pipeline, self._after, self._fail)
        self.guidance: GuidanceController | None = None

        def tell(kind: str, at_s: float, placement: str, text: str) -> None:
            self.add_event(kind, at_s, placement=placement, text=text)

        self.actuation = Actuation.of(pipeline, tell)
        self._stray = UnexpectedEmission(tell)
        self.prepare_calibration(hemisphere)
        self._forces = ForceWatch.of(pipeline)
        self._worn = WornWatch.of(pipeline)
        self._first_seconds = FirstSeconds(
            declaration.placements,
            declaration.time_step_s,
            self._implausible,
            hemisphere,
            ALL_SESSIONS,
            check,
            self._cut_off,
            declaration.clip_levels,
        )
        self._loop = asyncio.get_running_loop()

    @property
    def declaration(self) -> Declaration:
        """The network, with every clock epoch met."""
        return self.clock.declaration

    @property
    def session_time_s(self) -> float:
        """End of the newest packet."""
        return self.clock.session_time_us * 1e-6

    # --- packets ----------------------------------------------------------------------------------------

    def receive(self, packet: Packet, arrival_s: float, arrival_ns: int) -> bool:
        """Take one decoded packet; False when it was here before.

        Parameters
        ----------
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
            raise Conflict(say("live.closed"), state=self.machine.state)
        if self.line.waiting_ticks > self._backlog_ticks:
            raise Unavailable(say("live.behind"), retry_after_s=1, reason="behind")
        parts = self.parts
        place = parts.clock.admit(packet, arrival_s)
        if not self._writer.append_packet(self.id, RawPacket.from_packet(packet, arrival_ns, place.sequence)):
            self.duplicates += 1
            return False
        parts.ledger.received.add(place.sequence)
        self._last_arrival_s = arrival_s
        declaration = parts.clock.declaration
        if declaration is not self._saved_declaration:
            # A new clock epoch.
            parts.skew.reset()
            self._save_declaration()
        is_live = not packet.flags & _BACKFILLED
        if is_live:
            end_s = (place.time_us + packet.tick_count * packet.tick_interval_us) * 1e-6
            parts.health.add_packets(((end_s, arrival_s),))
            parts.skew.add(((end_s, arrival_s),))
        if self.machine.state == "link_lost":
            self._link_back()
        if self.line.is_running:
            chunk = parts.aligner.push(packet, place.sequence, place.time_us)
            if chunk is not None:
                self.line.push(chunk, arrival_s if is_live else None)
        return True

    # --- frames -----------------------------------------------------------------------------------------

    def _after(self, chunk: ImuChunk, frames: Frames, arrival_s: float | None) -> None:
        """Publish and store what the pipeline found."""
        frames = frames.as_stored_live()
        wanted = [one for one in (self.channels["blocks"], self.channels["frames"]) if one.listeners]
        if wanted:
            published = PublishedFrames(frames, time.time())
            for channel in wanted:
                channel.publish(published)
        if self.guidance is not None:
            self.guidance.see(frames, is_counting=self._is_counting, is_live=arrival_s is not None)
        if arrival_s is not None:
            self.now.health.latencies_s.append(time.monotonic() - arrival_s)
        if self.actuation is not None and self.machine.state in STREAMING:
            self.actuation.take(frames, self.declaration, is_live=arrival_s is not None)
        self.watch_source(chunk.first_tick, chunk.coil_state)
        self.store_frames(frames)
        self.now.health.set_flags(frames.layout.segments, frames.segment_flags)
        self._tell_changes(chunk)
        self._watch_forces(frames)
        self._watch_worn(frames, self.now.pipeline)
        if self._calibration.is_active:
            self._calibration.add(chunk)
        self._first_seconds.add(chunk)

    def _cut_off(self, levels: Float) -> None:
        """Flag from now on what lies at a clip level that nobody declared, also after a restart."""
        self.aligner.clip_levels[:] = levels
        known = self.clock.declaration
        self.clock.declaration = known.with_clips(levels, self.aligner.next_sequence)
        if self.clock.declaration is not known:
            self._save_declaration()

    def _save_declaration(self) -> None:
        self._saved_declaration = self.clock.declaration
        stored = self._saved_declaration.to_dict()
        self._saver.save(partial(repository.save_hello, self._engine, self.id, stored))

    def _implausible(self, findings: list[Finding], time_s: float) -> None:
        """Tell readings that cannot be right, before anybody trusts the estimate."""
        for finding in findings:
            logger.warning("session %s: %s of %s", self.id, finding.code, finding.sensor)
            details = {"code": finding.code, "severity": finding.severity}
            self.add_event(
                "implausible", time_s, placement=finding.sensor, text=finding.message, details=details
            )
        self._publish_state()

    def silent(self) -> None:
        """Give up waiting for reordered packets: nothing has come for a while."""
        if self.aligner.waiting and self.line.is_running:
            chunk = self.aligner.drain()
            if chunk is not None:
                self.line.push(chunk, None)

    # --- steering ---------------------------------------------------------------------------------------

    def record(self) -> None:
        """Begin the interval in which repetitions count; only from `ready`."""
        if self.machine.state != "ready":
            raise Conflict(say("live.record_first"), state=self.state)
        self.recording_start_s, self.recording_end_s = self.session_time_s, None
        self._save_recording()
        self._change("recording", "")

    def stop(self) -> None:
        """End the interval; only while recording, or when the link broke during a recording."""
        if not self._is_recording:
            raise Conflict(say("live.not_recording"), state=self.state)
        self.recording_end_s = self.session_time_s
        self._save_recording()
        if self.machine.state == "recording":
            self._change("ready", say("live.recording_stopped"))
        else:
            self._publish_state()

    def mark(self, text: str, label: str | None = None) -> None:
        """Put a note on the time line at the present session time; one with a label is read by the analysis.

        Raises
        ------
        InvalidInput
            This kind of session has no such label.
        """
        if label is None:
            self.add_event("mark", self.session_time_s, text=text)
            return
        marks = kind_of(self.pipeline.setup).marks
        if label not in marks:
            raise InvalidInput(say("live.unknown_mark", label=label, known=list(marks)), field="label")
        self.add_event("mark", self.session_time_s, text=marks[label], details={"label": label})

    def allow_source(self, is_allowed: bool, reason: str) -> None:
        """Let the magnetic source fire, or stop it at once and say why; nothing where there is none."""
        if self.actuation is not None and self.actuation.allow(is_allowed):
            kind, text = (
                ("source_allowed", say("live.source_allowed")) if is_allowed else ("source_stopped", reason)
            )
            self.add_event(kind, self.session_time_s, text=text)

    def connected(self) -> None:
        """Enter the streaming state: a gateway said hello."""
        self.clock.begin_connection()
        self._last_arrival_s = time.monotonic()
        if self.machine.state in {"created", "link_lost"}:
            self._link_back()

    def wait_for_service(self) -> None:
        """Note that the gateway is not silent: store or estimation are behind and cannot take its packets yet."""
        self._last_arrival_s = time.monotonic()

    def link_lost(self, reason: str) -> None:
        """Note that packets have stopped coming."""
        if self.machine.state in STREAMING:
            self._calibration.link_lost()
            self._change("link_lost", reason)

    def link_died(self, reason: str) -> None:
        """Note on the time line, once for each loss, that it lasts long."""
        if not self._is_link_dead:
            self._is_link_dead = True
            self.add_event(DEAD_LINK, self.session_time_s, text=reason)

    def _link_back(self) -> None:
        self._is_link_dead = False
        if self._calibration.link_back():
            # What to do now is its hint.
            self._change("calibrating", "")
            return
        following = streaming_state(is_calibrated=self.is_calibrated, is_recording=self._is_recording)
        known = self.pipeline.setup.calibration
        reasons: dict[SessionState, str] = {
            "calibrating": say("live.connected_calibrate")
            if known is None or not known.unknown_headings
            else say("live.connected_directions"),
            "ready": say("live.connected"),
        }
        self._change(following, reasons.get(following, ""))

    def _fail(self, error: Exception) -> None:
        """Tell that the estimation has stopped; storing goes on."""
        self._calibration.end()
        logger.error("the estimation of session %s failed", self.id, exc_info=error)
        reason: str = say("live.estimation_failed")
        if isinstance(error, TelemotionError):
            reason = error.message
        self.add_event("error", self.session_time_s, text=reason)
        if self.machine.may("failed"):
            self._change("failed", reason)

    # --- telling ----------------------------------------------------------------------------------------

    def state_message(self) -> StateMessage:
        """Return the state for people."""
        calibration = self.pipeline.setup.calibration
        return StateMessage(
            state=self.machine.state,
            reason=self.machine.reason,
            session_time_s=self.session_time_s,
            recording_start_s=self.recording_start_s if self._is_recording else None,
            calibration=None if calibration is None else CalibrationOut.of(calibration),
            calibration_progress=self._calibration.progress,
            calibration_hint=CATALOGUE.together((self._first_seconds.hint, self._calibration.hint)),
        )

    def health_message(self) -> HealthMessage:
        """Return link health."""
        parts = self.parts
        median, high = parts.health.latency_ms()
        # Once a second for each session: its types are known here.
        return HealthMessage.model_construct(
            sensors=parts.health.sensors(self.machine.state in STREAMING or self.machine.state == "failed"),
            packets_received=len(parts.ledger.received),
            packets_stored=len(parts.ledger.durable),
            packets_missing=parts.ledger.missing_count,
            is_being_stored=self.is_being_stored(),
            latency_ms_median=median,
            latency_ms_p99=high,
            clock_skew_ppm=parts.skew.skew_ppm,
        )

    @property
    def has_store_failed(self) -> bool:
        """Whether nothing of it can be stored any more."""
        return self._has_store_failed

    @property
    def lacks_frames(self) -> bool:
        """Whether the store had no room for the newest frames: they can be estimated again from their packets."""
        return self._lacks_frames

    def is_being_stored(self) -> bool:
        """Whether what comes is stored; looked at with every turn of the housekeeping."""
        return not self._has_store_failed and self.now.ledger.is_being_stored()

    def layout(self) -> LayoutMessage:
        """Return the columns of the frames."""
        found = self.pipeline
        return layout_message(self.id, found.layout, self.declaration.rate_hz, found.delay_ticks)

    def on_durable(self, durable: SequenceRanges) -> None:
        """Take the committed set; called from the writer's thread."""
        self._loop.call_soon_threadsafe(setattr, self.now.ledger, "durable", durable)

    def on_store_failure(self, error: TelemotionError) -> None:
        """Stop: nothing of this session can be stored any more; called from the writer's thread."""
        self._loop.call_soon_threadsafe(self._store_failed, error)

    def _store_failed(self, error: TelemotionError) -> None:
        self._has_store_failed = True
        self.line.is_running = False
        self.settle()
        if self.machine.may("failed"):
            self.machine.to("failed", error.message)
        self._publish_state()

    # --- saving and ending ------------------------------------------------------------------------------

    async def finish(self) -> None:
        """Estimate what still waits, then store everything; the state is `closing` before."""
        self._calibration.end()
        self.settle()
        self.silent()
        await self.line.drained()
        await asyncio.wrap_future(self._writer.flush(self.id))
        await self._saver.saved()
        serials, pipeline = self.declaration.serial_of, self.pipeline
        known = (self.id, self.result_id, self.session_time_s, self.ledger.missing_count)

        def save_constants() -> None:
            # What was learnt is computed here, in the thread that writes: of many sensors it takes milliseconds.
            save_device_constants(self._engine, self.id, serials, pipeline.device_constants)

        for write in (save_constants, partial(repository.finish_stream, self._engine, *known)):
            await until_written(write)
        self._writer.close_session(self.id)

    def begin_closing(self, reason: str) -> None:
        """Take no more packets."""
        if self._is_recording:
            self.recording_end_s = self.session_time_s
            self._save_recording()
        self._change("closing", reason)
