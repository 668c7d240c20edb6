"""Checkpoints of live sessions in the database: written with the position of their stream, in one transaction."""

from collections.abc import Mapping
from typing import Any, Final

from sqlalchemy import Engine, delete, select, update
from sqlalchemy.dialects.postgresql import insert
from sqlalchemy.orm import Session

from app.database.base import utc_now
from app.database.unit_of_work import read_only
from app.live.session.checkpoint import Checkpoint
from app.live.session.states import OPEN
from app.recordings.models import MotionSession
from app.scaled.models import LiveCheckpoint, PartitionHold

_HOLDS: Final[Any] = PartitionHold.__table__
_CHECKPOINTS: Final[Any] = LiveCheckpoint.__table__
_SESSIONS: Final[Any] = MotionSession.__table__


def save(engine: Engine, partition: int, position: int, checkpoints: Mapping[str, Checkpoint]) -> None:
    """Note that everything of a stream up to a position is stored, and where sessions stand.

    Parameters
    ----------
    engine : Engine
        Fenced.
    partition, position : int
    checkpoints : mapping of str to Checkpoint
        By session; the packets before each are stored. Those of sessions that are gone or closed are left out.
    """
    with engine.begin() as connection:
        connection.execute(
            update(_HOLDS)
            .where(_HOLDS.c.partition == partition)
            .values(position=position, updated_at=utc_now())
        )
        if not checkpoints:
            return
        there = set(
            connection.scalars(
                # Not deleted before this ends; who writes its state waits for nothing. Its holder closes it in a
                # transaction of the same partition, which is over by now or comes after this one.
                select(_SESSIONS.c.id)
                .where(_SESSIONS.c.id.in_(checkpoints), _SESSIONS.c.state.in_(OPEN))
                .with_for_update(read=True, key_share=True)
            )
        )
        rows = [
            {
                "session_id": session_id,
                "layout": one.layout,
                "sequence": one.sequence,
                "data": one.data,
                "updated_at": utc_now(),
            }
            for session_id, one in checkpoints.items()
            if session_id in there
        ]
        if rows:
            statement = insert(_CHECKPOINTS)
            taken = {name: statement.excluded[name] for name in ("layout", "sequence", "data", "updated_at")}
            connection.execute(
                statement.on_conflict_do_update(index_elements=["session_id"], set_=taken), rows
            )


def load(engine: Engine, session_id: str) -> Checkpoint | None:
    """Return where a session stood; None where nothing is known."""
    with read_only(engine) as session:
        found = session.get(LiveCheckpoint, session_id)
        return None if found is None else Checkpoint(found.layout, found.sequence, bytes(found.data))


def forget(session: Session, session_id: str) -> None:
    """Delete the checkpoint of a session that is closed."""
    session.execute(delete(LiveCheckpoint).where(LiveCheckpoint.session_id == session_id))


__all__ = ["forget", "load", "save"]
