"""Packets that came one after the other, as they came: what a live session gives to the store many at a time."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.network.packet import HEADER, HEADER_BYTES, OFFSETS
from app.network.raw_packet import WIDTH, RawPacket

_SENSORS, _TICKS, _ENCODING = OFFSETS["sensor_count"], OFFSETS["tick_count"], OFFSETS["encoding"]
_MASK: Final = slice(OFFSETS["channels"], _ENCODING)
_SHAPE: Final = slice(_SENSORS, OFFSETS["flags"])
"""Sensors, ticks, channels and encoding, in the bytes of a packet."""
H_SEQUENCE, H_DEVICE_TIME, H_INTERVAL, H_TICKS, H_FLAGS, H_ARRIVAL, HEAD_COLUMNS = range(7)
"""Columns of the heads of packets: sequence, device time, tick interval, ticks, flags and arrival."""


@dataclass(slots=True)
class PacketRun:
    """Packets with consecutive sequences and of one shape. Treat as immutable.

    Attributes
    ----------
    first_sequence : int
        Of the first packet; may go on above 32 bits where the sender's counter wrapped.
    messages : list of bytes
        Whole packets of the wire format, checked.
    arrivals_ns : list of int
        Server clock when each arrived, ns since the epoch.
    """

    first_sequence: int
    messages: list[bytes]
    arrivals_ns: list[int]

    @property
    def stop_sequence(self) -> int:
        """Sequence behind the last packet."""
        return self.first_sequence + len(self.messages)

    @property
    def shape(self) -> tuple[int, bytes]:
        """Length, sensors, ticks, channels and encoding, which all its packets have in common."""
        first = self.messages[0]
        return len(first), first[_SHAPE]

    @property
    def size(self) -> int:
        """Bytes of its packets."""
        return len(self.messages) * len(self.messages[0])

    @property
    def tick_count(self) -> int:
        """Ticks of all packets."""
        return len(self.messages) * self.messages[0][_TICKS]

    def packets(self) -> list[RawPacket]:
        """Return the packets one by one."""
        heads = self.heads().tolist()
        first = self.messages[0]
        sensors, mask, encoding = first[_SENSORS], int.from_bytes(first[_MASK], "little"), first[_ENCODING]
        return [
            RawPacket(
                sequence,
                device_us % 2**64,
                interval_us,
                sensors,
                ticks,
                mask,
                encoding,
                flags,
                message[HEADER_BYTES:],
                arrival_ns,
            )
            for (sequence, device_us, interval_us, ticks, flags, arrival_ns), message in zip(
                heads, self.messages, strict=True
            )
        ]

    def heads(self) -> NDArray[np.int64]:
        """Return what the heads hold, shape (P, HEAD_COLUMNS); a device's clock of 64 bits without its sign."""
        return heads_of([self])

    def values_per_tick(self) -> int:
        """Return how many numbers a tick has, over all sensors."""
        first = self.messages[0]
        return (len(first) - HEADER_BYTES) // (first[_TICKS] * WIDTH[first[_ENCODING]])

    def described(self) -> dict[str, int]:
        """Return what the columns of a chunk say of the shape of its packets."""
        first = self.messages[0]
        return {
            "sensor_count": first[_SENSORS],
            "channel_mask": int.from_bytes(first[_MASK], "little"),
            "encoding": first[_ENCODING],
            "values_per_tick": self.values_per_tick(),
        }


def heads_of(runs: Sequence[PacketRun]) -> NDArray[np.int64]:
    """Return the `PacketRun.heads` of runs below each other: read at once, because most runs are of one packet."""
    heads = [message[:HEADER_BYTES] for one in runs for message in one.messages]
    read = np.frombuffer(b"".join(heads), HEADER)
    found = np.empty((len(heads), HEAD_COLUMNS), np.int64)
    found[:, H_SEQUENCE] = [number for one in runs for number in range(one.first_sequence, one.stop_sequence)]
    found[:, H_DEVICE_TIME] = read["device_time_us"].view(np.int64)
    found[:, H_INTERVAL], found[:, H_TICKS] = read["tick_interval_us"], read["tick_count"]
    found[:, H_FLAGS] = read["flags"]
    found[:, H_ARRIVAL] = [arrival_ns for one in runs for arrival_ns in one.arrivals_ns]
    return found


def joined_ranges(runs: Iterable[PacketRun]) -> Iterable[tuple[int, int]]:
    """Return the sequences of runs, half-open; runs that follow one another as one."""
    first = stop = -1
    for one in runs:
        if one.first_sequence != stop:
            if stop > first:
                yield first, stop
            first = one.first_sequence
        stop = one.stop_sequence
    if stop > first:
        yield first, stop


def runs_of(first_sequence: int, messages: list[bytes], arrivals_ns: list[int]) -> list[PacketRun]:
    """Return packets with consecutive sequences as runs of one shape each."""
    shapes = [(len(one), one[_SHAPE]) for one in messages]
    if len(set(shapes)) == 1:
        return [PacketRun(first_sequence, messages, arrivals_ns)]
    starts = [0, *(n for n in range(1, len(shapes)) if shapes[n] != shapes[n - 1]), len(shapes)]
    return [
        PacketRun(first_sequence + start, messages[start:stop], arrivals_ns[start:stop])
        for start, stop in pairwise(starts)
    ]
