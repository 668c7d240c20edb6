"""A recording as the packets that a device would send."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from app.errors import InvalidInput
from app.gateway.client import Delivery
from app.network.messages import PROTOCOL_VERSION, HelloMessage
from app.network.packet import encode_packet
from estimators.channels import CHANNELS, MOTION, Channel
from estimators.recording import Recording
from estimators.simulation.faults import DeliveryPlan, LinkFaults, plan_delivery

_FULL_COUNTS = 32767.0
_NO_LOAD = -32768.0 / _FULL_COUNTS
EPOCH_US = 1_000_000_000
"""Device clock when the simulated device begins to measure; no device starts at zero."""


FULL_SCALES: Final[Mapping[str, float]] = {
    spec.name: spec.full_scale for spec in CHANNELS if spec.full_scale is not None
}
"""Largest value of the simulated device's 16-bit counts, SI, by channel."""


@dataclass(frozen=True)
class DeviceStream:
    """Everything that a device sends in one session, before any fault.

    Attributes
    ----------
    counts : ndarray of int16, shape (K, S, W)
    full_scales : mapping of str to float
        Of the counts, by channel; `FULL_SCALES` unless the device has others.
    serials : tuple of str
        One a sensor, or none.
    channels : Channel
        What W values of a sensor are.
    """

    placements: tuple[str, ...]
    rate_hz: float
    counts: NDArray[np.int16]
    full_scales: Mapping[str, float] = field(default_factory=lambda: FULL_SCALES)
    ticks_per_packet: int = 5
    device: str = "telemotion simulator"
    serials: tuple[str, ...] = ()
    channels: Channel = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER

    @property
    def packet_count(self) -> int:
        """Number of packets; the last one may be shorter."""
        return -(-int(self.counts.shape[0]) // self.ticks_per_packet)

    @property
    def packet_s(self) -> float:
        """Time that a packet covers."""
        return self.ticks_per_packet / self.rate_hz

    def hello(self, ticket: str) -> HelloMessage:
        """Return the first message of a connection."""
        sent = [spec for spec in CHANNELS if self.channels & spec.bit and spec.scale_limit is not None]
        declared = {f"{spec.name}_scale": self.full_scales[spec.name] / _FULL_COUNTS for spec in sent}
        declared |= {f"clip_{spec.field}": self.full_scales[spec.name] for spec in MOTION[:2]}
        return HelloMessage(
            protocol_version=PROTOCOL_VERSION,
            ticket=ticket,
            placements=list(self.placements),
            rate_hz=self.rate_hz,
            device=self.device,
            serials=list(self.serials),
            firmware="1",
            **declared,
        )

    def packet(self, number: int, device_time_s: float | None = None) -> bytes:
        """Return packet `number`; its device time is even unless another is given."""
        start = number * self.ticks_per_packet
        time_s = start / self.rate_hz if device_time_s is None else device_time_s
        return encode_packet(
            self.counts[start : start + self.ticks_per_packet],
            sequence=number,
            device_time_us=EPOCH_US + round(time_s * 1e6),
            tick_interval_us=round(1e6 / self.rate_hz),
            channels=self.channels,
        )

    def plan(self, faults: LinkFaults | None = None, seed: int = 0) -> DeliveryPlan:
        """Return what is sent when, over a link with these faults."""
        return plan_delivery(self.packet_count, self.packet_s, faults or LinkFaults(), seed)

    def deliveries(self, plan: DeliveryPlan) -> Iterator[Delivery]:
        """Yield the packets of a plan in sending order, encoded when their time comes."""
        for number, send_s in zip(plan.packet.tolist(), plan.send_s.tolist(), strict=True):
            yield Delivery(number, self.packet(number, float(plan.device_time_s[number])), send_s)


def stream_of(
    recording: Recording, *, full_scales: Mapping[str, float] = FULL_SCALES, ticks_per_packet: int = 5
) -> DeviceStream:
    """Turn a recording with one common, even time base into a device's stream.

    Parameters
    ----------
    recording : Recording
        All sensors with the same number of samples; NaN becomes zeros, the sign of nothing measured.
    full_scales : mapping of str to float, optional
        Of the counts, by channel.
    ticks_per_packet : int
        1 to 64; 5 to 10 are a good choice.

    Raises
    ------
    InvalidInput
        The sensors do not share their ticks; resample first (`estimators.signals.to_common_ticks`).
    """
    lengths = {signals.time_s.shape[0] for signals in recording.sensors.values()}
    if len(lengths) != 1:
        raise InvalidInput("The sensors of this recording do not share their ticks; resample it first.")
    sensors = list(recording.sensors.values())
    sent = [
        spec
        for spec in CHANNELS
        if spec.name in full_scales
        and (all if spec in MOTION else any)(getattr(found, spec.field) is not None for found in sensors)
    ]
    columns = []
    for signals in sensors:
        parts = []
        for spec in sent:
            values = getattr(signals, spec.field)
            # All sensors of a packet have the same channels: zeros for those without a cell, elsewhere zero is a value.
            part = np.full((signals.time_s.size, spec.width), 0.0 if spec.cell else np.nan)
            if values is not None:
                part = values.reshape(part.shape) / full_scales[spec.name]
            # What gave nothing sends what nothing measures.
            parts.append(part if spec in MOTION else np.where(np.isnan(part), _NO_LOAD, part))
        table = np.concatenate(parts, axis=1)
        table[np.isnan(table).any(axis=1)] = 0.0
        columns.append(np.rint(np.where(table == _NO_LOAD, table, np.clip(table, -1.0, 1.0)) * _FULL_COUNTS))
    counts = np.stack(columns, axis=1).astype(np.int16)
    return DeviceStream(
        recording.placements,
        recording.nominal_rate_hz,
        counts,
        full_scales,
        ticks_per_packet,
        serials=_serials_of(recording),
        channels=Channel(sum(spec.bit for spec in sent)),
    )


def _serials_of(recording: Recording) -> tuple[str, ...]:
    """Return serial numbers of simulated sensors: the same errors are the same sensors; files tell none."""
    if recording.origin != "simulation" or "seed" not in recording.metadata:
        return ()
    kind = crc32(recording.metadata.get("sensor_errors", "").encode())
    return tuple(f"simulated-{kind:08x}-{recording.metadata['seed']}-{name}" for name in recording.placements)
