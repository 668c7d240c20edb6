"""A recording as the packets that a device would send."""

from collections.abc import Iterator
from dataclasses import dataclass
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from app.errors import InvalidInput
from app.gateway.client import Delivery
from app.network.messages import PROTOCOL_VERSION, HelloMessage
from app.network.packet import Channel, encode_packet
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Recording
from estimators.simulation.faults import DeliveryPlan, LinkFaults, plan_delivery

_FULL_COUNTS = 32767.0
_NO_LOAD = -32768.0 / _FULL_COUNTS
_INERTIAL = Channel.GYROSCOPE | Channel.ACCELEROMETER
EPOCH_US = 1_000_000_000
"""Device clock when the simulated device begins to measure; no device starts at zero."""


@dataclass(frozen=True)
class CountScales:
    """Full scale of the device's 16-bit counts; by default 2000 deg/s, 16 g, 4.9 mT, 3 kN and 150 Nm."""

    gyroscope_radps: float = float(np.deg2rad(2000.0))
    accelerometer_mps2: float = 16.0 * GRAVITY_MPS2
    magnetometer_t: float = 4.9e-3
    force_n: float = 3000.0
    moment_nm: float = 150.0


@dataclass(frozen=True)
class DeviceStream:
    """Everything that a device sends in one session, before any fault.

    Attributes
    ----------
    placements : tuple of str
    rate_hz : float
    counts : ndarray of int16, shape (K, S, W)
    scales : CountScales
    ticks_per_packet : int
    device : str
    serials : tuple of str
        One a sensor, or none.
    channels : Channel
        What W values of a sensor are.
    """

    placements: tuple[str, ...]
    rate_hz: float
    counts: NDArray[np.int16]
    scales: CountScales
    ticks_per_packet: int = 5
    device: str = "telemotion simulator"
    serials: tuple[str, ...] = ()
    channels: Channel = _INERTIAL | Channel.MAGNETOMETER

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
        return HelloMessage(
            protocol_version=PROTOCOL_VERSION,
            ticket=ticket,
            placements=list(self.placements),
            rate_hz=self.rate_hz,
            gyroscope_scale=self.scales.gyroscope_radps / _FULL_COUNTS,
            accelerometer_scale=self.scales.accelerometer_mps2 / _FULL_COUNTS,
            magnetometer_scale=self._scale(Channel.MAGNETOMETER, self.scales.magnetometer_t),
            force_scale=self._scale(Channel.FORCE, self.scales.force_n),
            moment_scale=self._scale(Channel.MOMENT, self.scales.moment_nm),
            clip_gyroscope_radps=self.scales.gyroscope_radps,
            clip_accelerometer_mps2=self.scales.accelerometer_mps2,
            device=self.device,
            serials=list(self.serials),
            firmware="1",
        )

    def _scale(self, channel: Channel, full: float) -> float | None:
        return full / _FULL_COUNTS if self.channels & channel else None

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
    recording: Recording, *, scales: CountScales | None = None, ticks_per_packet: int = 5
) -> DeviceStream:
    """Turn a recording with one common, even time base into a device's stream.

    Parameters
    ----------
    recording : Recording
        All sensors with the same number of samples; NaN becomes zeros, the sign of nothing measured.
    scales : CountScales, optional
    ticks_per_packet : int
        1 to 64; 5 to 10 are a good choice.

    Raises
    ------
    InvalidInput
        The sensors do not share their ticks; resample first (`estimators.signals.to_common_ticks`).
    """
    scales = scales or CountScales()
    lengths = {signals.time_s.shape[0] for signals in recording.sensors.values()}
    if len(lengths) != 1:
        raise InvalidInput("The sensors of this recording do not share their ticks; resample it first.")
    has_field = all(signals.magnetometer_t is not None for signals in recording.sensors.values())
    has_loads = any(signals.force_n is not None for signals in recording.sensors.values())
    mask = _INERTIAL | (Channel.MAGNETOMETER if has_field else Channel(0))
    mask |= Channel.FORCE | Channel.MOMENT if has_loads else Channel(0)
    columns = []
    for signals in recording.sensors.values():
        channels = [
            signals.gyroscope_radps / scales.gyroscope_radps,
            signals.accelerometer_mps2 / scales.accelerometer_mps2,
        ]
        if has_field and signals.magnetometer_t is not None:
            channels.append(signals.magnetometer_t / scales.magnetometer_t)
        if has_loads:
            # All sensors of a packet have the same channels: zeros for those without a cell.
            nothing = np.zeros_like(signals.gyroscope_radps)
            for load, full in ((signals.force_n, scales.force_n), (signals.moment_nm, scales.moment_nm)):
                # A cell that gave nothing sends what no cell measures.
                channels.append(nothing if load is None else np.where(np.isnan(load), _NO_LOAD, load / full))
        table = np.concatenate(channels, axis=1)
        table[np.isnan(table).any(axis=1)] = 0.0
        columns.append(np.rint(np.where(table == _NO_LOAD, table, np.clip(table, -1.0, 1.0)) * _FULL_COUNTS))
    counts = np.stack(columns, axis=1).astype(np.int16)
    return DeviceStream(
        recording.placements,
        recording.nominal_rate_hz,
        counts,
        scales,
        ticks_per_packet,
        serials=_serials_of(recording),
        channels=mask,
    )


def _serials_of(recording: Recording) -> tuple[str, ...]:
    """Return serial numbers of simulated sensors: the same errors are the same sensors; files tell none."""
    if recording.origin != "simulation" or "seed" not in recording.metadata:
        return ()
    kind = crc32(recording.metadata.get("sensor_errors", "").encode())
    return tuple(f"simulated-{kind:08x}-{recording.metadata['seed']}-{name}" for name in recording.placements)
