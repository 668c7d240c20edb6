"""The look a few times a second at silent links, health, and sessions that are to be closed by themselves."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Sequence
from typing import Final

from app.live.session.runner import LiveSession
from app.live.session.states import OPEN, STREAMING
from estimators.sentences import say

logger = logging.getLogger(__name__)

PERIOD_S: Final = 0.25
THOROUGH_EVERY_TURNS: Final = 4
"""Turns after which a session is settled and its health is published; in the others it is only looked at."""
AT_ONCE_S: Final = 0.002
"""Sessions are settled one after the other for so long, then packets come first again."""
STOOD_STILL_S: Final = 0.5
"""Woken so much too late, the service itself stood still: what has arrived meanwhile is still to be read."""
LINK_LOST_AFTER_S: Final = 2.0
DEAD_LINK_AFTER_S: Final = 10.0
"""A link that is gone for so long is no hiccup of a network: somebody has to look at it, also when it comes back."""
REORDER_PATIENCE_S: Final = 0.3
IDLE_CLOSE_S: Final = 600.0
"""A session without packets for so long is closed and analysed."""
LONGEST_S: Final = 24 * 3600.0
GOODBYE_CLOSE_S: Final = 60.0
"""A gateway that has said goodbye and lost its link has so long to come back with what is still missing."""
_IDLE: Final = say("live.closed_idle")
_LONG: Final = say("live.closed_long")
_NOT_BROUGHT: Final = say("live.closed_incomplete")


async def _at_once() -> None:
    """Nobody works on packets."""


class Housekeeping:
    """Looks after all live sessions of this process.

    Parameters
    ----------
    sessions : callable()
        Returns every session that is live.
    is_connected : callable(session_id)
        Whether a gateway's connection is attached.
    close_soon : callable(session_id, reason)
        Closes a session unless it is being closed.
    idle_close_s, goodbye_close_s : float
        Silence after which a session is closed, in general and after a goodbye whose link broke.
    longest_s : float
        A session that lasts longer is closed.
    note : callable(session), optional
        Called about once a second with each session, settled.
    between_turns : callable(), optional
        Awaited before sessions are settled: returns when nothing works on their packets.
    """

    def __init__(
        self,
        sessions: Callable[[], Sequence[LiveSession]],
        is_connected: Callable[[str], bool],
        close_soon: Callable[[str, str], None],
        *,
        idle_close_s: float,
        goodbye_close_s: float,
        longest_s: float,
        note: Callable[[LiveSession], None] = lambda _: None,
        between_turns: Callable[[], Awaitable[None]] = _at_once,
    ) -> None:
        self._sessions = sessions
        self._note = note
        self._between_turns = between_turns
        self._is_connected = is_connected
        self._close_soon = close_soon
        self._idle_close_s = idle_close_s
        self._goodbye_close_s = goodbye_close_s
        self._longest_s = longest_s
        self._abandoned_s: dict[str, float] = {}
        self._has_stood_still = False
        self.is_behind: Callable[[], bool] = lambda: False
        """Whether packets that have arrived are still to be read: then nobody is silent."""

    def abandoned(self, session_id: str) -> None:
        """Note a session that was open when the service stopped; its gateway may come back."""
        self._abandoned_s[session_id] = time.monotonic()

    def taken_up(self, session_id: str) -> None:
        """Note that a session is live again, or closed."""
        self._abandoned_s.pop(session_id, None)

    async def run(self) -> None:
        """Look after the sessions until cancelled."""
        turn = 0
        while True:
            began_s = time.monotonic()
            await asyncio.sleep(PERIOD_S)
            self._has_stood_still = time.monotonic() - began_s > PERIOD_S + STOOD_STILL_S
            turn += 1
            until_s = 0.0
            for number, session in enumerate(self._sessions()):
                is_thorough = (turn + number) % THOROUGH_EVERY_TURNS == 0
                if is_thorough and time.monotonic() > until_s:
                    # Packets come first: all sessions together would hold them up for tens of milliseconds.
                    await asyncio.sleep(0)
                    await self._between_turns()
                    until_s = time.monotonic() + AT_ONCE_S
                try:
                    self._look_after(session, is_thorough)
                except Exception:
                    # Those behind it are settled and closed all the same.
                    logger.exception("looking after session %s failed", session.id)
            try:
                self._close_abandoned()
            except Exception:
                logger.exception("closing sessions whose gateways did not come back failed")

    def _look_after(self, session: LiveSession, is_thorough: bool) -> None:
        if is_thorough:
            # What follows sees the session as it was last settled: once a second is often enough.
            session.settle()
        is_unknown = self._has_stood_still or self.is_behind()
        silence_s = 0.0 if is_unknown else time.monotonic() - session.last_arrival_s
        ledger = session.now.ledger
        if silence_s > REORDER_PATIENCE_S:
            session.silent()
        said_goodbye = ledger.last_sequence is not None
        if silence_s > LINK_LOST_AFTER_S and session.state in STREAMING and not said_goodbye:
            session.link_lost(say("live.no_packet", silence_s=LINK_LOST_AFTER_S))
        if silence_s > DEAD_LINK_AFTER_S and session.state == "link_lost" and not said_goodbye:
            session.link_died(say("caseload.dead_link", silence_s=DEAD_LINK_AFTER_S))
        session.is_being_stored()
        if is_thorough:
            session.publish_health()
        if session.state not in OPEN:
            return
        if ledger.is_settled:
            self._close_soon(session.id, say("live.all_sent"))
        elif session.now.clock.session_time_us * 1e-6 > self._longest_s:
            self._close_soon(session.id, _LONG)
        elif silence_s > self._idle_close_s:
            self._close_soon(session.id, _IDLE)
        elif said_goodbye and silence_s > self._goodbye_close_s and not self._is_connected(session.id):
            self._close_soon(session.id, _NOT_BROUGHT)
        if is_thorough:
            self._note(session)

    def _close_abandoned(self) -> None:
        """Close sessions that were open when the service stopped and to which no gateway came back."""
        now = time.monotonic()
        for session_id, since in list(self._abandoned_s.items()):
            if now - since > self._idle_close_s:
                del self._abandoned_s[session_id]
                self._close_soon(session_id, _IDLE)
