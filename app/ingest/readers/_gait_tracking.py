"""Walks of x-io's gait tracking set as CSV: one foot-mounted sensor, deg/s and g, real time stamps with gaps."""

from pathlib import Path
from typing import Final

import numpy as np

from app.errors import RecordingFormatError
from app.ingest.readers._csv import read_columns
from app.ingest.readers._time import nominal_rate, seconds_of
from app.ingest.readers._units import TO_SI, check_foot_accelerometer, check_foot_gyroscope, check_gyroscope
from app.sentences import say
from estimators.recording import Float, Recording, SensorSignals

_TIME: Final = "Time (s)"
_GYROSCOPE: Final = [f"Gyroscope {axis} (deg/s)" for axis in "XYZ"]
_ACCELEROMETER: Final = [f"Accelerometer {axis} (g)" for axis in "XYZ"]
COLUMNS: Final = (_TIME, *_GYROSCOPE, *_ACCELEROMETER)
"""Columns by which a file of this set is known."""
_REPEATED_S: Final = 1e-6
"""Packets that arrive together carry one stamp; the samples are all real and follow each other this closely."""


def read_gait_tracking(path: Path) -> Recording:
    """Read one walk.

    Returns
    -------
    Recording
        One sensor named `foot_right`; the files do not say which foot it was. The stamps are the device's own, and
        repeated ones are set a microsecond apart: resampling to an even grid spoils the track more than jitter.

    Raises
    ------
    RecordingFormatError
        Columns are missing, values are no numbers, time runs backwards, or a unit cannot be right.
    """
    table = read_columns(path, list(COLUMNS), ",")
    gyroscope = np.stack([table[name] for name in _GYROSCOPE], axis=1) * TO_SI["deg/s"]
    accelerometer = np.stack([table[name] for name in _ACCELEROMETER], axis=1) * TO_SI["g"]
    time_s = seconds_of(_apart(table[_TIME]), "s")
    for row in np.flatnonzero(~np.isfinite(gyroscope).all(axis=1) | ~np.isfinite(accelerometer).all(axis=1)):
        raise RecordingFormatError(say("file.row_incomplete", row=int(row + 2)), row=int(row + 2))
    check_gyroscope(gyroscope, "deg/s", "foot")
    check_foot_accelerometer(accelerometer, gyroscope, "g", "foot")
    check_foot_gyroscope(gyroscope, accelerometer, "deg/s", "foot")
    return Recording(
        {"foot_right": SensorSignals(time_s, gyroscope, accelerometer)},
        nominal_rate(time_s),
        origin="x-io gait tracking walk",
        metadata={"format": "gait_tracking", "walk": path.stem},
    )


def looks_like(path: Path) -> bool:
    """Return whether a CSV file has the columns of this set."""
    with path.open("rb") as file:
        line = file.readline(4096)
    names = {name.strip() for name in line.decode("utf-8", errors="replace").lstrip("\ufeff").split(",")}
    # Other recordings of these devices have more columns; those are no walks of this set.
    return set(COLUMNS) == names


def _apart(time_s: Float) -> Float:
    """Set samples with one and the same stamp apart; time that runs backwards is left for the check to find."""
    steps = np.diff(time_s)
    if not np.isfinite(time_s).all() or (steps < 0).any():
        return time_s
    # The length of each run of repeated stamps so far.
    repeated = np.concatenate([[False], steps == 0])
    count = np.arange(len(time_s))
    since = count - np.maximum.accumulate(np.where(repeated, 0, count))
    return np.asarray(time_s + _REPEATED_S * since)


__all__ = ["COLUMNS", "looks_like", "read_gait_tracking"]
