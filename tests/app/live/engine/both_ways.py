"""One stream given to two sessions: packet by packet the general way, and to the pooled engine in turns."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from app.errors import TelemotionError
from app.gateway import DeviceStream
from app.live.engine.turns import PooledEngine
from app.live.session.intake import Intake
from app.network.packet import PacketFlag, decode_packet, encode_packet
from estimators.channels import Channel

MOTION = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER


@dataclass
class Sender:
    """A gateway's connection without a socket."""

    intake: Intake
    refused: list[str] = field(default_factory=list)

    @property
    def lane(self) -> Any:
        return self.intake.lane

    def take_rare(self, data: bytes, arrival_s: float, arrival_ns: int) -> None:
        try:
            packet = decode_packet(data, self.intake.declaration)
            self.intake.receive(packet, arrival_s, arrival_ns)
        except TelemotionError as error:
            self.refused.append(str(error.details.get("reason")))


def masked(data: bytes, key: int) -> memoryview:
    """A packet as a client sends it."""
    mask = np.resize(np.frombuffer(key.to_bytes(4, "little"), np.uint8), len(data))
    return memoryview((np.frombuffer(data, np.uint8) ^ mask).tobytes())


def offer(engine: PooledEngine, sender: Sender, data: bytes, key: int, arrival_s: float) -> None:
    engine.offer(sender, masked(data, key), key, arrival_s, int(1e9 * arrival_s))


@dataclass(frozen=True)
class Faults:
    """What happens to a stream, drawn by chance."""

    lost: float
    late: float
    repeated: float
    wrong: float
    jitter_us: float
    drift: float
    is_float: bool
    ticks: tuple[int, ...]
    saturated: float
    away: tuple[tuple[int, int, int], ...]
    jumps: tuple[int, ...]
    outages: tuple[tuple[int, int], ...] = ()
    """Ticks between which the link was down: they are filled in later."""

    @classmethod
    def draw(cls, random: np.random.Generator, ticks: int, sensors: int) -> "Faults":
        def sometimes(share: float, value: float) -> float:
            return value if random.random() < share else 0.0

        off_grid = random.random() < 0.4
        return cls(
            lost=sometimes(0.5, 0.05),
            late=sometimes(0.5, 0.05),
            repeated=sometimes(0.5, 0.05),
            wrong=sometimes(0.3, 0.02),
            jitter_us=sometimes(0.3, 150.0),
            drift=sometimes(0.7, float(random.normal(0.0, 2e-3))) if off_grid else 0.0,
            is_float=bool(random.random() < 0.3),
            ticks=((5,), (1, 5, 10), (20,), (64, 3))[int(random.integers(4))],
            saturated=sometimes(0.3, 0.01),
            away=tuple(
                (int(random.integers(sensors)), start, start + int(random.choice([3, 30, 120])))
                for start in random.integers(0, ticks, int(random.integers(4))).tolist()
            ),
            jumps=(int(random.integers(ticks)),) if random.random() < 0.15 else (),
            outages=tuple(
                (start, start + int(random.choice([10, 100, 400])))
                for start in random.integers(0, ticks, int(random.integers(3))).tolist()
            ),
        )


def packets_of(stream: DeviceStream, faults: Faults, random: np.random.Generator) -> list[bytes]:
    """The packets of a stream, as they arrive."""
    counts = np.array(stream.counts)
    for sensor, start, stop in faults.away:
        counts[start:stop, sensor] = 0
    if faults.saturated:
        counts[random.random(counts.shape) < faults.saturated / 9.0] = 32767
    scales = [stream.full_scales[name] / 32767.0 for name in ("gyroscope", "accelerometer", "magnetometer")]
    scale = np.repeat(scales, 3)
    sent: list[tuple[float, bytes]] = []
    tick = sequence = shift_us = 0
    while tick < len(counts):
        ticks = min(faults.ticks[sequence % len(faults.ticks)], len(counts) - tick)
        if any(tick <= jump < tick + ticks for jump in faults.jumps):
            shift_us += int(random.choice([-5_000_000, 40_000, 2_000_000]))
        time_us = 1e4 * tick * (1.0 + faults.drift) + faults.jitter_us * random.normal() + 1e6 + shift_us
        values = counts[tick : tick + ticks]
        data = encode_packet(
            (values * scale).astype("<f4") if faults.is_float else np.ascontiguousarray(values),
            sequence=sequence,
            device_time_us=max(0, round(time_us)),
            tick_interval_us=round(1e4 * (1.0 + faults.drift)),
            channels=MOTION,
            flags=PacketFlag.SATURATED * (bool(faults.saturated) and bool((values == 32767).any()))
            | PacketFlag.BACKFILLED * any(start <= tick < stop for start, stop in faults.outages),
        )
        if random.random() < faults.wrong:
            data = data[:40] + bytes([data[40] ^ 1]) + data[41:]
        if random.random() >= faults.lost:
            place = float(sequence) + (random.integers(1, 6) if random.random() < faults.late else 0.0)
            sent.append((place, data))
            if random.random() < faults.repeated:
                sent.append((place + int(random.integers(0, 30)), data))
        tick += ticks
        sequence += 1
    return [data for _, data in sorted(sent, key=lambda one: one[0])]


def worn(stream: DeviceStream, placements: tuple[str, ...]) -> DeviceStream:
    """Some sensors of a stream."""
    rows = [stream.placements.index(name) for name in placements]
    return replace(stream, placements=placements, counts=np.ascontiguousarray(stream.counts[:, rows]))
