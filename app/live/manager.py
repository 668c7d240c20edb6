"""All live sessions of this process: opened by a hello, steered by people, closed into analysis."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, Final
from weakref import WeakValueDictionary

from sqlalchemy import Engine

from app.accounts.subject import Subject
from app.errors import Conflict, TelemotionError, Unavailable
from app.kinds.magnetic.safety import CONFIRMATION_HOURS
from app.limits import Hold, Limits
from app.live import repository
from app.live.admission import FULL, crowd
from app.live.bus import Bus, topic
from app.live.engine.lane import Lane
from app.live.engine.shared import Shared
from app.live.guidance.controller import GuidanceController
from app.live.guidance.opening import is_to_be_guided
from app.live.housekeeping import GOODBYE_CLOSE_S, IDLE_CLOSE_S, LONGEST_S, Housekeeping
from app.live.messages import StateMessage
from app.live.rights.authorization_checks import AuthorizationCheck
from app.live.rights.grace_period import GracePeriod
from app.live.service import SteeredLiveService
from app.live.session.intake import Intake
from app.live.session.marks import Marks, all_stored
from app.live.session.opening import ANYWHERE, Opener, Place, check_network
from app.live.session.runner import LiveSession
from app.live.session.saver import until_written
from app.live.session.states import OPEN
from app.live.session.stored import stored_layout, stored_state
from app.live.session.streamed import Streamed
from app.live.warmup import COMING_BACK_S, PREPARING, prepare_process
from app.network.declaration import Declaration
from app.network.messages import HelloMessage
from app.recordings.signals.group_commit import GroupCommitWriter
from app.schemas import Schema
from estimators.pipelines import SessionSetup
from estimators.sentences import Sentence, say

logger = logging.getLogger(__name__)

_NOT_CLOSED = say("live.not_closed")
MARK_S: Final = 10.0
"""From one checkpoint of a session to the next: about so much of it at most is estimated again after a restart."""
ENDINGS: Final = 2
"""Sessions that end at the same time; more would hold the interpreter and the database against those that stream."""


class LiveManager(SteeredLiveService):
    """Finds, opens, watches and closes live sessions.

    Parameters
    ----------
    writer : GroupCommitWriter
        Started.
    on_closed : callable(session_id)
        Called in a thread when everything of a session is stored: queues its analysis, once.
    limits : Limits
        How many sessions may be live at once.
    place : Place
        Where it stands.
    confirmation_hours : float
        How long the word that nobody has an implant holds; a source is stopped when it ends.
    shared : Shared, optional
        By default made for this manager alone.
    """

    def __init__(
        self,
        engine: Engine,
        writer: GroupCommitWriter,
        bus: Bus,
        on_closed: Callable[[str], None],
        *,
        limits: Limits,
        idle_close_s: float = IDLE_CLOSE_S,
        goodbye_close_s: float = GOODBYE_CLOSE_S,
        longest_s: float = LONGEST_S,
        place: Place = ANYWHERE,
        confirmation_hours: float = CONFIRMATION_HOURS,
        shared: Shared | None = None,
    ) -> None:
        super().__init__(engine, bus)
        shared = shared or Shared()
        self.writer = writer
        self._confirmation_hours = confirmation_hours
        self._on_closed = on_closed
        self._sessions: dict[str, LiveSession] = {}
        self._limits = limits
        self._holds: dict[str, Hold] = {}
        self._intakes: dict[str, Intake] = {}
        # A lock lives as long as somebody opens or closes the session.
        self._opening: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()
        self._closing: dict[str, asyncio.Task[None]] = {}
        self._endings = asyncio.Semaphore(ENDINGS)
        self._housekeeping = Housekeeping(
            lambda: self.sessions,
            self._intakes.__contains__,
            self._close_soon,
            idle_close_s=idle_close_s,
            goodbye_close_s=goodbye_close_s,
            longest_s=longest_s,
            note=self._note_where,
            between_turns=shared.pooled.between_turns,
        )
        self._housekeeping.is_behind = lambda: shared.pooled.is_behind
        self._marks = Marks(MARK_S)
        self._is_stopping = False
        self._housekeeper: asyncio.Task[None] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._readiness = shared.readiness
        self._being_opened: set[str] = set()
        self._sent_away: dict[str, Sentence] = {}
        """Sessions whose gateway is to come again later, and why."""
        self.admission = shared.admission
        self._shared = shared
        shared.sides.add(self)
        self._measuring: asyncio.Task[None] | None = None
        self._check_process = shared.check
        self._opener = Opener(engine, writer, bus, place, self._check_process, rebuilding=shared.rebuilding)
        self._tasks: set[asyncio.Task[Any]] = set()
        self.pooled = shared.pooled

    async def start(self) -> None:
        """Compile what estimation needs, take note of interrupted sessions, begin to watch."""
        self._loop = asyncio.get_running_loop()
        left = await asyncio.to_thread(repository.interrupted, self.engine)
        await self._readiness.begin(COMING_BACK_S if any(one.state != "closing" for one in left) else 0.0)
        prepare_process()
        await asyncio.to_thread(repository.forget_ended, self.engine)
        for stored in await asyncio.to_thread(repository.interrupted, self.engine):
            if stored.state == "closing":
                await asyncio.to_thread(self._on_closed, stored.id)
                continue
            self._housekeeping.abandoned(stored.id)
            if stored.state != "link_lost":
                await asyncio.to_thread(
                    repository.save_state, self.engine, stored.id, "link_lost", say("live.restarted")
                )
        self._housekeeper = asyncio.create_task(self._housekeeping.run(), name="live housekeeping")
        measuring = self.admission.run(self.pooled.take_longest_s)
        self._measuring = asyncio.create_task(measuring, name="live admission")

    async def stop(self) -> None:
        """Store what is known and let the gateways come back to the next service."""
        self._is_stopping = True
        self._readiness.end()
        for task in (self._housekeeper, self._measuring):
            if task is not None:
                task.cancel()
                await asyncio.gather(task, return_exceptions=True)
        for intake in list(self._intakes.values()):
            intake.end(Unavailable(say("live.stopping"), reason="stopping"))
        await asyncio.gather(*self._closing.values(), return_exceptions=True)
        for session in self.sessions:
            session.link_lost(say("live.stopped"))
            session.settle()
            self._note_where(session, is_last=True)
        for session in self.sessions:
            await session.saved()
        await all_stored(self.writer, self.sessions)
        self.end_checks()
        await asyncio.to_thread(self._check_process.close)

    def find(self, session_id: str) -> LiveSession | None:
        """Return a session that is live here, or None."""
        return self._sessions.get(session_id)

    @property
    def sessions(self) -> list[LiveSession]:
        """Every session that is live here."""
        return list(self._sessions.values())

    @property
    def session_count(self) -> int:
        """How many sessions are live here."""
        return len(self._sessions)

    def _note_where(self, session: LiveSession, *, is_last: bool = False) -> None:
        """Have it stored where the estimation of a session stands, now and then: a restart goes on from there."""
        self._marks.store(self.writer, session, is_last=is_last)

    # --- gateways ---------------------------------------------------------------------------------------

    async def open(self, hello: HelloMessage, declaration: Declaration) -> Intake:
        """Open the session of a hello's ticket; implements `app.ingest.contract.PacketSink`.

        Raises
        ------
        SignInRequired, NotFound, NotAllowed
            The ticket or the right behind it is not valid.
        PacketError
            The network is not that of the session.
        Conflict
            The session is closed.
        LimitReached, Unavailable
            Too many sessions are live, or the machine carries no more.
        """
        if self._is_stopping:
            raise Unavailable(say("live.stopping"), retry_after_s=5)
        subject, stored = await asyncio.to_thread(
            repository.open_by_ticket, self.engine, hello.ticket, self._confirmation_hours
        )
        session = await self.join(stored, declaration, subject)
        right = AuthorizationCheck(subject, stored.id, "record")
        intake = self.attach(session, partial(self._check_gateway, session, right, GracePeriod()))
        session.connected()
        self.announce(session)
        return intake

    def attach(self, session: LiveSession, check_right: Callable[[], Awaitable[None]]) -> Intake:
        """Return a new connection's way into a session; it takes the place of the one before."""
        intake = Intake(session, check_right, self._detach, self.pooled)
        before = self._intakes.get(session.id)
        if before is not None:
            before.end(Conflict(say("live.superseded"), reason="superseded"))
        self._intakes[session.id] = intake
        return intake

    async def join(
        self,
        stored: repository.StoredSession,
        declaration: Declaration,
        subject: Subject | None = None,
        *,
        is_admitted: bool = False,
        streamed: Streamed | None = None,
    ) -> LiveSession:
        """Return the live session of a stored one, opened when it is not live yet; raises as `open`.

        Parameters
        ----------
        subject : Subject, optional
            Whose limits count a session that is opened.
        is_admitted : bool
            Open it also where there is no room: packets of it were acknowledged already.
        streamed : Streamed, optional
            What is stored of it, read already.
        """
        async with self._opening.setdefault(stored.id, asyncio.Lock()):
            if stored.id in self._closing:
                raise Conflict(say("live.closed"), state="closing")
            session = self._sessions.get(stored.id)
            if session is None:
                if stored.state == "created" and not is_admitted:
                    self._admit(stored.id)
                hold = None if subject is None else self._limits.take("streams", subject)
                self._being_opened.add(stored.id)
                try:
                    session = await self._opener.open(
                        stored.id, declaration, partial(self._prepared, stored.id), streamed
                    )
                except BaseException:
                    if hold is not None:
                        hold.release()
                    raise
                finally:
                    self._being_opened.discard(stored.id)
                if hold is not None:
                    self._holds[stored.id] = hold
                self._sessions[stored.id] = session
                session.lane = Lane(session, self.pooled)
                self._housekeeping.taken_up(stored.id)
            else:
                check_network(session.declaration, declaration)
            if session.state not in OPEN:
                raise Conflict(say("live.closed"), state=session.state)
            # Asked again: the confirmation may have been revoked while the session was being opened.
            await self.check_source(stored.id)
            return session

    def announce(self, session: LiveSession) -> None:
        """Publish the layout of a session that has come alive to the views that are open."""
        self.bus.publish(topic(session.id, "layout"), session.layout())
        if session.guidance is not None:
            # Who watches already has heard nothing of it: the session was not live.
            self.bus.publish(topic(session.id, "guidance"), session.guidance.message)

    def _detach(self, intake: Intake) -> None:
        if self._intakes.get(intake.session_id) is intake:
            del self._intakes[intake.session_id]
            if (session := self._sessions.get(intake.session_id)) is not None:
                # What came with it counts before its end.
                self.pooled.take(session.lane)
                # After a goodbye with nothing missing the housekeeping closes the session; otherwise the
                # gateway still has packets to bring.
                session.link_lost(say("live.connection_ended"))

    def _admit(self, session_id: str) -> None:
        """Let a session in that has not streamed yet, while there is room."""
        streaming, quiet = crowd(self._shared.sessions)
        try:
            self.admission.require_room(streaming, quiet + len(self._being_opened))
        except Unavailable:
            self._send_away(session_id, FULL)
            raise
        self._sent_away.pop(session_id, None)

    async def _prepared(self, session_id: str, setup: SessionSetup) -> None:
        try:
            await self._readiness.require(setup)
            if not self._readiness.is_guiding and await asyncio.to_thread(
                is_to_be_guided, self.engine, session_id, self._opener.place.time_zone
            ):
                await self._readiness.require_guidance()
        except Unavailable:
            self._send_away(session_id, PREPARING)
            raise
        self._sent_away.pop(session_id, None)

    def _send_away(self, session_id: str, why: Sentence) -> None:
        """Show at the session why its gateway is to come again later."""
        self._sent_away[session_id] = why
        self._tell_stored(session_id)

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
            raise Conflict(say("live.not_connected"))
        return session

    def guidance(self, session_id: str) -> GuidanceController:
        """Return the guidance of a live session.

        Raises
        ------
        Conflict
            No gateway has connected to it here.
        """
        session = self.live(session_id)
        # What it says and stores has the time of the newest packet.
        session.settle()
        found = session.guidance
        if found is None:
            raise Conflict(say("live.not_connected"))
        return found

    async def first_messages(self, stored: repository.StoredSession) -> list[Schema]:
        """Return what a view receives when it connects: layout and state first."""
        session = self._sessions.get(stored.id)
        if session is None:
            layout = await asyncio.to_thread(stored_layout, stored)
            return [layout, self.stored_state(stored)]
        first: list[Schema] = [session.layout(), session.state_message(), session.health_message()]
        if session.calibration_message is not None:
            first.append(session.calibration_message)
        if session.guidance is not None:
            first.append(session.guidance.message)
        return first

    async def close(self, session_id: str, reason: str) -> StateMessage:
        """Close a session: store everything, then have it analysed. Closing twice is closing once.

        Raises
        ------
        NotFound
            There is no such session.
        """
        # A hello may be opening the session at this moment: whoever is first decides.
        async with self._opening.setdefault(session_id, asyncio.Lock()):
            if session_id not in self._closing:
                session = self._sessions.get(session_id)
                if session is None:
                    stored = await asyncio.to_thread(repository.load, self.engine, session_id)
                    if stored.state not in OPEN or stored.is_ended:
                        return self.stored_state(stored)
                    await asyncio.to_thread(repository.close_absent, self.engine, session_id, reason)
                else:
                    # What came before the wish to close is taken.
                    self.pooled.take(session.lane)
                    session.begin_closing(reason)
                self._housekeeping.taken_up(session_id)
                task = asyncio.create_task(self._finish(session_id, session), name="session close")
                self._closing[session_id] = task
                task.add_done_callback(lambda _: self._closing.pop(session_id, None))
        return await self.state(session_id)

    async def reopen(self, session_id: str) -> StateMessage:
        """Let a session that has ended take the packets that its gateway still has; it ends again as any other.

        Raises
        ------
        NotFound, Conflict, Unavailable
            As `repository.reopen`; unavailable too while it is being closed.
        """
        async with self._opening.setdefault(session_id, asyncio.Lock()):
            if session_id in self._closing:
                raise Unavailable(say("live.being_analysed"), retry_after_s=5)
            is_live = session_id in self._sessions
            if not is_live and await asyncio.to_thread(repository.reopen, self.engine, session_id):
                # Ends by itself, also where no gateway comes.
                self._housekeeping.abandoned(session_id)
        self._tell_stored(session_id)
        return await self.state(session_id)

    async def _finish(self, session_id: str, session: LiveSession | None) -> None:
        try:
            async with self._endings:
                if session is not None:
                    await session.finish()
                else:
                    await until_written(partial(repository.end_abandoned, self.engine, session_id))
                await until_written(partial(self._on_closed, session_id))
        except Exception as error:
            # Whatever it was, the session must not stay `closing` for ever: what is stored can be analysed.
            logger.exception("session %s could not be closed", session_id)
            reason = error.message if isinstance(error, TelemotionError) else _NOT_CLOSED
            await self._save_failed(session_id, reason)
        finally:
            self._sessions.pop(session_id, None)
            self._sent_away.pop(session_id, None)
            if session_id in self._holds:
                self._holds.pop(session_id).release()
            if session is not None:
                if session.lane is not None:
                    session.lane.leave()
                session.is_finished = True
            self._tell_stored(session_id)

    async def _save_failed(self, session_id: str, reason: str) -> None:
        try:
            await asyncio.to_thread(repository.save_not_closed, self.engine, session_id, reason)
        except Exception:
            # The row says `closing`: the next start of the service queues the analysis.
            logger.exception("the failure of session %s could not be stored", session_id)

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
        return stored_state(stored, self._sent_away.get(stored.id))

    async def _check_gateway(
        self, session: LiveSession, right: AuthorizationCheck, patience: GracePeriod
    ) -> None:
        """Raise when a gateway has lost its right; stop its source when nobody answers for it any more."""
        await patience.wait(self.check_right(right))
        if session.actuation is not None:
            await self.check_source(session.id)

    async def check_source(self, session_id: str) -> None:
        """Let the source of a session that is live here fire only while it is confirmed to be safe."""
        session = self._sessions.get(session_id)
        if session is not None and session.actuation is not None:
            refusal = await self.check(
                partial(repository.source_refusal, self.engine, session_id, self._confirmation_hours)
            )
            session.allow_source(refusal is None, refusal or "")

    def _close_soon(self, session_id: str, reason: str) -> None:
        if session_id not in self._closing:
            self._keep(asyncio.create_task(self.close(session_id, reason), name="close by itself"))

    def _keep(self, task: asyncio.Task[Any]) -> None:
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
