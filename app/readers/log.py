"""Our packet log: the hello and every packet as it came."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from app.errors import PacketError, RecordingFormatError
from app.network.alignment import align_all
from app.network.clock import PacketClock
from app.network.declaration import Declaration, check_hello
from app.network.messages import PROTOCOL_VERSION, HelloMessage
from app.network.packet import Packet, decode_packet
from app.network.packet_log import read_entries, read_head
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.readers.moments import moment_of
from app.readers.packets import stamped
from estimators.recording import ImuChunk, Recording, SampleQuality, SensorSignals
from estimators.sentences import say


@dataclass
class LogReader:
    """Reads a log packet by packet; damaged packets are counted and left out, as on the socket.

    Attributes
    ----------
    declaration : Declaration
        Of the network; its clock epochs grow while packets are read.
    damaged, repeated : int
        Packets left out.
    """

    path: Path
    declaration: Declaration = field(init=False)
    damaged: int = 0
    repeated: int = 0

    def __post_init__(self) -> None:
        with self.path.open("rb") as file:
            self.declaration = declaration_of(read_head(file))

    @property
    def recorded_at(self) -> datetime | None:
        """When its first packet arrived; None where nobody noted that."""
        with self.path.open("rb") as file:
            read_head(file)
            first = next(read_entries(file), None)
        return None if first is None else moment_of(first[0] * 1e-9)

    def packets(self) -> Iterator[tuple[RawPacket, Packet]]:
        """Yield every sound packet once, in the order of the log."""
        clock = PacketClock(self.declaration)
        seen = SequenceRanges()
        with self.path.open("rb") as file:
            read_head(file)
            for arrival_ns, message in read_entries(file):
                try:
                    packet = decode_packet(message, self.declaration)
                    place = clock.admit(packet)
                except PacketError:
                    self.damaged += 1
                    continue
                if place.is_duplicate or not seen.add(place.sequence):
                    self.repeated += 1
                    continue
                self.declaration = clock.declaration
                yield RawPacket.from_packet(packet, arrival_ns, place.sequence), packet


def declaration_of(hello: dict[str, Any]) -> Declaration:
    """Check the hello of a log as the socket would; clock epochs found by a live session stay.

    Raises
    ------
    RecordingFormatError
        With what is wrong in the hello.
    """
    known = set(HelloMessage.model_fields) - {"type", "ticket", "protocol_version"}
    try:
        message = HelloMessage(
            ticket="", protocol_version=PROTOCOL_VERSION, **{k: v for k, v in hello.items() if k in known}
        )
        checked = check_hello(message)
        found = {key: hello[key] for key in ("clock_epochs", "is_stamped") if hello.get(key)}
        if found:
            return Declaration.from_dict({**checked.to_dict(), **found})
    except PacketError as error:
        raise RecordingFormatError(say("log.hello_refused", reason=error.message)) from error
    except (ValidationError, TypeError, KeyError) as error:
        raise RecordingFormatError(say("log.hello_incomplete")) from error
    return checked


def read_ticks(path: Path) -> tuple[ImuChunk, LogReader]:
    """Read a packet log on the common tick of its session, coil states included.

    Raises
    ------
    RecordingFormatError
        No log, cut off, or without a sound packet.
    """
    log = LogReader(path)
    packets = sorted(((raw.sequence, packet) for raw, packet in log.packets()), key=lambda item: item[0])
    chunk = align_all((packet for _, packet in packets), log.declaration)
    if chunk is None:
        raise RecordingFormatError(say("log.no_packet"), damaged=log.damaged)
    return chunk, log


def read_packet_log(path: Path) -> Recording:
    """Read a packet log on the common tick of its session, or on the stamps of its file, without what was not measured.

    Raises
    ------
    RecordingFormatError
        No log, cut off, or without a sound packet.
    """
    log = LogReader(path)
    if log.declaration.is_stamped:
        packets = sorted((raw for raw, _ in log.packets()), key=lambda raw: raw.sequence)
        found = stamped(packets, log.declaration)
        return replace(found, metadata=found.metadata | _about(log))
    chunk, log = read_ticks(path)
    sensors = {}
    for index, placement in enumerate(log.declaration.placements):
        measured = (chunk.quality[index] & (SampleQuality.MISSING | SampleQuality.BRIDGED)) == 0
        magnetometer = None if chunk.magnetometer_t is None else chunk.magnetometer_t[index, measured]
        sensors[str(placement)] = SensorSignals(
            chunk.time_s[measured],
            np.ascontiguousarray(chunk.gyroscope_radps[index, measured]),
            np.ascontiguousarray(chunk.accelerometer_mps2[index, measured]),
            magnetometer,
        )
    return Recording(
        sensors,
        log.declaration.rate_hz,
        origin=f"packet log {log.declaration.device}".strip(),
        metadata=_about(log),
    )


def _about(log: LogReader) -> dict[str, str]:
    return {"format": "packet_log", "damaged_packets": str(log.damaged)}
