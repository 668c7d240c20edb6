"""Signals of instrumented shoes as the bytes in which a session stores them."""

import io
from typing import Any, Final

import numpy as np

from estimators.recording import Recording, SensorSignals

_FIELDS: Final = ("gyroscope_radps", "accelerometer_mps2", "force_n", "moment_nm")


def as_stored(recording: Recording) -> Recording:
    """Return the shoes' signals as a session that stores them gives them: numbers of 32 bits."""
    return unpacked(packed(recording), recording.nominal_rate_hz)


def packed(recording: Recording) -> bytes:
    """Return the signals of sensors on one time base as they are stored: numbers of 32 bits."""
    arrays: dict[str, Any] = {}
    for name, sensor in recording.sensors.items():
        arrays["time_s"] = sensor.time_s
        for field in _FIELDS:
            values = getattr(sensor, field)
            if values is not None:
                arrays[f"{name}.{field}"] = values.astype(np.float32)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def unpacked(data: bytes, rate_hz: float) -> Recording:
    """Return the recording that was packed."""
    with np.load(io.BytesIO(data), allow_pickle=False) as content:
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
    return Recording(sensors, rate_hz, origin="session")
