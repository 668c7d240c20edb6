"""One packet as it came, as the store and the log of packets hold it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    # The wire format's messages name types of this room; at run time the arrow must not close a circle.
    from app.network.packet import Packet

FLOAT32, COUNTS = 0, 1
WIDTH: Final = {FLOAT32: 4, COUNTS: 2}
"""Bytes of a number, by encoding."""


@dataclass(slots=True)
class RawPacket:
    """One packet as it came: the header's fields, the payload's bytes and when it arrived. Treat as immutable.

    Attributes
    ----------
    sequence : int
        Sequence number of the packet; may go on above 32 bits where the sender's counter wrapped.
    device_time_us : int
        Device clock at the first tick, as sent.
    sensor_count, tick_count, channel_mask, encoding, flags : int
        Fields of the packet header (design page, section 4); encoding 0 is float32, 1 is int16 counts.
    payload : bytes
        For each tick, for each sensor, the channels of the mask.
    arrival_ns : int
        Server clock when it arrived, ns since the epoch. Never mixed with the device clock.
    """

    sequence: int
    device_time_us: int
    tick_interval_us: int
    sensor_count: int
    tick_count: int
    channel_mask: int
    encoding: int
    flags: int
    payload: bytes
    arrival_ns: int

    @property
    def values_per_tick(self) -> int:
        """Numbers in the payload per tick, over all sensors."""
        return len(self.payload) // (self.tick_count * WIDTH[self.encoding])

    @property
    def shape_key(self) -> tuple[int, int, int, int]:
        """Packets share a chunk when this is equal."""
        return self.sensor_count, self.channel_mask, self.encoding, self.values_per_tick

    @classmethod
    def from_packet(cls, packet: "Packet", arrival_ns: int, sequence: int | None = None) -> "RawPacket":
        """Take a decoded packet; `sequence` replaces the one on the wire when its counter wrapped."""
        return cls(
            sequence=packet.sequence if sequence is None else sequence,
            device_time_us=packet.device_time_us,
            tick_interval_us=packet.tick_interval_us,
            sensor_count=packet.sensor_count,
            tick_count=packet.tick_count,
            channel_mask=packet.channels,
            encoding=packet.encoding,
            flags=packet.flags,
            payload=packet.data[len(packet.data) - packet.values.nbytes :],
            arrival_ns=arrival_ns,
        )

    def table(self) -> NDArray[Any]:
        """Return the payload as a view, shape (tick_count, values_per_tick), float32 or int16 counts."""
        dtype = np.dtype("<i2") if self.encoding == COUNTS else np.dtype("<f4")
        return np.frombuffer(self.payload, dtype=dtype).reshape(self.tick_count, -1)
