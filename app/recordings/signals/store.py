"""Reading the signal table: packets in the order of arrival, the ledger of sequences, frames by time.

The chunk's `scale` column carries what can be read without its data: the ranges of packet sequences in
it. `stored_ranges` adds them up, which is the whole ledger after a crash.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from operator import attrgetter
from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, Engine, Executable, func, select
from sqlalchemy.orm import Session

from app.errors import NotFound
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.recordings.models import Result, SignalChunk
from app.recordings.signals.chunks import (
    MAX_CHUNK_TICKS,
    RAW_STREAM,
    EncodedChunk,
    decode_frames,
    decode_packets,
    frames_stream,
    layout_from_dict,
    merge_frames,
    outermost_heads,
)
from app.recordings.signals.frame_codec import stride_of
from estimators.pipelines._contract import Frames
from estimators.sentences import say

Source = Engine | Connection | Session
_AT_ONCE: Final = 64
"""Chunks that are read and held together."""


def read_packets(source: Source, session_id: str) -> Iterator[RawPacket]:
    """Yield every stored packet of a session in the order of arrival, one chunk in memory at a time.

    With an engine each chunk is read in a transaction of its own, so that hours of reading hold nothing up.
    """
    for (number,) in _fetch(
        source,
        select(SignalChunk.sequence)
        .where(SignalChunk.session_id == session_id, SignalChunk.stream == RAW_STREAM)
        .order_by(SignalChunk.sequence),
    ):
        yield from _read_chunk(source, session_id, number)


def read_packets_in_order(source: Source, session_id: str, first: int = 0) -> Iterator[RawPacket]:
    """Yield every stored packet of a session from a sequence on, by rising sequence, whatever the order of arrival.

    Holds only the chunks that overlap in sequence: those of a late back-fill, not the whole session.
    """
    keys = _fetch(
        source,
        select(SignalChunk.sequence, SignalChunk.scale).where(
            SignalChunk.session_id == session_id, SignalChunk.stream == RAW_STREAM
        ),
    )
    chunks = sorted((_lowest(scale), number) for number, scale in keys if _stop(scale) > first)
    yield from _in_order(
        ((lowest, _read_chunk(source, session_id, number)) for lowest, number in chunks), first
    )


def read_before_ending(
    source: Source, session_id: str, ticks: int, channels: int
) -> tuple[int, list[RawPacket]]:
    """Return where the end of a session begins, and what of the packets before it counts for the times in it.

    Parameters
    ----------
    ticks : int
        So many at least are stored from there on.
    channels : int
        Mask; where some packets do not have all of these, the end begins with the first packet.

    Returns
    -------
    first : int
        Sequence.
    heads : list of RawPacket
        First and last packet of each chunk below it, by rising sequence, without payload.
    """
    stored = _fetch(
        source,
        select(SignalChunk.sequence, SignalChunk.scale, SignalChunk.ticks).where(
            SignalChunk.session_id == session_id, SignalChunk.stream == RAW_STREAM
        ),
    )
    chunks = sorted((_lowest(scale), number, scale, count) for number, scale, count in stored)
    if not all(scale["channel_mask"] & channels == channels for _, _, scale, _ in chunks):
        return 0, []
    first = 0
    for lowest, _, _, count in reversed(chunks):
        first, ticks = lowest, ticks - count
        if ticks <= 0:
            break
    before = [number for _, number, scale, _ in chunks if _stop(scale) <= first]
    heads: list[RawPacket] = []
    for start in range(0, len(before), _AT_ONCE):
        for one in _read_encoded(source, session_id, before[start : start + _AT_ONCE]):
            heads += outermost_heads(one)
    return first, sorted(heads, key=attrgetter("sequence"))


def packets_in_order(chunks: Iterable[EncodedChunk], first: int = 0) -> Iterator[RawPacket]:
    """Yield the packets of chunks that were read already, from a sequence on, as `read_packets_in_order`."""
    ordered = sorted(chunks, key=lambda one: _lowest(one.scale))
    yield from _in_order(((_lowest(one.scale), decode_packets(one)) for one in ordered), first)


def _lowest(scale: Mapping[str, Any]) -> int:
    return min(int(start) for start, _ in scale["ranges"])


def _stop(scale: Mapping[str, Any]) -> int:
    return max(int(stop) for _, stop in scale["ranges"])


def _in_order(chunks: Iterable[tuple[int, list[RawPacket]]], first: int) -> Iterator[RawPacket]:
    held: list[tuple[int, int, RawPacket]] = []
    for lowest, packets in chunks:
        while held and held[0][0] < lowest:
            yield heappop(held)[2]
        for place, packet in enumerate(packets):
            if packet.sequence >= first:
                heappush(held, (packet.sequence, place, packet))
    while held:
        yield heappop(held)[2]


def _read_chunk(source: Source, session_id: str, number: int) -> list[RawPacket]:
    (chunk,) = _read_encoded(source, session_id, [number])
    return decode_packets(chunk)


def _read_encoded(source: Source, session_id: str, numbers: Sequence[int]) -> list[EncodedChunk]:
    rows = _fetch(
        source,
        select(
            SignalChunk.start_ns,
            SignalChunk.ticks,
            SignalChunk.codec,
            SignalChunk.scale,
            SignalChunk.crc,
            SignalChunk.data,
        ).where(
            SignalChunk.session_id == session_id,
            SignalChunk.stream == RAW_STREAM,
            SignalChunk.sequence.in_(numbers),
        ),
    )
    return [EncodedChunk(*row) for row in rows]


def _fetch(source: Source, query: Executable) -> Sequence[Any]:
    if isinstance(source, Engine):
        with source.execution_options(read_only=True).connect() as connection:
            return connection.execute(query).all()
    return source.execute(query).all()


def stored_ranges(source: Source, session_id: str) -> SequenceRanges:
    """Return which packet sequences of a session are committed, from the chunks' metadata alone."""
    found = SequenceRanges()
    for (scale,) in _fetch(
        source,
        select(SignalChunk.scale)
        .where(SignalChunk.session_id == session_id, SignalChunk.stream == RAW_STREAM)
        .order_by(SignalChunk.sequence),
    ):
        found.update((start, stop) for start, stop in scale["ranges"])
    return found


def strides_of(source: Source, session_id: str) -> dict[str, int]:
    """Return the stride of each result of a session."""
    rows = _fetch(source, select(Result.id, Result.stride).where(Result.session_id == session_id))
    return {str(result_id): int(stride) for result_id, stride in rows}


@dataclass(frozen=True)
class Standing:
    """What is stored of a session's signals, as far as whoever goes on storing must know.

    Attributes
    ----------
    durable : SequenceRanges
        Packets that are committed.
    next_chunk : int
        Number of the next chunk of packets.
    strides : mapping of str to int
        Of each result.
    """

    durable: SequenceRanges
    next_chunk: int
    strides: Mapping[str, int]


def read_standing(source: Source, session_id: str) -> Standing:
    """Return what is stored of a session's signals."""
    query = select(func.max(SignalChunk.sequence)).where(
        SignalChunk.session_id == session_id, SignalChunk.stream == RAW_STREAM
    )
    ((last,),) = _fetch(source, query)
    next_chunk = 0 if last is None else last + 1
    return Standing(stored_ranges(source, session_id), next_chunk, strides_of(source, session_id))


def stored_step_s(result: Result) -> float:
    """Return the time from one stored frame of a result to the next."""
    return result.stride / float(result.setup["rate_hz"])


def iterate_frames(
    session: Session, result: Result, start_s: float | None = None, end_s: float | None = None
) -> Iterable[Frames]:
    """Yield a result's frames of the half-open session time `[start_s, end_s)`, chunk by chunk, in order.

    Their ticks are those of the grid that is stored: `stored_step_s` apart.
    """
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
    step_s, stride = stored_step_s(result), result.stride
    first = None if start_s is None else int(np.ceil(start_s / step_s - 1e-6))
    last = None if end_s is None else int(np.ceil(end_s / step_s - 1e-6))
    if first is not None:
        # The sequence is the first tick and a chunk never exceeds this many ticks.
        query = query.where(SignalChunk.sequence > first * stride - MAX_CHUNK_TICKS)
    if last is not None:
        query = query.where(SignalChunk.sequence < last * stride)
    for chunk in session.scalars(query):
        # A chunk may be finer than its result says, never coarser.
        frames = decode_frames(chunk, layout).every(stride // stride_of(chunk.scale))
        begin = 0 if first is None else first - frames.first_tick
        end = frames.tick_count if last is None else last - frames.first_tick
        part = frames.ticks(begin, end)
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
        raise NotFound(say("result.not_found"))
    layout = layout_from_dict(result.layout)
    parts = list(iterate_frames(session, result, start_s, end_s))
    return merge_frames(parts, layout, stored_step_s(result))
