"""Signal chunks: packets and frames to the columns of a row and back, without the database.

Stream `raw` holds every packet once, in the order of arrival, about one second a chunk, with the exact
bytes of its payload and every field of its header, so each packet can be made again as it came. Stream
`frames/<result id>` holds what a pipeline found, rounded as `signals.frame_codec` says.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import attrgetter
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import InvalidInput
from app.network.packet import HEADER_BYTES
from app.network.packet_run import (
    H_ARRIVAL,
    H_SEQUENCE,
    H_TICKS,
    HEAD_COLUMNS,
    PacketRun,
    heads_of,
    joined_ranges,
)
from app.network.ranges import SequenceRanges, ranges_of
from app.network.raw_packet import COUNTS, WIDTH, RawPacket
from app.recordings.models import SignalChunk
from app.recordings.signals import codecs, frame_codec
from app.recordings.signals.bit_columns import room_words
from app.recordings.signals.packet_kernel import pack_packets, unpack_packets
from estimators.pipelines._contract import FrameLayout, Frames
from estimators.sentences import say

RAW_STREAM: Final = "raw"
COUNTS_CODEC: Final = "int16-rice/1"
_HEAD: Final = attrgetter(
    "sequence", "device_time_us", "tick_interval_us", "tick_count", "flags", "arrival_ns"
)
MAX_CHUNK_TICKS: Final = 4096


@dataclass(frozen=True, slots=True)
class EncodedChunk:
    """A row of `signal_chunk` without its key."""

    start_ns: int
    ticks: int
    codec: str
    scale: dict[str, Any]
    crc: int
    data: bytes


def check_packet(packet: RawPacket) -> None:
    """Refuse a packet whose counts do not fit its payload.

    Raises
    ------
    InvalidInput
        With the field that is wrong; the decoder of the wire format catches these first.
    """
    if packet.encoding not in WIDTH:
        raise InvalidInput(say("stored.packet_encoding", encoding=packet.encoding))
    if not 1 <= packet.tick_count <= MAX_CHUNK_TICKS or packet.sensor_count < 1:
        raise InvalidInput(say("stored.packet_empty"), field="tick_count")
    unit = packet.tick_count * WIDTH[packet.encoding]
    if not packet.payload or len(packet.payload) % unit:
        raise InvalidInput(
            say("stored.packet_payload", size=len(packet.payload), ticks=packet.tick_count),
            field="payload",
        )
    if not 0 <= packet.sequence < 2**63 or not 0 <= packet.device_time_us < 2**64:
        raise InvalidInput(say("stored.packet_range"), field="sequence")


def encode_packets(packets: Sequence[RawPacket]) -> EncodedChunk:
    """Encode packets of one `shape_key`, in the given order, as one chunk."""
    first = packets[0]
    # Read without a sign: a device's clock may use all 64 bits.
    fields = np.fromiter(chain.from_iterable(map(_HEAD, packets)), np.uint64, len(packets) * HEAD_COLUMNS)
    shape = {
        "sensor_count": first.sensor_count,
        "channel_mask": first.channel_mask,
        "encoding": first.encoding,
        "values_per_tick": first.values_per_tick,
    }
    ranges = ranges_of([packet.sequence for packet in packets])
    heads = fields.view(np.int64).reshape(-1, HEAD_COLUMNS)
    return _encoded(heads, [packet.payload for packet in packets], ranges, shape)


def encode_runs(runs: Sequence[PacketRun]) -> EncodedChunk:
    """Encode runs of one shape, in the given order, as one chunk: the same as of their packets."""
    ranges = SequenceRanges(joined_ranges(runs))
    payload = [message[HEADER_BYTES:] for one in runs for message in one.messages]
    return _encoded(heads_of(runs), payload, list(ranges), runs[0].described())


def _encoded(
    heads: NDArray[np.int64], payloads: list[bytes], ranges: list[tuple[int, int]], shape: dict[str, int]
) -> EncodedChunk:
    payload = bytearray().join(payloads)
    ticks, encoding, values_per_tick = (
        int(heads[:, H_TICKS].sum()),
        shape["encoding"],
        shape["values_per_tick"],
    )
    scale: dict[str, Any] = {"packets": len(heads), "ranges": ranges, **shape}
    if encoding == COUNTS:
        codec = COUNTS_CODEC
        counts = np.frombuffer(payload, "<i2").reshape(ticks, values_per_tick)
        words = np.empty(room_words(len(heads), HEAD_COLUMNS) + room_words(*counts.shape), np.uint32)
        data = words[: pack_packets(words, heads, counts)].tobytes()
    else:
        codec = codecs.FLOATS_CODEC
        head = codecs.encode_integers(heads)
        data = head + codecs.encode_floats(np.frombuffer(payload, "<f4").reshape(ticks, values_per_tick))
        scale["head_bytes"] = len(head)
    return EncodedChunk(int(heads[0, H_ARRIVAL]), ticks, codec, scale, codecs.checksum(data), data)


def decode_packets(chunk: EncodedChunk | SignalChunk) -> list[RawPacket]:
    """Restore the packets of a chunk, in the order of arrival.

    Raises
    ------
    DamagedChunkError
        If the checksum does not match.
    """
    _check(chunk)
    scale = chunk.scale
    heads, table = _heads_and_table(chunk)
    packets: list[RawPacket] = []
    row = 0
    for head in heads.tolist():
        ticks = head[H_TICKS]
        packets.append(_packet(scale, head, table[row : row + ticks].tobytes()))
        row += ticks
    return packets


def outermost_heads(chunk: EncodedChunk) -> list[RawPacket]:
    """Restore the packets of lowest and highest sequence of a chunk without their payload, which stays compressed.

    Raises
    ------
    DamagedChunkError
        If the checksum does not match.
    """
    _check(chunk)
    heads = _heads(chunk)
    outermost = {int(np.argmin(heads[:, H_SEQUENCE])), int(np.argmax(heads[:, H_SEQUENCE]))}
    found = [_packet(chunk.scale, heads[at].tolist(), b"") for at in outermost]
    return sorted(found, key=attrgetter("sequence"))


def _packet(scale: Mapping[str, Any], head: Sequence[int], payload: bytes) -> RawPacket:
    sequence, device_time, interval, ticks, flags, arrival = head
    return RawPacket(
        sequence=sequence,
        device_time_us=device_time % 2**64,
        tick_interval_us=interval,
        sensor_count=scale["sensor_count"],
        tick_count=ticks,
        channel_mask=scale["channel_mask"],
        encoding=scale["encoding"],
        flags=flags,
        payload=payload,
        arrival_ns=arrival,
    )


def _heads_and_table(chunk: EncodedChunk | SignalChunk) -> tuple[NDArray[np.int64], NDArray[Any]]:
    scale, data = chunk.scale, chunk.data
    shape = chunk.ticks, scale["values_per_tick"]
    if chunk.codec == COUNTS_CODEC:
        counts = np.empty(shape, np.int16)
        heads, is_whole = _unpacked(chunk, counts)
        if len(data) % 4 or not is_whole:
            raise codecs.DamagedChunkError(say("stored.cut_off"))
        return heads, counts
    split = scale.get("head_bytes", 0)
    if chunk.codec == codecs.SHUFFLED_COUNTS_CODEC:
        table: NDArray[Any] = codecs.decode_counts(data[split:], *shape)
    elif chunk.codec == codecs.FLOATS_CODEC:
        table = codecs.decode_floats(data[split:], *shape)
    else:
        raise codecs.DamagedChunkError(say("stored.codec", codec=chunk.codec))
    return codecs.decode_integers(data[:split], scale["packets"], HEAD_COLUMNS), table


def _heads(chunk: EncodedChunk) -> NDArray[np.int64]:
    """Return the heads of a sound chunk; they stand before the counts, which are not looked at."""
    if chunk.codec != COUNTS_CODEC:
        return _heads_and_table(chunk)[0]
    return _unpacked(chunk, np.empty((0, 0), np.int16))[0]


def _unpacked(chunk: EncodedChunk | SignalChunk, counts: NDArray[np.int16]) -> tuple[NDArray[np.int64], bool]:
    """Read heads and so many counts as fit; also returns whether nothing is left."""
    heads = np.empty((chunk.scale["packets"], HEAD_COLUMNS), np.int64)
    words = np.frombuffer(chunk.data, np.uint32, len(chunk.data) // 4).copy()
    return heads, bool(unpack_packets(words, heads, counts))


def _check(chunk: EncodedChunk | SignalChunk) -> None:
    if codecs.checksum(chunk.data) != chunk.crc:
        raise codecs.DamagedChunkError(say("stored.checksum"))


def frames_stream(result_id: str) -> str:
    """Return the name of the stream that holds a result's frames."""
    return f"frames/{result_id}"


def encode_frames(*parts: Frames, stride: int = 1) -> EncodedChunk:
    """Encode frames of consecutive ticks as one chunk; its sequence is the first tick that is stored.

    Sequence and `ticks` count ticks of the session whatever the stride: their sum is where the next chunk may begin.

    Parameters
    ----------
    parts : Frames
        At least one; several are of one layout, each beginning where the one before ends.
    stride : int
        See `frame_codec.pack`.
    """
    data, count, scale = frame_codec.pack(parts, stride)
    return EncodedChunk(
        start_ns=round(scale["first_tick"] * scale["time_step_s"] * 1e9),
        ticks=count * stride,
        codec=frame_codec.FRAMES_CODEC,
        scale=scale,
        crc=codecs.checksum(data),
        data=data,
    )


def decode_frames(chunk: EncodedChunk | SignalChunk, layout: FrameLayout) -> Frames:
    """Restore the frames of a chunk; see `signals.frame_codec` for how far they may differ from what was written."""
    _check(chunk)
    return frame_codec.unpack(chunk.codec, chunk.data, chunk.scale, chunk.ticks, layout)


def layout_from_dict(stored: dict[str, Any]) -> FrameLayout:
    """Rebuild a `FrameLayout` from `Result.layout`."""
    return FrameLayout(
        tuple(stored["segments"]), tuple(stored["points"]), tuple(stored["angles"]), tuple(stored["scalars"])
    )


def merge_frames(parts: Sequence[Frames], layout: FrameLayout, time_step_s: float) -> Frames:
    """Join frames in time; ticks that no part covers are NaN, flagged 1 (invalid)."""
    parts = [part for part in parts if part.tick_count]
    return Frames.merge(parts) if parts else _no_frames(layout, time_step_s)


def _no_frames(layout: FrameLayout, time_step_s: float) -> Frames:
    segments, points, angles = len(layout.segments), len(layout.points), len(layout.angles)
    return Frames(
        layout=layout,
        first_tick=0,
        time_step_s=time_step_s,
        q_room_segment=np.empty((0, segments, 4)),
        point_room_m=np.empty((0, points, 3)),
        angle_rad=np.empty((0, angles)),
        angle_sigma_rad=np.empty((0, angles)),
        scalar=np.empty((0, len(layout.scalars))),
        segment_flags=np.empty((0, segments), np.uint8),
        angle_flags=np.empty((0, angles), np.uint8),
    )
