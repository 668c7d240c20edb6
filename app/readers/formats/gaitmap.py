"""Foot recordings of the gaitmap library as CSV: m/s^2 and deg/s, three shapes of header.

Both feet at 204.8 Hz with two header rows (sensor, axis), optionally beside motion capture of heel and toe markers and
a list of strides; or one foot of a patient at 102.4 Hz, known from the file's name.
"""

import csv
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.readers.contract import Reader, Source
from app.readers.tables.body import MAX_VALUES
from app.readers.units import TO_SI, check_accelerometer, check_foot_gyroscope, check_gyroscope
from estimators.conventions import SIDES
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say

AXES: Final = ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")
"""Names of the columns, in every file of this set."""
RATE_HZ: Final = 204.8
PATIENT_RATE_HZ: Final = 102.4
MOTION_CAPTURE_HZ: Final = 100.0
_MARKERS: Final = {"FCC": "heel", "TOE": "toe", "FM5": "outer_ball"}
_MILLIMETRE: Final = 1e-3
_BESIDE: Final = frozenset({"", "index", "sensor", "axis", "left_sensor", "right_sensor"})
_STRIDE: Final = ("start", "end", "ic", "tc")


def read_gaitmap(path: Path, name: str = "") -> Recording:
    """Read one file of sensor samples, and what lies beside it as truth.

    Parameters
    ----------
    name : str
        What the file was called before it was uploaded; by default its name.

    Returns
    -------
    Recording
        Sensors `foot_left` and `foot_right`, or the one that the file's name says. When `mocap_sample.csv` and
        `stride_events_sample.csv` lie in the same folder as `imu_sample.csv`, `reference` holds
        `motion_capture_time_s` (M,), `heel_left_m` (M, 3) and so on for toe and outer ball in a frame with z up, and
        `strides_left` (n, 4): start, end, initial contact and toe-off in samples.

    Raises
    ------
    RecordingFormatError
        Not a file of this set.
    """
    stem = Path(name or path.name).stem
    header, rows = _table(path)
    sensors, rate_hz = {}, RATE_HZ
    if len(header) == 2:
        for side in SIDES:
            columns = [_column(header, (f"{side}_sensor", axis)) for axis in AXES]
            sensors[f"foot_{side}"] = rows[:, columns]
    else:
        named = [side for side in SIDES if side in stem.lower()]
        if len(named) != 1:
            raise RecordingFormatError(say("gaitmap.side"))
        sensors[f"foot_{named[0]}"] = rows[:, [_column(header, (axis,)) for axis in AXES]]
        rate_hz = PATIENT_RATE_HZ
    time_s = np.arange(len(rows)) / rate_hz
    signals = {}
    for where, values in sensors.items():
        if not np.isfinite(values).all():
            raise RecordingFormatError(say("file.sensor_not_finite", where=where), sensor=where)
        gyroscope, accelerometer = values[:, 3:] * TO_SI["deg/s"], values[:, :3].copy()
        check_gyroscope(gyroscope, "deg/s", where)
        check_accelerometer(accelerometer, 1.0 / rate_hz, "m/s^2", where)
        check_foot_gyroscope(gyroscope, accelerometer, "deg/s", where)
        signals[where] = SensorSignals(time_s, gyroscope, accelerometer)
    return Recording(
        signals,
        rate_hz,
        origin=f"gaitmap foot recording, {rate_hz} Hz assumed: the file tells no time",
        metadata={"format": "gaitmap", "walk": stem, "assumed_rate_hz": str(rate_hz)},
        reference=_truth(path.parent) if path.name == "imu_sample.csv" else {},
    )


def _table(path: Path) -> tuple[list[list[str]], Float]:
    """Return the header rows, without the index column, and the numbers."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = list(csv.reader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise RecordingFormatError(say("table.unreadable")) from error
    count = next((i for i, line in enumerate(lines[:3]) if line and _is_number(line[0])), 0)
    if not 1 <= count <= 2 or len(lines) - count < 2:
        raise RecordingFormatError(say("gaitmap.header"))
    if (len(lines) - count) * len(lines[0]) > MAX_VALUES:
        raise RecordingFormatError(say("file.too_long"))
    try:
        rows = np.array(lines[count:], dtype=np.float64)
    except ValueError as error:
        raise RecordingFormatError(say("file.row_not_numbers")) from error
    header = lines[:count]
    if any(len(line) != rows.shape[1] for line in header):
        raise RecordingFormatError(say("table.ragged"))
    return [line[1:] for line in header], rows[:, 1:]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _column(header: list[list[str]], name: tuple[str, ...]) -> int:
    names = list(zip(*header, strict=True))
    if name not in names:
        raise RecordingFormatError(say("file.not_this_kind", missing=[" ".join(name)], kind="gaitmap"))
    return names.index(name)


def _truth(folder: Path) -> dict[str, NDArray[Any]]:
    markers, strides = folder / "mocap_sample.csv", folder / "stride_events_sample.csv"
    found: dict[str, NDArray[Any]] = {}
    if not (markers.is_file() and strides.is_file()):
        return found
    header, rows = _table(markers)
    found["motion_capture_time_s"] = np.arange(len(rows)) / MOTION_CAPTURE_HZ
    for side in SIDES:
        for short, name in _MARKERS.items():
            columns = [_column(header, (f"{side[0].upper()}_{short}", axis)) for axis in "xyz"]
            found[f"{name}_{side}_m"] = rows[:, columns] * _MILLIMETRE
    with strides.open(newline="", encoding="utf-8") as file:
        listed = list(csv.DictReader(file))
    try:
        for side in SIDES:
            chosen = [[float(row[name]) for name in _STRIDE] for row in listed if row["foot"] == side]
            found[f"strides_{side}"] = np.array(chosen).reshape(-1, len(_STRIDE))
    except (KeyError, TypeError, ValueError) as error:
        raise RecordingFormatError(say("gaitmap.strides", file=strides.name)) from error
    return found


class GaitmapReader(Reader):
    """Foot recordings of the gaitmap library."""

    title = "Walk with both feet (gaitmap, CSV)"
    description = "Sensors on both feet, as the gaitmap library writes them"
    endings = frozenset({".csv"})
    pipeline = "gait"
    placements = ("foot_left", "foot_right")

    def recognises(self, source: Source) -> bool:
        """By its columns, and a name that says a side where it must."""
        names = {
            name.strip() for line in source.first_lines for name in line.split(",") if not _is_number(name)
        }
        # Other tables name their columns so too; with a column of time, or more, they are none of this set.
        if not set(AXES) <= names or names - set(AXES) - _BESIDE:
            return False
        return {"left_sensor", "right_sensor"} <= names or any(side in source.stem.lower() for side in SIDES)

    def read(self, source: Source) -> Recording:
        """Read sensor samples, and what lies beside them as truth."""
        return read_gaitmap(source.path, source.name)
