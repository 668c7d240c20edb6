"""Body-network packet, wire format version 1: bytes to values and back.

Little endian, a 32-byte header, then the payload. For each tick, for each sensor, for each set bit of the
channel mask in order: its values. `docs/packet.md` has the table of fields and test vectors.
"""

import struct
import zlib
from dataclasses import dataclass
from enum import IntFlag
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.errors import PacketError
from app.network.declaration import Declaration
from app.network.messages import JsonPacket, JsonSensor
from estimators.channels import CHANNELS, Channel, ChannelSpec
from estimators.sentences import say

MAGIC: Final = b"BNP1"
HEADER_BYTES: Final = 32
MAX_SENSORS: Final = 32
MAX_TICKS: Final = 64
MAX_PACKET_BYTES: Final = HEADER_BYTES + MAX_SENSORS * MAX_TICKS * 21 * 4
MIN_TICK_INTERVAL_US: Final = 500
MAX_TICK_INTERVAL_US: Final = 1_000_000
VALUE_LIMIT: Final = 1e6
"""No channel of a person reaches this in SI units; beyond it the sender's units or memory are wrong."""

FLOAT32: Final = 0
INT16: Final = 1

HEADER: Final = np.dtype(
    [
        ("magic", "S4"),
        ("sensor_count", "u1"),
        ("tick_count", "u1"),
        ("channels", "<u2"),
        ("encoding", "u1"),
        ("flags", "u1"),
        ("reserved", "<u2"),
        ("sequence", "<u4"),
        ("device_time_us", "<u8"),
        ("tick_interval_us", "<u4"),
        ("crc", "<u4"),
    ]
)
"""The header by name, for many packets at once."""
OFFSETS: Final = {name: int(place[1]) for name, place in (HEADER.fields or {}).items()}
"""Where in a packet each field of the header begins."""
_BEFORE_CRC: Final = "<4sBBHBBHIQI"
_HEADER, _HEADER_WITHOUT_CRC = struct.Struct(_BEFORE_CRC + "I"), struct.Struct(_BEFORE_CRC)
_FLAGS, _CRC = OFFSETS["flags"], OFFSETS["crc"]
_KNOWN_FLAGS: Final = 0b11


class PacketFlag(IntFlag):
    """Bits of the flags byte."""

    SATURATED = 1
    BACKFILLED = 2


_WIDTHS: Final = {spec.bit: spec.width for spec in CHANNELS}
_KNOWN_MASK: Final = sum(_WIDTHS)
_VALUES_PER_SENSOR: Final = tuple(
    sum(width for bit, width in _WIDTHS.items() if mask & bit) for mask in range(_KNOWN_MASK + 1)
)
_FLOAT32_ONLY: Final = sum(int(spec.bit) for spec in CHANNELS if spec.scale_limit is None)
_IN_JSON: Final = tuple(spec for spec in CHANNELS if spec.field)


@dataclass(slots=True)
class Packet:
    """One decoded packet. Treat as immutable; `values` is a read-only view of `data`.

    Attributes
    ----------
    data : bytes
        The message as it came, header included: what the store keeps.
    sequence : int
        As sent, modulo 2^32.
    device_time_us : int
        Device clock at the first tick.
    sensor_count, tick_count : int
        S and K.
    channels : int
        `Channel` bits.
    encoding : int
        `FLOAT32` or `INT16`.
    flags : int
        `PacketFlag` bits.
    values : ndarray of float32 or int16, shape (K, S, W)
        W values per sensor, the channels side by side in mask order; SI or counts.
    """

    data: bytes
    sequence: int
    device_time_us: int
    tick_interval_us: int
    sensor_count: int
    tick_count: int
    channels: int
    encoding: int
    flags: int
    values: NDArray[np.float32] | NDArray[np.int16]

    def channel(self, channel: Channel) -> NDArray[np.float32] | NDArray[np.int16] | None:
        """Return one channel's values as sent, shape (K, S, width), or None when the mask lacks it."""
        bit = int(channel)
        if not self.channels & bit:
            return None
        start = _VALUES_PER_SENSOR[self.channels & (bit - 1)]
        return self.values[:, :, start : start + _WIDTHS[channel]]


def decode_packet(data: bytes, declaration: Declaration | None = None) -> Packet:
    """Decode and check one binary packet.

    Parameters
    ----------
    data : bytes
        One whole message.
    declaration : Declaration, optional
        What the gateway said in its hello; the packet must fit it.

    Raises
    ------
    PacketError
        `details["reason"]` is one of `truncated`, `magic`, `reserved`, `flags`, `encoding`, `channel_mask`,
        `sensor_count`, `tick_count`, `tick_interval`, `length`, `crc`, `not_finite`, `absurd_value`,
        `undeclared_scale`.
    """
    size = len(data)
    if size < HEADER_BYTES:
        raise PacketError(
            say("packet.truncated", size=size, header=HEADER_BYTES),
            reason="truncated",
        )
    magic, sensors, ticks, mask, encoding, flags, reserved, sequence, time_us, interval_us, crc = (
        _HEADER.unpack_from(data)
    )
    if (
        magic != MAGIC
        or reserved
        or flags > _KNOWN_FLAGS
        or encoding > INT16
        or not 0 < mask <= _KNOWN_MASK
        or not 0 < sensors <= MAX_SENSORS
        or not 0 < ticks <= MAX_TICKS
        or not MIN_TICK_INTERVAL_US <= interval_us <= MAX_TICK_INTERVAL_US
    ):
        raise _header_error(magic, sensors, ticks, mask, encoding, flags, reserved, interval_us)
    width = _VALUES_PER_SENSOR[mask]
    expected = HEADER_BYTES + ticks * sensors * width * (2 if encoding else 4)
    if size != expected:
        raise PacketError(
            say(
                "packet.length", size=size, sensors=sensors, ticks=ticks, mask=f"{mask:#x}", expected=expected
            ),
            reason="truncated" if size < expected else "length",
        )
    view = memoryview(data)
    if zlib.crc32(view[HEADER_BYTES:], zlib.crc32(view[:_CRC])) != crc:
        raise PacketError(
            say("packet.crc"),
            reason="crc",
            sequence=sequence,
        )
    if declaration is not None:
        _check_declared(declaration, sensors, mask, encoding, interval_us, sequence)
    values = np.frombuffer(data, "<i2" if encoding else "<f4", offset=HEADER_BYTES).reshape(
        ticks, sensors, width
    )
    if not encoding and not np.abs(values).max() <= VALUE_LIMIT:
        raise _value_error(values, sequence)
    return Packet(data, sequence, time_us, interval_us, sensors, ticks, mask, encoding, flags, values)


def encode_packet(
    values: NDArray[np.float32] | NDArray[np.int16],
    *,
    sequence: int,
    device_time_us: int,
    tick_interval_us: int,
    channels: int = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER,
    flags: int = 0,
) -> bytes:
    """Encode one packet; the counterpart of `decode_packet`, for gateways and tests.

    Parameters
    ----------
    values : ndarray of float32 or int16, shape (K, S, W)
        SI values, or counts under the scales of the hello.
    sequence : int
        Taken modulo 2^32.

    Raises
    ------
    PacketError
        When the counts do not fit the format.
    """
    if values.dtype not in (np.dtype("<f4"), np.dtype("<i2")) or values.ndim != 3:
        raise PacketError(say("packet.values"), reason="encoding")
    ticks, sensors, width = values.shape
    if not 0 < int(channels) <= _KNOWN_MASK or width != _VALUES_PER_SENSOR[int(channels)]:
        raise PacketError(say("packet.width", width=width, mask=f"{int(channels):#x}"), reason="channel_mask")
    encoding = INT16 if values.dtype == np.dtype("<i2") else FLOAT32
    if not (
        0 < sensors <= MAX_SENSORS
        and 0 < ticks <= MAX_TICKS
        and MIN_TICK_INTERVAL_US <= tick_interval_us <= MAX_TICK_INTERVAL_US
    ):
        raise _header_error(MAGIC, sensors, ticks, int(channels), encoding, flags, 0, tick_interval_us)
    head = _HEADER_WITHOUT_CRC.pack(
        MAGIC,
        sensors,
        ticks,
        int(channels),
        encoding,
        flags,
        0,
        sequence & 0xFFFFFFFF,
        device_time_us & 0xFFFFFFFFFFFFFFFF,
        tick_interval_us,
    )
    payload = values.tobytes()
    return head + struct.pack("<I", zlib.crc32(payload, zlib.crc32(head))) + payload


def with_flags(data: bytes, flags: int) -> bytes:
    """Return the packet with other flags and the CRC made again, e.g. to mark it back-filled."""
    head = data[:_FLAGS] + bytes([flags]) + data[_FLAGS + 1 : _CRC]
    payload = data[HEADER_BYTES:]
    return head + struct.pack("<I", zlib.crc32(payload, zlib.crc32(head))) + payload


def packet_from_json(message: JsonPacket, declaration: Declaration | None = None) -> Packet:
    """Turn a JSON packet into the same `Packet` as its binary form.

    Raises
    ------
    PacketError
        `shape` when the sensors differ in rows or a row has not three values, else as `decode_packet`.
    """
    if not 0 < len(message.sensors) <= MAX_SENSORS:
        raise _header_error(MAGIC, len(message.sensors), 1, 7, FLOAT32, 0, 0, 10_000)
    first = message.sensors[0]
    sent = [spec for spec in _IN_JSON if getattr(first, spec.name) is not None]
    mask = sum(int(spec.bit) for spec in sent)
    ticks = len(first.gyroscope)
    columns = [_rows_of(sensor, number, sent, ticks) for number, sensor in enumerate(message.sensors)]
    values = np.stack(columns, axis=1)
    if not (np.abs(values) <= VALUE_LIMIT).all():
        raise _value_error(values, message.sequence)
    data = encode_packet(
        values.astype("<f4"),
        sequence=message.sequence,
        device_time_us=message.device_time_us,
        tick_interval_us=message.tick_interval_us,
        channels=mask,
    )
    return decode_packet(data, declaration)


def _rows_of(sensor: JsonSensor, number: int, sent: list[ChannelSpec], ticks: int) -> NDArray[np.float64]:
    """Return one sensor's values side by side, shape (K, W)."""
    parts = []
    for spec in _IN_JSON:
        rows = getattr(sensor, spec.name)
        if spec not in sent:
            if rows is not None:
                raise PacketError(say("packet.all_or_none", channel=spec.name), reason="shape", sensor=number)
            continue
        rows = rows or []
        if len(rows) != ticks or (spec.width > 1 and any(len(row) != spec.width for row in rows)):
            raise PacketError(
                say("packet.shape", sensor=number, ticks=ticks),
                reason="shape",
                sensor=number,
            )
        parts.append(np.asarray(rows, "<f8").reshape(-1, spec.width))
    return np.concatenate(parts, axis=1)


def _check_declared(
    declaration: Declaration, sensors: int, mask: int, encoding: int, interval_us: int, sequence: int
) -> None:
    if sensors != len(declaration.placements):
        raise PacketError(
            say("packet.sensors_declared", sensors=sensors, declared=len(declaration.placements)),
            reason="sensor_count",
            sequence=sequence,
        )
    if not 0.9 < interval_us * 1e-6 * declaration.rate_hz < 1.1:
        raise PacketError(
            say("packet.interval_declared", interval_us=interval_us, rate_hz=declaration.rate_hz),
            reason="tick_interval",
            sequence=sequence,
        )
    if encoding == INT16 and mask & ~declaration.countable_channels:
        if mask & _FLOAT32_ONLY:
            raise PacketError(
                say("packet.mask_scale", mask=f"{mask:#x}"),
                reason="undeclared_scale",
                sequence=sequence,
            )
        for spec in CHANNELS:
            if mask & spec.bit and spec.name not in declaration.scales:
                raise PacketError(
                    say("packet.scale", field=f"{spec.name}_scale"),
                    reason="undeclared_scale",
                    sequence=sequence,
                )


def _header_error(
    magic: bytes,
    sensors: int,
    ticks: int,
    mask: int,
    encoding: int,
    flags: int,
    reserved: int,
    interval_us: int,
) -> PacketError:
    if magic != MAGIC:
        return PacketError(say("packet.magic"), reason="magic")
    if reserved:
        return PacketError(say("packet.reserved"), reason="reserved")
    if flags > _KNOWN_FLAGS:
        return PacketError(say("packet.flags", flags=f"{flags:#x}"), reason="flags")
    if encoding > INT16:
        return PacketError(say("packet.encoding", encoding=encoding), reason="encoding")
    if not 0 < mask <= _KNOWN_MASK:
        return PacketError(say("packet.mask", mask=f"{mask:#x}"), reason="channel_mask")
    if not 0 < sensors <= MAX_SENSORS:
        return PacketError(say("packet.sensors", sensors=sensors, most=MAX_SENSORS), reason="sensor_count")
    if not 0 < ticks <= MAX_TICKS:
        return PacketError(say("packet.ticks", ticks=ticks, most=MAX_TICKS), reason="tick_count")
    return PacketError(
        say(
            "packet.interval",
            interval_us=interval_us,
            least_us=MIN_TICK_INTERVAL_US,
            most_us=MAX_TICK_INTERVAL_US,
        ),
        reason="tick_interval",
    )


def _value_error(values: NDArray[np.float32] | NDArray[np.float64], sequence: int) -> PacketError:
    wrong = ~(np.abs(values) <= VALUE_LIMIT)
    tick, sensor, _ = (int(position[0]) for position in np.nonzero(wrong))
    where = {"sequence": sequence, "tick": tick, "sensor": sensor}
    if not np.isfinite(values).all():
        return PacketError(
            say("packet.not_finite", tick=tick, sensor=sensor),
            reason="not_finite",
            **where,
        )
    return PacketError(
        say("packet.absurd", tick=tick, sensor=sensor, limit=f"{VALUE_LIMIT:g}"),
        reason="absurd_value",
        **where,
    )
