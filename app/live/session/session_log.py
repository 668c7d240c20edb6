"""The stored and reported side of a live session: its state, its time line, its recording interval."""

import contextlib
import logging
from abc import ABC, abstractmethod
from functools import partial
from typing import Any

from sqlalchemy import Engine

from app.errors import Conflict, Unavailable
from app.live import repository
from app.live.bus import Bus, topic
from app.live.messages import EventMessage, HealthMessage, StateMessage
from app.live.session.saver import Saver
from app.live.session.states import StateMachine
from app.recordings.schemas import SessionEventOut
from app.recordings.signals.group_commit import GroupCommitWriter
from app.schemas import SessionState

logger = logging.getLogger(__name__)

TOPICS = ("frames", "blocks", "state", "health", "event", "layout", "calibration", "guidance")


class SessionLog(ABC):
    """The part of a live session that others read: in the database, on the time line, on the bus.

    Parameters
    ----------
    engine, writer, bus
        Resources of the service.
    """

    def __init__(
        self, stored: repository.StoredSession, engine: Engine, writer: GroupCommitWriter, bus: Bus
    ) -> None:
        self.id = stored.id
        self.machine = StateMachine(stored.state, stored.state_reason)
        self.recording_start_s = stored.recording_start_s
        self.recording_end_s = stored.recording_end_s
        self._engine, self._writer = engine, writer
        self.channels = {name: bus.channel(topic(self.id, name)) for name in TOPICS}
        """Where its messages go, by their names in `TOPICS`."""
        self._saver = Saver(self.id)

    @property
    def state(self) -> SessionState:
        """The present state."""
        return self.machine.state

    @property
    @abstractmethod
    def session_time_s(self) -> float:
        """End of the newest packet."""

    @abstractmethod
    def state_message(self) -> StateMessage:
        """Return the state for people."""

    @abstractmethod
    def health_message(self) -> HealthMessage:
        """Return link health."""

    @property
    def _is_recording(self) -> bool:
        return self.recording_start_s is not None and self.recording_end_s is None

    @property
    def _is_counting(self) -> bool:
        """Whether frames that come out now belong to what is recorded: a link may be lost while they are estimated."""
        return self._is_recording and self.machine.state in {"recording", "link_lost"}

    def _change(self, state: SessionState, reason: str) -> None:
        changed = self.machine.to(state, reason)
        self._saver.save(partial(repository.save_state, self._engine, self.id, state, reason))
        if changed:
            logger.info("session %s is %s", self.id, state)
            self.add_event("state", self.session_time_s, text=state)
        self._publish_state()

    def _publish_state(self) -> None:
        self.channels["state"].publish(self.state_message())

    def publish_health(self) -> None:
        """Publish link health when somebody listens."""
        if self.channels["health"].listeners:
            self.channels["health"].publish(self.health_message())

    def add_event(
        self,
        kind: str,
        time_s: float,
        duration_s: float = 0.0,
        *,
        placement: str | None = None,
        text: str = "",
        details: dict[str, Any] | None = None,
    ) -> None:
        """Store and publish something on the time line."""
        with contextlib.suppress(Conflict, Unavailable):
            # A session that cannot be stored hears of it once, from the writer.
            self._writer.add_event(
                self.id,
                kind,
                time_s,
                duration_s=duration_s,
                placement=placement,
                text=text,
                details=details,
            )
        event = SessionEventOut(
            kind=kind,
            time_s=time_s,
            duration_s=duration_s,
            placement=placement,
            text=text,
            label=(details or {}).get("label"),
        )
        self.channels["event"].publish(EventMessage(event=event))

    def _save_recording(self) -> None:
        self._saver.save(
            partial(
                repository.save_recording, self._engine, self.id, self.recording_start_s, self.recording_end_s
            )
        )

    async def saved(self) -> None:
        """Wait until every change so far is in the database."""
        await self._saver.saved()
