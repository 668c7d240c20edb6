"""Walks of x-io's gait tracking set as CSV: one foot-mounted sensor, deg/s and g, real time stamps with gaps."""

from pathlib import Path
from typing import Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.contract import Reader, Source
from app.readers.tables.body import read_columns
from app.readers.tables.clocks.mended import mended
from app.readers.tables.clocks.stamps import nominal_rate
from app.readers.units import TO_SI, check_accelerometer, check_foot_gyroscope, check_gyroscope
from estimators.recording import Recording, SensorSignals
from estimators.sentences import say

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


class GaitTrackingReader(Reader):
    """A walk of x-io's gait tracking set."""

    title = "Walk with one foot sensor (x-io, CSV)"
    description = "One sensor on a foot, as the Gait-Tracking set writes it"
    endings = frozenset({".csv"})
    pipeline = "gait"
    placements = ("foot_left", "foot_right")

    def recognises(self, source: Source) -> bool:
        """By its columns: other recordings of these devices have more and are no walks of this set."""
        return set(COLUMNS) == {name.strip() for name in source.first_lines[0].split(",")}

    def read(self, source: Source) -> Recording:
        """Read one walk."""
        return read_gait_tracking(source.path)
