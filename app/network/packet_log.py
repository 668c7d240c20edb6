"""The packet log: a whole session as one file, exactly as it came over the wire.

::

    4 bytes   magic `TML1`
    u32       length of the hello, then the hello as JSON (the gateway's declaration)
    repeated: u64 arrival time (ns since the epoch, 0 when unknown), u32 length, the packet

Little endian. The packets are binary body-network packets, version 1, in the order of arrival.
"""

import json
import struct
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, BinaryIO, Final

from app.errors import RecordingFormatError
from app.network.packet import MAX_PACKET_BYTES, encode_packet
from app.network.raw_packet import RawPacket
from estimators.sentences import say

MAGIC: Final = b"TML1"
MAX_HELLO_BYTES: Final = 64 * 1024
_LENGTH: Final = struct.Struct("<I")
_PACKET_HEAD: Final = struct.Struct("<QI")


def packet_message(packet: RawPacket) -> bytes:
    """Return a stored packet as it came over the wire, header and checksum included."""
    return encode_packet(
        packet.table().reshape(packet.tick_count, packet.sensor_count, -1),
        sequence=packet.sequence,
        device_time_us=packet.device_time_us,
        tick_interval_us=packet.tick_interval_us,
        channels=packet.channel_mask,
        flags=packet.flags,
    )


def log_head(hello: Mapping[str, Any]) -> bytes:
    """Return the beginning of a log."""
    text = json.dumps(dict(hello), sort_keys=True).encode()
    return MAGIC + _LENGTH.pack(len(text)) + text


def log_entry(message: bytes, arrival_ns: int = 0) -> bytes:
    """Return one packet as it stands in a log."""
    return _PACKET_HEAD.pack(arrival_ns, len(message)) + message


def write_log(hello: Mapping[str, Any], packets: Iterable[RawPacket]) -> Iterator[bytes]:
    """Yield the bytes of a log, piece by piece."""
    yield log_head(hello)
    for packet in packets:
        yield log_entry(packet_message(packet), packet.arrival_ns)


def read_head(source: BinaryIO) -> dict[str, Any]:
    """Read the hello of a log; the source then stands at the first packet.

    Raises
    ------
    RecordingFormatError
        When this is no packet log.
    """
    if source.read(4) != MAGIC:
        raise RecordingFormatError(say("log.not_a_log"))
    (length,) = _LENGTH.unpack(_exactly(source, 4))
    if length > MAX_HELLO_BYTES:
        raise RecordingFormatError(say("log.hello_too_long", length=length, most=MAX_HELLO_BYTES))
    try:
        hello = json.loads(_exactly(source, length))
    except ValueError as error:
        raise RecordingFormatError(say("log.hello_not_json")) from error
    if not isinstance(hello, dict):
        raise RecordingFormatError(say("log.hello_not_json"))
    return hello


def read_entries(source: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield (arrival time in ns, packet) until the end of the log.

    Raises
    ------
    RecordingFormatError
        When a length cannot be or the file ends within a packet.
    """
    number = 0
    while head := source.read(_PACKET_HEAD.size):
        if len(head) < _PACKET_HEAD.size:
            raise RecordingFormatError(say("log.cut_off", number=number))
        arrival_ns, length = _PACKET_HEAD.unpack(head)
        if not 0 < length <= MAX_PACKET_BYTES:
            raise RecordingFormatError(say("log.packet_length", number=number, length=length))
        yield arrival_ns, _exactly(source, length, number)
        number += 1


def _exactly(source: BinaryIO, length: int, number: int | None = None) -> bytes:
    data = source.read(length)
    if len(data) < length:
        raise RecordingFormatError(
            say("log.cut_off_in_hello") if number is None else say("log.cut_off", number=number)
        )
    return data
