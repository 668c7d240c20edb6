"""Reading the signal table: packets in the order of arrival, the ledger of sequences, frames by time.

The chunk's `scale` column carries what can be read without its data: the ranges of packet sequences in
it. `stored_ranges` adds them up, which is the whole ledger after a crash.
"""

from collections.abc import Iterable, Iterator

import numpy as np
from sqlalchemy import Connection, Engine, select
from sqlalchemy.orm import Session

from app.errors import NotFound
from app.recordings.chunks import (
    MAX_CHUNK_TICKS,
    RAW_STREAM,
    EncodedChunk,
    RawPacket,
    decode_frames,
    decode_packets,
    frames_stream,
    layout_from_dict,
    merge_frames,
    slice_frames,
)
from app.recordings.models import Result, SignalChunk
from app.recordings.ranges import SequenceRanges
from estimators.pipelines._contract import Frames


def read_packets(source: Engine | Connection | Session, session_id: str) -> Iterator[RawPacket]:
    """Yield every stored packet of a session in the order of arrival, one chunk in memory at a time."""
    if isinstance(source, Engine):
        with source.connect() as connection:
            yield from read_packets(connection, session_id)
        return
    after = -1
    while True:
        row = source.execute(
            select(
                SignalChunk.sequence,
                SignalChunk.start_ns,
                SignalChunk.ticks,
                SignalChunk.codec,
                SignalChunk.scale,
                SignalChunk.crc,
                SignalChunk.data,
            )
            .where(
                SignalChunk.session_id == session_id,
                SignalChunk.stream == RAW_STREAM,
                SignalChunk.sequence > after,
            )
            .order_by(SignalChunk.sequence)
            .limit(1)
        ).first()
        if row is None:
            return
        after = row.sequence
        yield from decode_packets(EncodedChunk(*row[1:]))


def stored_ranges(source: Engine | Connection | Session, session_id: str) -> SequenceRanges:
    """Return which packet sequences of a session are committed, from the chunks' metadata alone."""
    if isinstance(source, Engine):
        with source.connect() as connection:
            return stored_ranges(connection, session_id)
    rows = source.execute(
        select(SignalChunk.scale)
        .where(SignalChunk.session_id == session_id, SignalChunk.stream == RAW_STREAM)
        .order_by(SignalChunk.sequence)
    )
    found = SequenceRanges()
    for (scale,) in rows:
        found.update((start, stop) for start, stop in scale["ranges"])
    return found


def iterate_frames(
    session: Session, result: Result, start_s: float | None = None, end_s: float | None = None
) -> Iterable[Frames]:
    """Yield a result's frames of the half-open session time `[start_s, end_s)`, chunk by chunk, in order."""
    layout = layout_from_dict(result.layout)
    query = (
        select(SignalChunk)
        .where(
            SignalChunk.session_id == result.session_id,
            SignalChunk.stream == frames_stream(result.id),
        )
        .order_by(SignalChunk.sequence)
        .execution_options(yield_per=16)
    )
    step_s = 1.0 / float(result.setup["rate_hz"])
    first = None if start_s is None else int(np.ceil(start_s / step_s - 1e-6))
    last = None if end_s is None else int(np.ceil(end_s / step_s - 1e-6))
    if first is not None:
        # The sequence is the first tick and a chunk never exceeds this many ticks.
        query = query.where(SignalChunk.sequence > first - MAX_CHUNK_TICKS)
    if last is not None:
        query = query.where(SignalChunk.sequence < last)
    for chunk in session.scalars(query):
        frames = decode_frames(chunk, layout)
        begin = 0 if first is None else first - frames.first_tick
        end = frames.tick_count if last is None else last - frames.first_tick
        part = slice_frames(frames, begin, end)
        if part.tick_count > 0:
            yield part


def read_frames(
    session: Session, result_id: str, start_s: float | None = None, end_s: float | None = None
) -> Frames:
    """Return a result's frames of the half-open session time `[start_s, end_s)`.

    Ticks that were never stored, between stored ones, are NaN and flagged invalid. Access is decided by
    the caller (`app.recordings.repository`).
    """
    result = session.get(Result, result_id)
    if result is None:
        raise NotFound("there is no such result")
    layout = layout_from_dict(result.layout)
    parts = list(iterate_frames(session, result, start_s, end_s))
    return merge_frames(parts, layout, 1.0 / float(result.setup["rate_hz"]))


__all__ = ["iterate_frames", "read_frames", "read_packets", "stored_ranges"]
