"""Signals of instrumented shoes, kept with the session as one row: packets have no place for forces."""

import io
import zlib
from typing import Any, Final

import numpy as np
from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from app.recordings._rows import insert_chunk
from app.recordings.chunks import EncodedChunk
from app.recordings.codecs import DamagedChunkError, checksum
from app.recordings.models import SignalChunk
from estimators.recording import Recording, SensorSignals

SHOES_STREAM: Final = "shoes"
_CODEC: Final = "npz.zlib"
_FIELDS: Final = ("gyroscope_radps", "accelerometer_mps2", "force_n", "moment_nm")


def store_shoes(session: Session, session_id: str, recording: Recording) -> None:
    """Keep the shoes' signals; an earlier attempt is replaced.

    Parameters
    ----------
    session : Session
    session_id : str
    recording : Recording
        Sensors on one time base, see `read_instrumented_shoe`.
    """
    arrays: dict[str, Any] = {}
    for name, sensor in recording.sensors.items():
        arrays["time_s"] = sensor.time_s
        for field in _FIELDS:
            values = getattr(sensor, field)
            if values is not None:
                arrays[f"{name}.{field}"] = values.astype(np.float32)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    data = zlib.compress(buffer.getvalue(), 6)
    session.execute(
        delete(SignalChunk).where(SignalChunk.session_id == session_id, SignalChunk.stream == SHOES_STREAM)
    )
    ticks = len(arrays["time_s"])
    scale = {"version": 1, "rate_hz": recording.nominal_rate_hz}
    insert_chunk(
        session, session_id, SHOES_STREAM, 0, EncodedChunk(0, ticks, _CODEC, scale, checksum(data), data)
    )


def load_shoes(session: Session, session_id: str) -> Recording | None:
    """Return the shoes' signals of a session; None where there are none."""
    row = session.scalar(
        select(SignalChunk).where(SignalChunk.session_id == session_id, SignalChunk.stream == SHOES_STREAM)
    )
    if row is None:
        return None
    if checksum(row.data) != row.crc:
        raise DamagedChunkError("stored signals of shoes have a wrong checksum; restore them from the backup")
    with np.load(io.BytesIO(zlib.decompress(row.data)), allow_pickle=False) as content:
        arrays = {name: np.asarray(content[name], dtype=np.float64) for name in content.files}
    time_s = arrays.pop("time_s")
    names = dict.fromkeys(name.partition(".")[0] for name in arrays)
    sensors = {
        name: SensorSignals(
            time_s,
            arrays[f"{name}.gyroscope_radps"],
            arrays[f"{name}.accelerometer_mps2"],
            None,
            arrays.get(f"{name}.force_n"),
            arrays.get(f"{name}.moment_nm"),
        )
        for name in names
    }
    return Recording(sensors, float(row.scale["rate_hz"]), origin="session")


__all__ = ["SHOES_STREAM", "load_shoes", "store_shoes"]
