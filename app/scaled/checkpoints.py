"""Checkpoints of a partition's sessions: written with the position of their stream, in one transaction."""

from collections.abc import Mapping
from typing import Any, Final

from sqlalchemy import Engine, select, update

from app.database.base import utc_now
from app.live.session.states import OPEN
from app.recordings.models import MotionSession
from app.recordings.signals.checkpoints import Checkpoint, write_checkpoints
from app.scaled.models import PartitionHold

_HOLDS: Final[Any] = PartitionHold.__table__
_SESSIONS: Final[Any] = MotionSession.__table__


def save(engine: Engine, partition: int, position: int, checkpoints: Mapping[str, Checkpoint]) -> None:
    """Note that everything of a stream up to a position is stored, and where sessions stand.

    Parameters
    ----------
    engine : Engine
        Fenced.
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
        there = connection.scalars(
            # Not deleted before this ends; who writes its state waits for nothing. Its holder closes it in a
            # transaction of the same partition, which is over by now or comes after this one.
            select(_SESSIONS.c.id)
            .where(_SESSIONS.c.id.in_(checkpoints), _SESSIONS.c.state.in_(OPEN))
            .with_for_update(read=True, key_share=True)
        )
        write_checkpoints(connection, {name: checkpoints[name] for name in there})
