"""Walks of x-io's gait tracking set as CSV: one foot-mounted sensor, deg/s and g, real time stamps with gaps."""

from pathlib import Path
from typing import Final

import numpy as np

from app.errors import RecordingFormatError
from app.ingest.readers._csv import read_columns
from app.ingest.readers._time import nominal_rate
from app.ingest.readers._time_mended import mended
from app.ingest.readers._units import TO_SI, check_accelerometer, check_foot_gyroscope, check_gyroscope
from app.sentences import say
from estimators.recording import Recording, SensorSignals

_TIME: Final = "Time (s)"
_GYROSCOPE: Final = [f"Gyroscope {axis} (deg/s)" for axis in "XYZ"]
_ACCELEROMETER: Final = [f"Accelerometer {axis} (g)" for axis in "XYZ"]
COLUMNS: Final = (_TIME, *_GYROSCOPE, *_ACCELEROMETER)
"""Columns by which a file of this set is known."""


def read_gait_tracking(path: Path) -> Recording:
    """Read one walk.

    Returns
    -------
    Recording
        One sensor named `foot_right`; the files do not say which foot it was. The stamps are the device's own, mended
        where they repeat or step back: resampling to an even grid spoils the track more than jitter.

    Raises
    ------
    RecordingFormatError
        Columns are missing, values are no numbers, time does not advance, or a unit cannot be right.
    """
    table = read_columns(path, list(COLUMNS), ",")
    values = np.stack([table[name] for name in (*_GYROSCOPE, *_ACCELEROMETER)], axis=1)
    time = mended(table[_TIME], 1.0, values)
    time_s, values = time.time_s, values[time.rows]
    gyroscope, accelerometer = values[:, :3] * TO_SI["deg/s"], values[:, 3:] * TO_SI["g"]
    for row in np.flatnonzero(~np.isfinite(gyroscope).all(axis=1) | ~np.isfinite(accelerometer).all(axis=1)):
        raise RecordingFormatError(say("file.row_incomplete", row=int(row + 2)), row=int(row + 2))
    check_gyroscope(gyroscope, "deg/s", "foot")
    check_accelerometer(accelerometer, 1.0 / nominal_rate(time_s), "g", "foot")
    check_foot_gyroscope(gyroscope, accelerometer, "deg/s", "foot")
    return Recording(
        {"foot_right": SensorSignals(time_s, gyroscope, accelerometer)},
        nominal_rate(time_s),
        origin="x-io gait tracking walk",
        metadata={"format": "gait_tracking", "walk": path.stem},
        notes=time.notes,
    )


def looks_like(_stem: str, start: bytes) -> bool:
    """Return whether the beginning of a CSV file has the columns of this set."""
    line = start[:4096].partition(b"\n")[0].decode("utf-8", errors="replace")
    names = {name.strip() for name in line.lstrip("\ufeff").split(",")}
    # Other recordings of these devices have more columns; those are no walks of this set.
    return set(COLUMNS) == names


__all__ = ["COLUMNS", "looks_like", "read_gait_tracking"]
