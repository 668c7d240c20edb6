"""Estimates sessions again whose checkpoints this version cannot read, while another worker still shows them.

Who takes such a session begins with its first packet, and until it is where the session stands nobody sees a frame:
after an upgrade that would be minutes for sessions of an hour. So a worker of the new version does it before it holds
them, from what is stored, and then again from where it stood, until little is left. What it finds waits in memory for
the moment at which the session comes; it writes nothing.
"""

import asyncio
import logging
import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from sqlalchemy import Engine

from app.live import repository
from app.live.bus import MemoryBus
from app.live.session.checkpoint import LAYOUT, capture, pack
from app.live.session.opening import setup_for
from app.live.session.rebuild import rebuild
from app.live.session.runner import LiveSession
from app.live.session.streamed import Streamed
from app.live.warmup import Readiness
from app.network.declaration import Declaration
from app.recordings.signals.checkpoints import Checkpoint
from app.recordings.signals.group_commit import GroupCommitWriter
from estimators import pipelines
from estimators.pipelines import SessionSetup

logger = logging.getLogger(__name__)

SHORT_S: Final = 1.0
"""A round that lasts no longer leaves no more to be estimated than a checkpoint does."""
PATIENCE_S: Final = 120.0
"""So long others carry what this worker will take: then it takes it, however much is left."""
MOST: Final = 100
"""Sessions that are estimated ahead: more do not fit into a processor beside those that are held."""
PAUSE_S: Final = 1.0
LOOK_S: Final = 5.0
"""How often a worker that has nothing to estimate ahead looks whether there is something by now."""


class Preparation:
    """Knows where sessions stand that others hold and whose checkpoints cannot be read here.

    Parameters
    ----------
    readiness : Readiness
        Of compiled code.
    is_held : callable(session_id)
        Whether this worker holds the session, or is about to.

    Attributes
    ----------
    comes_soon : callable(session_id)
        Whether this worker would get the session; those come first.
    is_waited_for : bool
        Whether this worker takes no sessions yet.
    """

    def __init__(self, engine: Engine, readiness: Readiness, is_held: Callable[[str], bool]) -> None:
        self._engine, self._readiness, self._is_held = engine, readiness, is_held
        self.comes_soon: Callable[[str], bool] = lambda _: True
        self.is_waited_for = False
        # What is estimated here is stored by whoever holds the session.
        self._writer, self._bus = GroupCommitWriter(engine), MemoryBus()
        self._found: dict[str, Checkpoint] = {}
        self._vain: dict[str, int] = {}
        """Where the checkpoint stood of a session that could not be estimated up to there."""

    async def run(self) -> None:
        """Go on until cancelled: another worker may stop at any moment."""
        while True:
            count = 0
            try:
                count = await self.once()
            except Exception:
                logger.exception("sessions could not be estimated ahead; it is tried again")
            await asyncio.sleep(PAUSE_S if count else LOOK_S)

    async def short(self) -> None:
        """Return when little is left to be estimated of any session, after `PATIENCE_S` at the latest."""
        try:
            async with asyncio.timeout(PATIENCE_S):
                lasted_s, count = math.inf, 1
                while count and lasted_s > SHORT_S:
                    began_s = time.monotonic()
                    count = await self.once()
                    lasted_s = time.monotonic() - began_s
                    logger.info("%d sessions were estimated ahead in %.1f s", count, lasted_s)
        except TimeoutError:
            logger.warning("more is left to be estimated than others carry for this long")

    def trouble(self) -> str | None:
        """Return in words why another worker should not be stopped yet; None where it may."""
        if self.is_waited_for:
            return "No session is taken yet: those of another version are estimated ahead, to come without a gap."
        return None

    async def once(self) -> int:
        """Bring every such session to where its checkpoint stands; returns how many there are."""
        there = await asyncio.to_thread(repository.of_other_layouts, self._engine, LAYOUT)
        wanted = sorted(
            (one for one in there if not self._is_held(one[0])), key=lambda one: not self.comes_soon(one[0])
        )[:MOST]
        names = {name for name, _ in wanted}
        self._found = {name: one for name, one in self._found.items() if name in names}
        self._vain = {name: stop for name, stop in self._vain.items() if name in names}
        for name, stop in wanted:
            if self._vain.get(name) == stop:
                continue
            try:
                if not await self._reaches(name, stop):
                    self._vain[name] = stop
            except Exception as error:
                # Whatever is wrong with it: others are behind it, and whoever takes it will say so.
                self._vain[name] = stop
                logger.warning("session %s is not estimated ahead: %s", name, type(error).__name__)
        return len(wanted)

    def put_into(self, streamed: Mapping[str, Streamed]) -> dict[str, Streamed]:
        """Return what is stored of sessions, with where they stand here in the place of what cannot be read."""
        return {
            name: replace(one, checkpoint=self._found[name], chunks=None)
            if name in self._found and one.checkpoint is not None and one.checkpoint.layout != LAYOUT
            else one
            for name, one in streamed.items()
        }

    async def _reaches(self, session_id: str, stop: int) -> bool:
        """Go on where a session's checkpoint stands: what came before that is stored, its frames too."""
        known = self._found.get(session_id)
        if known is not None and known.sequence >= stop:
            return True
        stored = await asyncio.to_thread(repository.load, self._engine, session_id)
        declaration = Declaration.from_dict(stored.hello or {})
        met = [one.first_sequence for one in declaration.clock_epochs]
        met += [one.first_sequence for one in declaration.found_clips]
        if any(one >= stop for one in met):
            # The next checkpoint has it.
            return False
        setup = setup_for(SessionSetup.from_dict(stored.setup), declaration)
        await self._readiness.require(setup)
        session = LiveSession(
            stored,
            declaration,
            pipelines.create(setup),
            engine=self._engine,
            writer=self._writer,
            bus=self._bus,
            result_id="",
        )
        is_over = threading.Event()
        try:
            return await asyncio.to_thread(self._go_on, session, known, stop, is_over)
        finally:
            # Where nobody waits any more the thread ends soon, and what it has done so far is not lost.
            is_over.set()

    def _go_on(
        self, session: LiveSession, known: Checkpoint | None, stop: int, is_over: threading.Event
    ) -> bool:
        trouble = rebuild(
            session,
            self._engine,
            known,
            is_exact=True,
            until=lambda sequence: sequence >= stop or is_over.is_set(),
        )
        state = capture(session) if trouble is None else None
        if state is None:
            return False
        self._found[session.id] = pack(state)
        return True
