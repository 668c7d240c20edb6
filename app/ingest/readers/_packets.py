"""A file's recording as packets, so that it is stored and analysed exactly like a streamed one."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from app.errors import RecordingFormatError
from app.ingest.declaration import Declaration, check_placements
from app.ingest.packet import Channel
from app.recordings.chunks import FLOAT32, RawPacket
from app.sentences import say
from estimators.conventions import PLACEMENTS, Placement
from estimators.recording import Recording

PACKET_S: Final = 0.05
_EVEN: Final = 0.02
"""Ticks of one packet lie this close to their even spacing, in ticks; else each is its own packet."""


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
        time_us = np.round(sensors[0].time_s * 1e6).astype(np.int64)
        interval_us = max(1, round(1e6 / self.declaration.rate_hz))
        has_field = sensors[0].magnetometer_t is not None
        mask = int(Channel.GYROSCOPE | Channel.ACCELEROMETER | (Channel.MAGNETOMETER if has_field else 0))
        ticks = max(1, min(64, round(PACKET_S * self.declaration.rate_hz)))
        for sequence, (first, stop) in enumerate(_groups(time_us, interval_us, ticks)):
            values = np.stack(
                [
                    np.concatenate(
                        [
                            s.gyroscope_radps[first:stop],
                            s.accelerometer_mps2[first:stop],
                            *([s.magnetometer_t[first:stop]] if s.magnetometer_t is not None else []),
                        ],
                        axis=1,
                    )
                    for s in sensors
                ],
                axis=1,
            )
            nothing = ~np.isfinite(values[:, :, :6]).all(axis=2)
            values[nothing] = 0.0
            yield RawPacket(
                sequence=sequence,
                device_time_us=int(time_us[first]),
                tick_interval_us=interval_us,
                sensor_count=len(sensors),
                tick_count=stop - first,
                channel_mask=mask,
                encoding=FLOAT32,
                flags=0,
                payload=np.nan_to_num(values, nan=0.0).astype("<f4").tobytes(),
                arrival_ns=arrival_ns,
            )


def packets_of(recording: Recording, *, any_name: bool = False) -> RecordingPackets:
    """Prepare a recording whose sensors share one time column.

    Parameters
    ----------
    recording : Recording
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
    first = recording.sensors[ours[0]]
    if any(not np.array_equal(recording.sensors[name].time_s, first.time_s) for name in ours):
        raise RecordingFormatError(say("file.time_stamps_differ"))
    clip_radps = recording.metadata.get("gyroscope_clip_radps")
    declaration = Declaration(
        placements=cast(tuple[Placement, ...], tuple(ours)) if any_name else check_placements(ours),
        rate_hz=recording.nominal_rate_hz,
        device=recording.origin[:100],
        clip_gyroscope_radps=None if clip_radps is None else float(clip_radps),
    )
    left_out = tuple(name for name in recording.sensors if name not in ours)
    more = recording.metadata.get("left_out")
    return RecordingPackets(recording, declaration, left_out + ((more,) if more else ()))


def _groups(time_us: np.ndarray, interval_us: int, ticks: int) -> Iterator[tuple[int, int]]:
    """Split into runs of `ticks` even ticks; where the stamps are not even, one tick a packet."""
    tolerance_us = max(1.0, _EVEN * interval_us)
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


__all__ = ["RecordingPackets", "packets_of"]
