"""Walks of the PyShoe motion-capture set as `.mat` files: one foot-mounted sensor and its optical track on the floor.

The files hold accelerometer (m/s^2) and gyroscope (rad/s) in one table, sensor z axis down, and the optical track in
a plane with x and y to the right of it; mirrored here into the product's frame, whose z points up.
"""

from pathlib import Path
from typing import Any, Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.contract import Reader, Source
from app.readers.mat import load_mat
from app.readers.tables.clocks.stamps import nominal_rate, seconds_of
from app.readers.units import check_accelerometer, check_foot_gyroscope, check_gyroscope
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say

MARKS: Final = ("imu_data", "timestamps_all")
"""Variables by which a walk of this set is known."""
GYROSCOPE_CLIP_RADPS: Final = 9.09
"""The set's gyroscopes clip at 9.1 to 9.7 rad/s; 1 % below the filter takes a sample for clipped."""
_MIRROR: Final = np.array([1.0, -1.0])


def read_pyshoe(path: Path) -> Recording:
    """Read one walk.

    Returns
    -------
    Recording
        One sensor named `foot_right`; the files do not say which foot it was. `metadata` has the device's clip
        level; `reference` holds `position_xy_m` (N, 2), the optical track in a frame with z up whose origin and
        heading are its own.

    Raises
    ------
    RecordingFormatError
        Not a walk of this set.
    """
    content = load_mat(path, [*MARKS, "gt"])
    missing = [name for name in MARKS if name not in content]
    if missing:
        raise RecordingFormatError(say("file.not_this_kind", missing=missing, kind="pyshoe"))
    time_s = seconds_of(_numbers(content["timestamps_all"], None).reshape(-1), "s", first_row=1)
    samples = _numbers(content["imu_data"], 6)
    if len(samples) != len(time_s):
        raise RecordingFormatError(say("file.samples_and_times", samples=len(samples), times=len(time_s)))
    accelerometer, gyroscope = samples[:, :3].copy(), samples[:, 3:].copy()
    check_gyroscope(gyroscope, "rad/s", "imu_data")
    check_accelerometer(accelerometer, 1.0 / nominal_rate(time_s), "m/s^2", "imu_data")
    check_foot_gyroscope(gyroscope, accelerometer, "rad/s", "imu_data")
    reference = {}
    if "gt" in content:
        track = _numbers(content["gt"], 2)
        if len(track) != len(time_s):
            raise RecordingFormatError(say("file.array_lengths"))
        reference["position_xy_m"] = track * _MIRROR
    return Recording(
        {"foot_right": SensorSignals(time_s, gyroscope, accelerometer)},
        nominal_rate(time_s),
        origin="PyShoe motion-capture walk",
        metadata={"format": "pyshoe", "walk": path.stem, "gyroscope_clip_radps": str(GYROSCOPE_CLIP_RADPS)},
        reference=reference,
    )


def _numbers(values: Any, width: int | None) -> Float:
    try:
        table = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordingFormatError(say("file.arrays_not_numbers")) from error
    if width is not None and (table.ndim != 2 or table.shape[1] != width):
        raise RecordingFormatError(say("file.array_shape", shape=str(table.shape), expected=f"(N, {width})"))
    return table


class PyShoeReader(Reader):
    """A walk of the PyShoe set."""

    title = "Walk with one foot sensor (PyShoe, .mat)"
    description = "One sensor on the right foot"
    endings = frozenset({".mat"})
    pipeline = "gait"
    placements = ("foot_left", "foot_right")

    def recognises(self, source: Source) -> bool:
        """By the names of its variables."""
        return set(MARKS) <= source.variables

    def read(self, source: Source) -> Recording:
        """Read one walk."""
        return read_pyshoe(source.path)
