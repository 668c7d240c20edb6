"""Stored state of all sessions of a partition, read when it is taken: as many statements for ten as for one.

Their holder before can write nothing more by then (`app.scaled.fencing`), and nobody else writes what is read here.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any, Final

from sqlalchemy import Engine, func, literal, select, text
from sqlalchemy.orm import Session

from app.database.unit_of_work import read_only
from app.live.guidance.resume_state import stood
from app.live.repository import StoredSession
from app.live.session.checkpoint import LAYOUT
from app.live.session.streamed import Streamed
from app.network.ranges import SequenceRanges
from app.recordings.models import LiveCheckpoint, MotionSession, Result, SignalChunk
from app.recordings.signals.checkpoints import Checkpoint
from app.recordings.signals.chunks import RAW_STREAM, EncodedChunk, frames_stream
from app.recordings.signals.store import Standing

_LEDGERS: Final = text(
    """
    SELECT session_id, max(sequence), range_agg(int8range((one ->> 0)::bigint, (one ->> 1)::bigint))
    FROM signal_chunk CROSS JOIN LATERAL json_array_elements(scale -> 'ranges') AS one
    WHERE session_id = ANY(:ids) AND stream = :stream
    GROUP BY session_id
    """
)
"""Number of the last chunk of packets, and which packets are stored: the sum of all chunks, made by the database."""
_CHUNKS: Final = text(
    """
    SELECT chunk.session_id, start_ns, ticks, codec, scale, crc, chunk.data
    FROM signal_chunk AS chunk JOIN live_checkpoint AS stood ON stood.session_id = chunk.session_id
    WHERE chunk.session_id = ANY(:ids) AND stream = :stream AND stood.layout = :layout
        AND EXISTS (
            SELECT FROM json_array_elements(scale -> 'ranges') AS one WHERE (one ->> 1)::bigint > stood.sequence
        )
    """
)
"""Chunks with packets that the checkpoint of their session does not have."""


def read_streamed(engine: Engine, stored: Sequence[StoredSession]) -> dict[str, Streamed]:
    """Return what is to be known to take sessions up, by session; those that never streamed are not in it.

    Parameters
    ----------
    engine : Engine
        Of PostgreSQL.
    stored : sequence of StoredSession
        Open, in a partition that is held here.
    """
    if not stored:
        return {}
    ids = [one.id for one in stored]
    with read_only(engine) as session:
        results, prescribed = _results(session, ids)
        ledgers = {
            name: (last + 1, [(one.lower, one.upper) for one in ranges])
            for name, last, ranges in session.execute(_LEDGERS, {"ids": ids, "stream": RAW_STREAM})
        }
        checkpoints = {
            row.session_id: Checkpoint(row.layout, row.sequence, bytes(row.data))
            for row in session.scalars(select(LiveCheckpoint).where(LiveCheckpoint.session_id.in_(ids)))
        }
        chunks: defaultdict[str, list[EncodedChunk]] = defaultdict(list)
        for name, *row in session.execute(_CHUNKS, {"ids": ids, "stream": RAW_STREAM, "layout": LAYOUT}):
            chunks[name].append(EncodedChunk(*row))
        guided = stood(session, ids)
    found = {}
    for one in stored:
        live = next((row for row in results[one.id] if row.kind == "live"), None)
        if live is None or one.hello is None:
            continue
        next_chunk, ranges = ledgers.get(one.id, (0, []))
        strides = {row.id: row.stride for row in results[one.id]}
        found[one.id] = Streamed(
            stored=one,
            result_id=live.id,
            first_unstored_tick=live.first_unstored or 0,
            standing=Standing(SequenceRanges(ranges), next_chunk, strides),
            checkpoint=checkpoints.get(one.id),
            chunks=chunks[one.id],
            guided=guided[one.id],
            is_prescribed=one.id in prescribed,
        )
    return found


def _results(session: Session, ids: Sequence[str]) -> tuple[dict[str, list[Any]], set[str]]:
    """Return the results of each session, with the end of their frames, and which sessions have a prescription."""
    last = (
        select(SignalChunk.sequence + SignalChunk.ticks)
        .where(
            SignalChunk.session_id == Result.session_id,
            SignalChunk.stream == func.concat(literal(frames_stream("")), Result.id),
        )
        .order_by(SignalChunk.sequence.desc())
        .limit(1)
        .scalar_subquery()
    )
    results: dict[str, list[Any]] = {one: [] for one in ids}
    prescribed = set()
    for row in session.execute(
        select(
            Result.session_id,
            Result.id,
            Result.kind,
            Result.stride,
            last.label("first_unstored"),
            MotionSession.prescription_id,
        )
        .join(MotionSession, MotionSession.id == Result.session_id)
        .where(Result.session_id.in_(ids))
    ):
        results[row.session_id].append(row)
        if row.prescription_id is not None:
            prescribed.add(row.session_id)
    return results, prescribed
