"""Stored sessions that hold a file: the recording on the file's own stamps, and its common ticks.

`telemotion process` estimates the same recording (`RecordingPackets.as_stored`), so that both give the same numbers.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from app.network.declaration import Declaration
from app.readers import stamped
from app.recordings.signals.store import Source, read_packets_in_order
from estimators.recording import ImuChunk, Recording, SampleQuality
from estimators.signals import to_common_ticks


def stored_recording(
    source: Source, session_id: str, hello: Mapping[str, Any] | None, placements: Sequence[str]
) -> Recording | None:
    """Return the recording of a session on the stamps of its file; None where a device counted its ticks.

    Parameters
    ----------
    hello : mapping or None
        What the session stored of its hello.
    placements : sequence of str
        Sensors wanted, in this order.
    """
    declaration = None if hello is None else Declaration.from_dict(hello)
    if declaration is None or not declaration.is_stamped:
        return None
    found = stamped(read_packets_in_order(source, session_id), declaration)
    return replace(found, sensors={name: found.sensors[name] for name in placements})


def ticks_of(recording: Recording, piece_ticks: int) -> Iterator[ImuChunk]:
    """Yield a recording on its common ticks, from tick 0 on, piece by piece."""
    chunk = to_common_ticks(recording, recording.nominal_rate_hz)
    if chunk.first_tick:
        yield _nothing_before(chunk)
    for first in range(0, chunk.tick_count, piece_ticks):
        yield chunk.ticks(first, min(first + piece_ticks, chunk.tick_count))


def _nothing_before(chunk: ImuChunk) -> ImuChunk:
    """Return the ticks from 0 on at which none of the sensors wanted had given anything yet."""
    shape = (chunk.sensor_count, chunk.first_tick, 3)
    nothing = np.full(shape, np.nan)
    missing = np.full(shape[:2], int(SampleQuality.MISSING), dtype=np.uint8)
    field = None if chunk.magnetometer_t is None else nothing
    return ImuChunk(0, chunk.time_step_s, nothing, nothing, field, missing)
