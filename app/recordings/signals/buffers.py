"""The buffers of one session that wait to be written, and how they become chunks."""

import logging
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field
from itertools import chain, groupby
from typing import Any, cast

from app.database.base import new_id, utc_now
from app.errors import TelemotionError
from app.network.packet_run import PacketRun
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.recordings.signals.checkpoints import Checkpoint
from app.recordings.signals.chunks import (
    MAX_CHUNK_TICKS,
    EncodedChunk,
    encode_frames,
    encode_packets,
    encode_runs,
    frames_stream,
)
from estimators.pipelines._contract import Frames

logger = logging.getLogger(__name__)

DurableCallback = Callable[[SequenceRanges], None]
FailureCallback = Callable[[TelemotionError], None]


@dataclass
class Batch:
    """What one commit takes from one session; held unchanged when the commit must be repeated."""

    packets: list[RawPacket | PacketRun]
    frame_parts: list[tuple[str, Frames]]
    events: list[dict[str, Any]]
    waiting: list[Future[SequenceRanges]]
    size: int
    raw: list[tuple[int, EncodedChunk]] = field(default_factory=list)
    frames: list[tuple[str, EncodedChunk]] = field(default_factory=list)
    checkpoint: Callable[[], Checkpoint] | None = None
    """Makes that of the session after all of this."""
    packed: Checkpoint | None = None
    is_encoded: bool = False
    strides: Mapping[str, int] = field(default_factory=dict)
    """By result, how many ticks lie from one stored frame to the next; of others every tick is stored."""

    @property
    def is_empty(self) -> bool:
        """Whether nothing would be written."""
        return not (self.packets or self.frame_parts or self.events)

    @property
    def ranges(self) -> Iterable[tuple[int, int]]:
        """Sequences of the packets in it, once it is encoded."""
        return chain.from_iterable(chunk.scale["ranges"] for _, chunk in self.raw)

    def encode(self, next_chunk: int) -> int:
        """Make the chunks, numbering those of the raw stream from `next_chunk`; return the next number.

        Done once: a repeated commit must carry the same keys and bytes, so that a commit whose answer was
        lost is recognised.
        """
        if self.is_encoded:
            return next_chunk
        for chunk in _encoded_packets(self.packets):
            self.raw.append((next_chunk, chunk))
            next_chunk += 1
        self.frames = [
            (frames_stream(result_id), encode_frames(*parts, stride=stride))
            for result_id, parts in _frame_groups(self.frame_parts)
            if _has_kept(parts, stride := self.strides.get(result_id, 1))
        ]
        if self.checkpoint is not None:
            try:
                self.packed = self.checkpoint()
            except Exception:
                # It saves time after a restart, no more: what was measured is stored without.
                logger.exception("a checkpoint cannot be packed")
        self.is_encoded = True
        return next_chunk


@dataclass
class OpenSession:
    """What the writer knows of one open session.

    Attributes
    ----------
    seen, durable : SequenceRanges
        Packets stored or waiting, and packets committed.
    oldest_s : float or None
        Monotonic time at which the first item that waits came.
    repeat : Batch or None
        A batch whose commit failed; it goes first, unchanged, not before `repeat_at_s`.
    head_start : float
        By this share the first chunk is shorter: sessions that begin together must not be due together.
    strides : dict
        See `Batch`.
    """

    session_id: str
    seen: SequenceRanges
    durable: SequenceRanges
    next_chunk: int
    on_durable: DurableCallback | None
    on_failure: FailureCallback | None
    packets: list[RawPacket | PacketRun] = field(default_factory=list)
    frame_parts: list[tuple[str, Frames]] = field(default_factory=list)
    events: list[dict[str, Any]] = field(default_factory=list)
    waiting: list[Future[SequenceRanges]] = field(default_factory=list)
    checkpoint: Callable[[], Checkpoint] | None = None
    size: int = 0
    oldest_s: float | None = None
    is_urgent: bool = False
    is_closing: bool = False
    failure: TelemotionError | None = None
    repeat: Batch | None = None
    repeat_at_s: float = 0.0
    attempts: int = 0
    head_start: float = 0.0
    strides: Mapping[str, int] = field(default_factory=dict)

    @property
    def is_empty(self) -> bool:
        """Whether nothing waits; a checkpoint alone waits for what comes next."""
        return not (self.packets or self.frame_parts or self.events or self.waiting or self.repeat)

    @property
    def waiting_bytes(self) -> int:
        """Bytes that wait, a batch to repeat included."""
        return self.size + (self.repeat.size if self.repeat else 0)

    def add_packet(self, packet: RawPacket, size: int) -> None:
        """Take a packet of `size` bytes."""
        self.seen.add(packet.sequence)
        self.packets.append(packet)
        self.size += size
        if self.oldest_s is None:
            self._begin(time.monotonic())

    def add_run(self, run: PacketRun, size: int, came_s: float) -> None:
        """Take a run of packets of `size` bytes, of which the first came at a monotonic time."""
        self.seen.add_range(run.first_sequence, run.stop_sequence)
        self.packets.append(run)
        self.size += size
        if self.oldest_s is None:
            self._begin(came_s)

    def add_frames(self, result_id: str, frames: Frames, size: int) -> None:
        """Take frames of `size` bytes."""
        self.frame_parts.append((result_id, frames))
        self.size += size
        if self.oldest_s is None:
            self._begin(time.monotonic())

    def _begin(self, came_s: float) -> None:
        # Arrivals that another machine noted may lie in the future: then nothing would be due.
        self.oldest_s = min(came_s, time.monotonic())

    def is_due(self, now_s: float, chunk_s: float, *, everything: bool) -> bool:
        """Whether the next commit should take from this session."""
        if self.failure is not None or self.is_empty:
            return False
        if self.repeat is not None:
            return everything or now_s >= self.repeat_at_s
        is_old = self.oldest_s is not None and now_s - self.oldest_s >= (1.0 - self.head_start) * chunk_s
        return everything or self.is_urgent or is_old or bool(self.waiting)

    def take(self) -> Batch:
        """Hand over the batch to repeat, else everything, and start empty."""
        if self.repeat is not None:
            batch, self.repeat = self.repeat, None
            return batch
        batch = Batch(self.packets, self.frame_parts, self.events, self.waiting, self.size)
        batch.strides = self.strides
        batch.checkpoint, self.checkpoint = self.checkpoint, None
        self.packets, self.frame_parts, self.events, self.waiting = [], [], [], []
        self.size, self.oldest_s, self.is_urgent, self.head_start = 0, None, False, 0.0
        return batch

    def drop(self, failure: TelemotionError) -> list[Future[SequenceRanges]]:
        """Take no more data; return who waits."""
        self.failure = failure
        waiting = self.waiting
        self.packets, self.frame_parts, self.events, self.waiting = [], [], [], []
        self.size, self.checkpoint = 0, None
        return waiting


def _encoded_packets(packets: list[RawPacket | PacketRun]) -> Iterable[EncodedChunk]:
    kinds = set(map(type, packets))
    if kinds == {PacketRun}:
        runs = cast(list[PacketRun], packets)
        if len({one.shape for one in runs}) == 1 and sum([one.tick_count for one in runs]) <= MAX_CHUNK_TICKS:
            # The common case; no packet is looked at by itself.
            yield encode_runs(runs)
            return
    if PacketRun in kinds:
        each = [one.packets() if isinstance(one, PacketRun) else [one] for one in packets]
        packets = list(chain.from_iterable(each))
    yield from map(encode_packets, _packet_groups(cast(list[RawPacket], packets)))


def _packet_groups(packets: list[RawPacket]) -> Iterable[list[RawPacket]]:
    """Split where the shape of the packets changes, and before a chunk grows too long."""
    shapes = {
        (one.sensor_count, one.channel_mask, one.encoding, len(one.payload) // one.tick_count)
        for one in packets
    }
    if len(shapes) == 1 and sum([one.tick_count for one in packets]) <= MAX_CHUNK_TICKS:
        # The common case; nothing is looked at twice.
        yield packets
        return
    for _, same_shape in groupby(packets, key=lambda packet: packet.shape_key):
        group: list[RawPacket] = []
        ticks = 0
        for packet in same_shape:
            if group and ticks + packet.tick_count > MAX_CHUNK_TICKS:
                yield group
                group, ticks = [], 0
            group.append(packet)
            ticks += packet.tick_count
        yield group


def _frame_groups(parts: list[tuple[str, Frames]]) -> Iterable[tuple[str, list[Frames]]]:
    """Gather consecutive frames of one result; start again after a gap, another layout or enough ticks."""
    group: list[Frames] = []
    group_result, start, following = "", 0, 0
    for result_id, frames in parts:
        first, ticks = frames.first_tick, frames.segment_flags.shape[0]
        if not ticks:
            continue
        if group and (
            result_id != group_result
            or first != following
            or (frames.layout is not group[-1].layout and frames.layout != group[-1].layout)
            or first + ticks - start > MAX_CHUNK_TICKS
        ):
            yield group_result, group
            group = []
        if not group:
            group_result, start = result_id, first
        group.append(frames)
        following = first + ticks
    if group:
        yield group_result, group


def _has_kept(parts: list[Frames], stride: int) -> bool:
    """Whether a tick of consecutive frames has a number that the stride divides."""
    first, last = parts[0].first_tick, parts[-1].first_tick + len(parts[-1].segment_flags) - 1
    return last // stride * stride >= first


def event_row(
    session_id: str,
    kind: str,
    time_s: float,
    duration_s: float,
    placement: str | None,
    text: str,
    details: dict[str, Any] | None,
) -> dict[str, Any]:
    """Return an event of a session's time line as a row."""
    return {
        "id": new_id(),
        "created_at": utc_now(),
        "session_id": session_id,
        "kind": kind,
        "time_s": time_s,
        "duration_s": duration_s,
        "placement": placement,
        "text": text,
        "details": details or {},
    }


def tell(callback: Callable[[Any], None], argument: Any) -> None:
    """Run a session's callback; its failure must not stop the writer of all sessions."""
    try:
        callback(argument)
    except Exception:
        logger.exception("a callback of the group commit failed")
