"""Fencing: the database refuses what an earlier holder of a partition wants to write, in the same transaction.

The first statement of each writing transaction of a holder reads the partition's row with a share lock and compares its
number. Whoever takes the partition over raises the number, which waits for such transactions to end: afterwards none of
an earlier holder can commit, however long it was paused. A transaction that its holder left open, because it is paused
in the middle of one, is ended by the next holder.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, Engine, event, select, text
from sqlalchemy.dialects.postgresql import insert
from sqlalchemy.exc import OperationalError

from app.database.base import utc_now
from app.errors import Conflict
from app.scaled.models import PartitionHold
from estimators.sentences import say

logger = logging.getLogger(__name__)

PATIENCE_MS: Final = 400
"""So long the transactions of an earlier holder may still end by themselves."""
_OPTION: Final = "fence"
_TABLE: Final[Any] = PartitionHold.__table__
_HOLDERS: Final = select(_TABLE.c.partition, _TABLE.c.fencing)


class FencedError(Conflict):
    """Another process holds the partition: this one may not write for it any more."""


@dataclass(frozen=True)
class Fence:
    """The right to write for a partition.

    Parameters
    ----------
    refused : callable()
        Called, in the thread that wanted to write, when the database has refused it.
    """

    partition: int
    fencing: int
    refused: Callable[[], None]


def install(engine: Engine) -> None:
    """Let transactions of engines made by `fenced` begin with the comparison; once for an engine."""

    @event.listens_for(engine, "begin")
    def on_begin(connection: Connection) -> None:
        options = connection.get_execution_options()
        fence: Fence | None = options.get(_OPTION)
        if fence is None or options.get("read_only"):
            return
        row = connection.exec_driver_sql(
            "SELECT fencing FROM partition_hold WHERE partition = %s FOR SHARE", (fence.partition,)
        ).first()
        if row is None or row[0] != fence.fencing:
            fence.refused()
            raise FencedError(say("scaled.fenced"), partition=fence.partition)


def fenced(engine: Engine, fence: Fence) -> Engine:
    """Return the engine with which a holder reads and writes; it shares the connections of the other."""
    return engine.execution_options(**{_OPTION: fence})


def take_over(engine: Engine, partition: int, holder: str) -> tuple[int, int]:
    """Become the holder of a partition; return the fencing number and the position of what is stored.

    Parameters
    ----------
    engine : Engine
        Of PostgreSQL; not fenced.
    holder : str
        The name of this process's connections, by which the next holder ends them.
    """
    statement = (
        insert(_TABLE)
        .values(partition=partition, fencing=1, holder=holder, position=0, updated_at=utc_now())
        .on_conflict_do_update(
            index_elements=["partition"],
            set_={"fencing": _TABLE.c.fencing + 1, "holder": holder, "updated_at": utc_now()},
        )
        .returning(_TABLE.c.fencing, _TABLE.c.position)
    )
    while True:
        try:
            with engine.begin() as connection:
                connection.exec_driver_sql(f"SET LOCAL lock_timeout = {PATIENCE_MS}")
                fencing, position = connection.execute(statement).one()
            return int(fencing), int(position)
        except OperationalError:
            logger.warning("partition %d: an earlier holder left a transaction open; it is ended", partition)
            _end_transactions(engine, partition, holder)


def holders(engine: Engine) -> dict[int, int]:
    """Return the fencing number of every partition that was ever held."""
    with engine.connect() as connection:
        return {row.partition: row.fencing for row in connection.execute(_HOLDERS)}


def _end_transactions(engine: Engine, partition: int, holder: str) -> None:
    with engine.begin() as connection:
        before = connection.scalar(select(_TABLE.c.holder).where(_TABLE.c.partition == partition))
        if before is not None and before != holder:
            connection.execute(
                text(
                    "SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
                    " WHERE application_name = :name AND pid <> pg_backend_pid()"
                ),
                {"name": before},
            )
