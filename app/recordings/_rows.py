"""Writing rows of the signal tables so that a repeated write changes nothing."""

from typing import Any

from sqlalchemy import Connection, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from app.errors import Conflict
from app.recordings._buffers import Batch
from app.recordings.chunks import RAW_STREAM, EncodedChunk
from app.recordings.models import MotionSession, SessionEvent, SignalChunk


def insert_chunk(
    connection: Connection | Session, session_id: str, stream: str, sequence: int, chunk: EncodedChunk
) -> bool:
    """Insert a chunk; False when the very same one is there already.

    Raises
    ------
    Conflict
        Another content has this key: two writers serve one session.
    """
    values: dict[str, Any] = {
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
    if _insert_new(connection, SignalChunk, values):
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
            "another process stores this session too; a session belongs to one server at a time",
            stream=stream,
        )
    return False


def write_batch(connection: Connection, session_id: str, batch: Batch) -> int:
    """Write what one commit takes from one session; return how many packets were not there before."""
    stored = 0
    for sequence, chunk in batch.raw:
        if insert_chunk(connection, session_id, RAW_STREAM, sequence, chunk):
            stored += int(chunk.scale["packets"])
    for stream, chunk in batch.frames:
        values = {
            "session_id": session_id,
            "stream": stream,
            "sequence": chunk.scale["first_tick"],
            "start_ns": chunk.start_ns,
            "ticks": chunk.ticks,
            "codec": chunk.codec,
            "scale": chunk.scale,
            "crc": chunk.crc,
            "data": chunk.data,
        }
        # Frames that were shown stay; a runner that went back after a restart must not endanger the packets.
        _insert_new(connection, SignalChunk, values)
    for event in batch.events:
        _insert_new(connection, SessionEvent, event)
    if stored:
        connection.execute(
            update(MotionSession)
            .where(MotionSession.id == session_id)
            .values(packets_stored=MotionSession.packets_stored + stored)
        )
    return stored


def _insert_new(
    connection: Connection | Session, table: type[SignalChunk] | type[SessionEvent], values: dict[str, Any]
) -> bool:
    """Insert a row unless its key is taken; True when it was inserted."""
    name = connection.get_bind().dialect.name if isinstance(connection, Session) else connection.dialect.name
    dialect: Any = postgresql if name == "postgresql" else sqlite
    result: Any = connection.execute(dialect.insert(table).values(values).on_conflict_do_nothing())
    return bool(result.rowcount == 1)


__all__ = ["insert_chunk", "write_batch"]
