"""All live sessions of this process: opened by a hello, steered by people, closed into analysis."""

import asyncio
import logging
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from sqlalchemy import Engine

from app.errors import Conflict, InvalidInput, PacketError, TelemotionError, Unavailable
from app.ingest.declaration import Declaration
from app.ingest.messages import HelloMessage
from app.live import repository
from app.live.blocks import layout_message
from app.live.bus import Bus, topic
from app.live.intake import Intake
from app.live.messages import LayoutMessage, StateMessage
from app.live.rebuild import rebuild
from app.live.runner import LiveSession
from app.live.states import OPEN, STREAMING
from app.live.warmup import prepare_process, warm_up
from app.recordings import GroupCommitWriter
from app.recordings.schemas import CalibrationOut
from estimators import pipelines
from estimators.errors import SetupError
from estimators.pipelines import SessionSetup

logger = logging.getLogger(__name__)

HOUSEKEEPING_S = 0.25
HEALTH_EVERY_TURNS = 2
LINK_LOST_AFTER_S = 2.0
IDLE_CLOSE_S = 600.0
"""A session without packets for so long is closed and analysed."""
REORDER_PATIENCE_S = 0.3
Answer = TypeVar("Answer")
_IDLE = "Closed by itself: nothing came for ten minutes."


class LiveManager:
    """Finds, opens, watches and closes live sessions.

    Parameters
    ----------
    engine : Engine
    writer : GroupCommitWriter
        Started.
    bus : Bus
    on_closed : callable(session_id)
        Called in a thread when everything of a session is stored: queues its analysis, once.
    """

    def __init__(
        self,
        engine: Engine,
        writer: GroupCommitWriter,
        bus: Bus,
        on_closed: Callable[[str], None],
        *,
        idle_close_s: float = IDLE_CLOSE_S,
    ) -> None:
        self.engine = engine
        self.writer = writer
        self.bus = bus
        self._on_closed = on_closed
        self._idle_close_s = idle_close_s
        self._sessions: dict[str, LiveSession] = {}
        self._intakes: dict[str, Intake] = {}
        self._opening: dict[str, asyncio.Lock] = {}
        self._closing: dict[str, asyncio.Task[None]] = {}
        self._housekeeper: asyncio.Task[None] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._is_stopping = False
        # One thread: the checks of many sockets at once must not outnumber the event loop for the interpreter.
        self._checks = ThreadPoolExecutor(1, thread_name_prefix="live-checks")
        self._abandoned_s: dict[str, float] = {}
        self._tasks: set[asyncio.Task[Any]] = set()

    async def start(self) -> None:
        """Compile what estimation needs, take note of interrupted sessions, begin to watch."""
        self._loop = asyncio.get_running_loop()
        await asyncio.to_thread(warm_up)
        prepare_process()
        for stored in await asyncio.to_thread(repository.interrupted, self.engine):
            if stored.state == "closing":
                await asyncio.to_thread(self._on_closed, stored.id)
                continue
            self._abandoned_s[stored.id] = time.monotonic()
            if stored.state != "link_lost":
                await asyncio.to_thread(
                    repository.save_state, self.engine, stored.id, "link_lost", "The service was restarted."
                )
        self._housekeeper = asyncio.create_task(self._watch(), name="live housekeeping")

    async def stop(self) -> None:
        """Store what is known and let the gateways come back to the next service."""
        self._is_stopping = True
        if self._housekeeper is not None:
            self._housekeeper.cancel()
            await asyncio.gather(self._housekeeper, return_exceptions=True)
        for intake in list(self._intakes.values()):
            intake.end(Unavailable("The service is stopping; connect again.", reason="stopping"))
        await asyncio.gather(*self._closing.values(), return_exceptions=True)
        for session in list(self._sessions.values()):
            session.link_lost("The service was stopped.")
            await session.saved()
        self._checks.shutdown(cancel_futures=True)

    def find(self, session_id: str) -> LiveSession | None:
        """Return a session that is live here, or None."""
        return self._sessions.get(session_id)

    @property
    def sessions(self) -> list[LiveSession]:
        """Every session that is live here."""
        return list(self._sessions.values())

    # --- gateways ---------------------------------------------------------------------------------------

    async def open(self, hello: HelloMessage, declaration: Declaration) -> Intake:
        """Open the session of a hello's ticket; implements `app.ingest.websocket.PacketSink`.

        Raises
        ------
        SignInRequired, NotFound, NotAllowed
            The ticket or the right behind it is not valid.
        PacketError
            The network is not that of the session.
        Conflict
            The session is closed.
        """
        if self._is_stopping:
            raise Unavailable("The service is stopping; connect again in a moment.", retry_after_s=5)
        subject, stored = await asyncio.to_thread(repository.open_by_ticket, self.engine, hello.ticket)
        async with self._opening.setdefault(stored.id, asyncio.Lock()):
            session = self._sessions.get(stored.id)
            if session is None:
                session = await self._open_session(stored.id, declaration)
            else:
                _check_network(session.declaration, declaration)
            if session.state not in OPEN:
                raise Conflict("This session is closed; create another one.", state=session.state)
            may_stream = partial(repository.still_allowed, self.engine, subject, stored.id, "record")
            intake = Intake(session, partial(self.check, may_stream), self._detach)
            before = self._intakes.get(stored.id)
            if before is not None:
                before.end(Conflict("A newer connection has taken over this session.", reason="superseded"))
            self._intakes[stored.id] = intake
            session.connected()
        self.bus.publish(topic(stored.id, "layout"), session.layout())
        return intake

    def _detach(self, intake: Intake) -> None:
        if self._intakes.get(intake.session_id) is intake:
            del self._intakes[intake.session_id]
            session = self._sessions.get(intake.session_id)
            if session is not None:
                if session.ledger.last_sequence is not None and session.state in OPEN:
                    self._close_soon(session.id, "The gateway has ended the stream.")
                else:
                    session.link_lost("The connection to the gateway ended.")

    async def _open_session(self, session_id: str, declaration: Declaration) -> LiveSession:
        stored = await asyncio.to_thread(repository.load, self.engine, session_id)
        if stored.state not in OPEN or stored.is_ended:
            raise Conflict("This session is closed; create another one.", state=stored.state)
        known = None if stored.hello is None else Declaration.from_dict(stored.hello)
        if known is not None:
            _check_network(known, declaration)
            declaration = known
        setup = _setup_for(SessionSetup.from_dict(stored.setup), declaration)
        try:
            pipeline = pipelines.create(setup)
        except SetupError as error:
            raise InvalidInput(str(error)) from error
        result_id, first_unstored = await asyncio.to_thread(
            repository.begin_stream, self.engine, session_id, declaration.to_dict(), pipeline
        )
        session = LiveSession(
            stored,
            declaration,
            pipeline,
            engine=self.engine,
            writer=self.writer,
            bus=self.bus,
            result_id=result_id,
            first_unstored_tick=first_unstored,
        )
        session.ledger.durable = await asyncio.to_thread(
            self.writer.open_session, session_id, session.on_durable, session.on_store_failure
        )
        session.ledger.received = session.ledger.durable.copy()
        if len(session.ledger.durable):
            trouble = await asyncio.to_thread(rebuild, session, self.engine)
            if trouble is not None:
                session.line.stop(trouble)
        self._sessions[session_id] = session
        self._abandoned_s.pop(session_id, None)
        return session

    # --- people -----------------------------------------------------------------------------------------

    def live(self, session_id: str) -> LiveSession:
        """Return a live session.

        Raises
        ------
        Conflict
            No gateway has connected to it here.
        """
        session = self._sessions.get(session_id)
        if session is None:
            raise Conflict("No body network is connected to this session; start the gateway first.")
        return session

    async def close(self, session_id: str, reason: str) -> StateMessage:
        """Close a session: store everything, then have it analysed. Closing twice is closing once.

        Raises
        ------
        NotFound
            There is no such session.
        """
        if session_id not in self._closing:
            session = self._sessions.get(session_id)
            if session is None:
                stored = await asyncio.to_thread(repository.load, self.engine, session_id)
                if stored.state not in OPEN or stored.is_ended:
                    return self.stored_state(stored)
                await asyncio.to_thread(repository.save_state, self.engine, session_id, "closing", reason)
            else:
                session.begin_closing(reason)
            task = asyncio.create_task(self._finish(session_id, session), name="session close")
            self._closing[session_id] = task
            task.add_done_callback(lambda _: self._closing.pop(session_id, None))
        return await self.state(session_id)

    async def _finish(self, session_id: str, session: LiveSession | None) -> None:
        try:
            if session is not None:
                await session.finish()
            else:
                await asyncio.to_thread(repository.end_abandoned, self.engine, session_id)
            await asyncio.to_thread(self._on_closed, session_id)
        except TelemotionError as error:
            logger.error("session %s could not be closed: %s", session_id, error.message)
            await asyncio.to_thread(repository.save_state, self.engine, session_id, "failed", error.message)
        finally:
            self._sessions.pop(session_id, None)
            self._opening.pop(session_id, None)
            if session is not None:
                session.is_finished = True

    def task_done(self, session_id: str) -> None:
        """Tell views of a session that its analysis has changed its state; from any thread."""
        if self._loop is not None and not self._is_stopping:
            self._loop.call_soon_threadsafe(self._tell_stored, session_id)

    def _tell_stored(self, session_id: str) -> None:
        async def tell() -> None:
            stored = await asyncio.to_thread(repository.load, self.engine, session_id)
            self.bus.publish(topic(session_id, "state"), self.stored_state(stored))

        if session_id not in self._sessions and self.bus.has_listeners(topic(session_id, "state")):
            self._keep(asyncio.create_task(tell(), name="tell stored state"))

    async def state(self, session_id: str) -> StateMessage:
        """Return the state of any session, live or not."""
        session = self._sessions.get(session_id)
        if session is not None:
            return session.state_message()
        return self.stored_state(await asyncio.to_thread(repository.load, self.engine, session_id))

    def stored_state(self, stored: repository.StoredSession) -> StateMessage:
        """Return the state of a session that is not live here."""
        calibration = repository.calibration_of(stored.setup)
        return StateMessage(
            state=stored.state,
            reason=stored.state_reason,
            session_time_s=0.0,
            recording_start_s=None,
            calibration=calibration
            and CalibrationOut(
                method=calibration.method, score=calibration.score, reasons=list(calibration.reasons)
            ),
            calibration_progress=None,
        )

    def stored_layout(self, stored: repository.StoredSession) -> LayoutMessage:
        """Return the columns that the session's frames will have."""
        setup = SessionSetup.from_dict(stored.setup)
        return layout_message(stored.id, pipelines.create(setup).layout, setup.rate_hz)

    async def check(self, work: Callable[[], Answer]) -> Answer:
        """Run a small database read in the thread kept for checks of open sockets."""
        return await asyncio.get_running_loop().run_in_executor(self._checks, work)

    # --- watching ---------------------------------------------------------------------------------------

    async def _watch(self) -> None:
        turn = 0
        while True:
            await asyncio.sleep(HOUSEKEEPING_S)
            turn += 1
            try:
                for number, session in enumerate(list(self._sessions.values())):
                    self._look_after(session, publish=(turn + number) % HEALTH_EVERY_TURNS == 0)
                    # Packets come first: all sessions together would hold them up for tens of milliseconds.
                    await asyncio.sleep(0)
                self._close_abandoned()
            except Exception:
                logger.exception("looking after the live sessions failed")

    def _look_after(self, session: LiveSession, *, publish: bool) -> None:
        silence_s = time.monotonic() - session.last_arrival_s
        if silence_s > REORDER_PATIENCE_S:
            session.silent()
        said_goodbye = session.ledger.last_sequence is not None
        if silence_s > LINK_LOST_AFTER_S and session.state in STREAMING and not said_goodbye:
            session.link_lost(f"No packet for {LINK_LOST_AFTER_S:.0f} s.")
        if publish:
            session.publish_health()
        if session.state in OPEN and session.ledger.is_settled:
            self._close_soon(session.id, "The gateway has sent everything.")
        elif session.state in OPEN and silence_s > self._idle_close_s:
            self._close_soon(session.id, _IDLE)

    def _close_abandoned(self) -> None:
        """Close sessions that were open when the service stopped and to which no gateway came back."""
        now = time.monotonic()
        for session_id, since in list(self._abandoned_s.items()):
            if now - since > self._idle_close_s:
                del self._abandoned_s[session_id]
                self._close_soon(session_id, _IDLE)

    def _close_soon(self, session_id: str, reason: str) -> None:
        if session_id not in self._closing:
            self._keep(asyncio.create_task(self.close(session_id, reason), name="close by itself"))

    def _keep(self, task: asyncio.Task[Any]) -> None:
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _check_network(known: Declaration, declared: Declaration) -> None:
    if not known.same_network(declared):
        raise PacketError(
            "This session began with another network (placements, rate, scales or clip levels); connect with"
            " the same, or close it and create another session.",
            reason="network_changed",
        )


def _setup_for(setup: SessionSetup, declaration: Declaration) -> SessionSetup:
    """Return the setup in the packet order and at the rate of the gateway."""
    if set(setup.placements) != set(declaration.placements):
        raise PacketError(
            "The hello's placements are not those of the session"
            f" ({', '.join(setup.placements)}); create the session for the sensors that are worn.",
            reason="placements",
        )
    return replace(setup, placements=declaration.placements, rate_hz=declaration.rate_hz)
