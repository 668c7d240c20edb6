"""Writing rows of the signal tables so that a repeated write changes nothing.

A commit of any number of sessions executes one statement a table, each for all its rows at once.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Final

from sqlalchemy import Connection, Table, bindparam, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from app.errors import Conflict
from app.recordings.models import MotionSession, SessionEvent, SignalChunk
from app.recordings.signals.buffers import Batch
from app.recordings.signals.checkpoints import write_checkpoints
from app.recordings.signals.chunks import RAW_STREAM, EncodedChunk
from estimators.sentences import say

_CHUNKS: Final[Any] = SignalChunk.__table__
_EVENTS: Final[Any] = SessionEvent.__table__
_SESSIONS: Final[Any] = MotionSession.__table__
_COUNT_PACKETS: Final = (
    update(_SESSIONS)
    .where(_SESSIONS.c.id == bindparam("of_session"))
    .values(packets_stored=_SESSIONS.c.packets_stored + bindparam("added"))
)


class AlreadyStoredError(Conflict):
    """Some chunk of several sessions was there: each must be written, and looked at, alone."""


def insert_chunk(
    connection: Connection | Session, session_id: str, stream: str, sequence: int, chunk: EncodedChunk
) -> bool:
    """Insert a chunk; False when the very same one is there already.

    Raises
    ------
    Conflict
        Another content has this key: two writers serve one session.
    """
    if _insert_new(connection, _CHUNKS, [_row(session_id, stream, sequence, chunk)]):
        return True
    present = connection.execute(
        select(SignalChunk.crc, SignalChunk.ticks).where(
            SignalChunk.session_id == session_id,
            SignalChunk.stream == stream,
            SignalChunk.sequence == sequence,
        )
    ).one()
    if tuple(present) != (chunk.crc, chunk.ticks):
        raise Conflict(
            say("stored.other_process"),
            stream=stream,
        )
    return False


def write_batch(connection: Connection, session_id: str, batch: Batch) -> None:
    """Write what one commit takes from one session, whatever of it is there already.

    Raises
    ------
    Conflict
        See `insert_chunk`.
    """
    stored = 0
    for sequence, chunk in batch.raw:
        if insert_chunk(connection, session_id, RAW_STREAM, sequence, chunk):
            stored += int(chunk.scale["packets"])
    _write_rest(connection, [(session_id, batch)], {session_id: stored})


def write_batches(connection: Connection, batches: Sequence[tuple[str, Batch]]) -> None:
    """Write what one commit takes from many sessions, given by session.

    Raises
    ------
    AlreadyStoredError
        Not every packet is new: roll back, and write each session by `write_batch`.
    """
    rows = [
        _row(session_id, RAW_STREAM, sequence, chunk)
        for session_id, batch in batches
        for sequence, chunk in batch.raw
    ]
    if _insert_new(connection, _CHUNKS, rows) != len(rows):
        raise AlreadyStoredError(say("stored.already"))
    stored = {
        session_id: sum([int(chunk.scale["packets"]) for _, chunk in batch.raw])
        for session_id, batch in batches
    }
    _write_rest(connection, batches, stored)


def _write_rest(connection: Connection, batches: Sequence[tuple[str, Batch]], stored: dict[str, int]) -> None:
    # Frames that were shown stay; a runner that went back after a restart must not endanger the packets.
    frames = [
        _row(session_id, stream, chunk.scale["first_tick"], chunk)
        for session_id, batch in batches
        for stream, chunk in batch.frames
    ]
    _insert_new(connection, _CHUNKS, frames)
    _insert_new(connection, _EVENTS, [event for _, batch in batches for event in batch.events])
    added = [{"of_session": session_id, "added": count} for session_id, count in stored.items() if count]
    if added:
        connection.execute(_COUNT_PACKETS, added)
    write_checkpoints(connection, {name: batch.packed for name, batch in batches if batch.packed is not None})


def _row(session_id: str, stream: str, sequence: int, chunk: EncodedChunk) -> dict[str, Any]:
    return {
        "session_id": session_id,
        "stream": stream,
        "sequence": sequence,
        "start_ns": chunk.start_ns,
        "ticks": chunk.ticks,
        "codec": chunk.codec,
        "scale": chunk.scale,
        "crc": chunk.crc,
        "data": chunk.data,
    }


def _insert_new(connection: Connection | Session, table: Table, rows: list[dict[str, Any]]) -> int:
    """Insert the rows whose keys are free; return how many were."""
    if not rows:
        return 0
    name = connection.get_bind().dialect.name if isinstance(connection, Session) else connection.dialect.name
    result: Any = connection.execute(_insert(name, table), rows)
    return int(result.rowcount)


@lru_cache
def _insert(dialect_name: str, table: Table) -> Any:
    dialect: Any = postgresql if dialect_name == "postgresql" else sqlite
    # The count is read before the driver's cursor is closed.
    return dialect.insert(table).on_conflict_do_nothing().execution_options(preserve_rowcount=True)
