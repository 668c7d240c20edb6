"""A file's recording as packets, in which it is stored, and back on its own stamps, on which it is analysed."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.network.declaration import Declaration, check_placements
from app.network.raw_packet import FLOAT32, RawPacket
from app.readers.sensor_names import check_names
from estimators.channels import INERTIAL, INERTIAL_WIDTH, Channel
from estimators.conventions import PLACEMENTS, Placement
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say

_RATE, _FORCE, _INERTIAL, _FIELD = (
    slice(0, 3),
    slice(3, INERTIAL_WIDTH),
    slice(INERTIAL_WIDTH),
    slice(INERTIAL_WIDTH, 9),
)
"""Columns of a sensor in a packet of motion."""

PACKET_S: Final = 0.05
_EVEN: Final = 0.002
"""Ticks of one packet lie this close to their even spacing, in ticks; else each is its own packet."""
_CLIP_LABELS: Final = {"gyroscope": "gyroscope_clip_radps", "accelerometer": "accelerometer_clip_mps2"}
"""Where a file's metadata says from which on a channel is cut off."""


@dataclass(frozen=True)
class RecordingPackets:
    """A recording with one time column for all sensors, ready to be packed.

    Attributes
    ----------
    declaration : Declaration
        What a gateway would have said in its hello.
    left_out : tuple of str
        Sensors of the file at no supported position.
    """

    recording: Recording
    declaration: Declaration
    left_out: tuple[str, ...]

    @property
    def tick_count(self) -> int:
        """Ticks in the file."""
        return int(self.recording.sensors[self.declaration.placements[0]].time_s.size)

    def packets(self, arrival_ns: int) -> Iterator[RawPacket]:
        """Yield float32 packets in order; a sensor without a sample sends zeros, as on the wire."""
        sensors = [self.recording.sensors[name] for name in self.declaration.placements]
        time_us = _whole_microseconds(sensors[0].time_s)
        interval_us = max(1, round(1e6 / self.declaration.rate_hz))
        values, mask = _wire_values(sensors)
        ticks = max(1, min(64, round(PACKET_S * self.declaration.rate_hz)))
        for sequence, (first, stop) in enumerate(_groups(time_us, interval_us, ticks)):
            yield RawPacket(
                sequence=sequence,
                device_time_us=int(time_us[first]),
                tick_interval_us=interval_us,
                sensor_count=len(sensors),
                tick_count=stop - first,
                channel_mask=mask,
                encoding=FLOAT32,
                flags=0,
                payload=values[first:stop].tobytes(),
                arrival_ns=arrival_ns,
            )

    def as_stored(self) -> Recording:
        """Return the recording as a session that holds these packets gives it, notes and metadata included.

        Numbers have 32 bits and stamps whole microseconds; what is at no supported position is not in it.
        """
        found = stamped(self.packets(0), self.declaration)
        return replace(
            self.recording, sensors=found.sensors, metadata=self.recording.metadata | found.metadata
        )


def stamped(packets: Iterable[RawPacket], declaration: Declaration) -> Recording:
    """Return the recording that was stored as packets, on the stamps that its file had.

    Parameters
    ----------
    packets : iterable of RawPacket
        By rising sequence, as `RecordingPackets.packets` gives them; others, of a log that somebody made, are left out.
    declaration : Declaration
        Says that its packets carry the stamps of a file.

    Returns
    -------
    Recording
        Sensors in the order of the declaration; where one gave nothing it has no sample.
    """
    first = None
    heads: list[tuple[int, int, int]] = []
    payload = bytearray()
    for packet in packets:
        first = packet if first is None else first
        if packet.shape_key == first.shape_key and packet.encoding == FLOAT32:
            heads.append((packet.device_time_us, packet.tick_interval_us, packet.tick_count))
            payload += packet.payload
    if first is None or not heads or first.channel_mask & INERTIAL != INERTIAL:
        raise RecordingFormatError(say("log.no_packet"))
    start_us, interval_us, counts = np.array(heads, dtype=np.int64).T
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    time_us = np.repeat(start_us, counts) + within * np.repeat(interval_us, counts)
    values = np.frombuffer(payload, "<f4").reshape(time_us.size, first.sensor_count, -1).astype(np.float64)
    rises = np.r_[True, time_us[1:] > np.maximum.accumulate(time_us)[:-1]]
    time_s, values = (time_us[rises] - time_us[0]) * 1e-6, values[rises]
    has_field = bool(first.channel_mask & Channel.MAGNETOMETER)
    has_temperature = bool(first.channel_mask & Channel.TEMPERATURE)
    sensors: dict[str, SensorSignals] = {}
    for row, name in enumerate(declaration.placements):
        measured = values[:, row, _INERTIAL].any(axis=1)
        columns = values[measured, row]
        field = columns[:, _FIELD].copy() if has_field else None
        if field is not None:
            field[~field.any(axis=1)] = np.nan
        sensors[name] = SensorSignals(
            time_s[measured],
            np.ascontiguousarray(columns[:, _RATE]),
            np.ascontiguousarray(columns[:, _FORCE]),
            field if field is not None and np.isfinite(field).any() else None,
            temperature_degc=columns[:, -1].copy() if has_temperature else None,
        )
    return Recording(
        sensors,
        declaration.rate_hz,
        origin=declaration.device,
        metadata={
            label: str(declaration.full_scales[name])
            for name, label in _CLIP_LABELS.items()
            if name in declaration.full_scales
        },
    )


def packets_of(recording: Recording, *, any_name: bool = False) -> RecordingPackets:
    """Prepare a recording whose sensors share one time column.

    Parameters
    ----------
    any_name : bool
        Single sensors: what they are called need be no placement.

    Raises
    ------
    RecordingFormatError
        None of its sensors is a placement, or they have different time stamps.
    """
    ours: list[str] = [name for name in recording.sensors if any_name or name in PLACEMENTS]
    if not ours:
        raise RecordingFormatError(say("file.no_placement", placements=list(PLACEMENTS)))
    check_names(ours)
    first = recording.sensors[ours[0]]
    if any(not np.array_equal(recording.sensors[name].time_s, first.time_s) for name in ours):
        raise RecordingFormatError(say("file.time_stamps_differ"))
    full_scales = {
        name: float(recording.metadata[label])
        for name, label in _CLIP_LABELS.items()
        if label in recording.metadata
    }
    declaration = Declaration(
        placements=cast(tuple[Placement, ...], tuple(ours)) if any_name else check_placements(ours),
        rate_hz=recording.nominal_rate_hz,
        device=recording.origin[:100],
        full_scales=full_scales,
        is_stamped=True,
    )
    left_out = tuple(name for name in recording.sensors if name not in ours)
    more = recording.metadata.get("left_out")
    return RecordingPackets(recording, declaration, left_out + ((more,) if more else ()))


def as_feet(recording: Recording) -> Recording:
    """Return what packets can hold of two shoes: the heel's sensor as the foot's, and the lower legs."""
    named = {
        name.replace("heel", "foot"): replace(sensor, force_n=None, moment_nm=None)
        for name, sensor in recording.sensors.items()
        if not name.startswith("forefoot")
    }
    return replace(recording, sensors=named)


def _whole_microseconds(time_s: Float) -> NDArray[np.int64]:
    """Return strictly rising stamps in whole microseconds: two that are less apart must not become one."""
    rounded = np.round(time_s * 1e6).astype(np.int64)
    places = np.arange(rounded.size)
    return np.asarray(np.maximum.accumulate(rounded - places) + places)


def _wire_values(sensors: Sequence[SensorSignals]) -> tuple[NDArray[np.float32], int]:
    """Return what the packets hold, shape (N, S, W), and the mask of its channels.

    Temperature of all sensors or of none: no number says that there is none.
    """
    has_field = any(sensor.magnetometer_t is not None for sensor in sensors)
    width = _FIELD.stop if has_field else _INERTIAL.stop
    values = np.zeros((sensors[0].time_s.size, len(sensors), width), dtype="<f4")
    for row, sensor in enumerate(sensors):
        inertial = np.concatenate([sensor.gyroscope_radps, sensor.accelerometer_mps2], axis=1)
        values[:, row, _INERTIAL] = _or_nothing(inertial)
        if sensor.magnetometer_t is not None:
            values[:, row, _FIELD] = _or_nothing(sensor.magnetometer_t)
    mask = int(INERTIAL | (Channel.MAGNETOMETER if has_field else 0))
    warmth = [sensor.temperature_degc for sensor in sensors if sensor.temperature_degc is not None]
    if len(warmth) < len(sensors) or not np.isfinite(warmth).all():
        return values, mask
    column = np.stack(warmth, axis=1)[..., np.newaxis].astype("<f4")
    return np.concatenate([values, column], axis=2), mask | int(Channel.TEMPERATURE)


def _or_nothing(samples: Float) -> Float:
    """Return samples, shape (N, C), with zeros for those that are not finite in all they hold."""
    return np.asarray(np.where(np.isfinite(samples).all(axis=1, keepdims=True), samples, 0.0))


def _groups(time_us: np.ndarray, interval_us: int, ticks: int) -> Iterator[tuple[int, int]]:
    """Split into runs of `ticks` even ticks; where the stamps are not even, one tick a packet."""
    # An interval in whole microseconds alone is off by half a one at every tick.
    tolerance_us = max(1.0 + 0.5 * ticks, _EVEN * interval_us)
    first = 0
    while first < time_us.size:
        stop = min(first + ticks, time_us.size)
        expected = time_us[first] + interval_us * np.arange(stop - first)
        if (np.abs(time_us[first:stop] - expected) <= tolerance_us).all():
            yield first, stop
        else:
            for tick in range(first, stop):
                yield tick, tick + 1
        first = stop
