"""Two instrumented shoes as one CSV: a column a channel, its sensor, quantity, axis and unit in the name.

`time_s`, then for instance `heel_left_gyroscope_x_radps`, `heel_left_accelerometer_z_mps2`, `heel_left_force_z_n`,
`forefoot_right_moment_y_nm`, `shank_left_gyroscope_x_radps`. Axes of foot and leg: x to the toes, y left, z up while
the foot is flat. Forces and moments are those of the ground on the cell, about its centre.
"""

import csv
from pathlib import Path
from typing import Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.contract import Reader, Source
from app.readers.tables.body import MAX_VALUES
from app.readers.tables.clocks.stamps import nominal_rate
from app.readers.units import check_accelerometer, check_foot_gyroscope, check_gyroscope
from estimators.conventions import GRAVITY_MPS2, SIDES
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say

_UNITS: Final = {"gyroscope": "radps", "accelerometer": "mps2", "force": "n", "moment": "nm"}
_INERTIAL: Final = ("gyroscope", "accelerometer")
_LOADS: Final = ("force", "moment")
_WEIGHTS_N: Final = (10.0 * GRAVITY_MPS2, 300.0 * GRAVITY_MPS2)
_EVEN_SHARE: Final = 0.01
_MARK: Final = "heel_left_force_z_n"


def read_instrumented_shoe(path: Path) -> Recording:
    """Read a walk on instrumented shoes.

    Returns
    -------
    Recording
        Sensors `heel_left`, `forefoot_left`, `heel_right`, `forefoot_right` with loads, and `shank_left` and
        `shank_right` where the file has them; time counts from the first sample.

    Raises
    ------
    RecordingFormatError
        Columns are missing, stamps are uneven, or the numbers cannot be newton, rad/s and m/s^2.
    """
    names, rows = _table(path)
    at = {name: column for column, name in enumerate(names)}
    if "time_s" not in at:
        raise RecordingFormatError(say("file.no_column", column="time_s"))
    time_s = rows[:, at["time_s"]] - rows[0, at["time_s"]]
    steps = np.diff(time_s)
    if not (steps > 0.0).all() or np.ptp(steps) > _EVEN_SHARE * float(np.median(steps)):
        raise RecordingFormatError(say("file.uneven"))
    sensors: dict[str, SensorSignals] = {}
    for side in SIDES:
        for part in ("heel", "forefoot", "shank"):
            quantities = _INERTIAL if part == "shank" else (*_INERTIAL, *_LOADS)
            wanted = {q: [f"{part}_{side}_{q}_{axis}_{_UNITS[q]}" for axis in "xyz"] for q in quantities}
            missing = [name for group in wanted.values() for name in group if name not in at]
            if part == "shank" and len(missing) == 6:
                continue
            if missing:
                raise RecordingFormatError(say("file.no_column", column=missing[0]))
            found = {q: np.ascontiguousarray(rows[:, [at[n] for n in group]]) for q, group in wanted.items()}
            name = f"{part}_{side}"
            check_gyroscope(found["gyroscope"], "rad/s", name)
            check_accelerometer(found["accelerometer"], 1.0 / nominal_rate(time_s), "m/s^2", name)
            check_foot_gyroscope(found["gyroscope"], found["accelerometer"], "rad/s", name)
            sensors[name] = SensorSignals(
                time_s,
                found["gyroscope"],
                found["accelerometer"],
                None,
                found.get("force"),
                found.get("moment"),
            )
    _check_weight(sensors)
    return Recording(
        sensors,
        nominal_rate(time_s),
        origin="instrumented shoes",
        metadata={"format": "instrumented_shoe"},
    )


def write_instrumented_shoe(recording: Recording, path: Path) -> None:
    """Write a walk as `read_instrumented_shoe` reads it.

    Parameters
    ----------
    recording : Recording
        With shoe sensors on one time base; others are left out.
    """
    names, columns = ["time_s"], [recording.sensors["heel_left"].time_s]
    for side in SIDES:
        for part in ("heel", "forefoot", "shank"):
            sensor = recording.sensors.get(f"{part}_{side}")
            if sensor is None:
                continue
            values = {
                "gyroscope": sensor.gyroscope_radps,
                "accelerometer": sensor.accelerometer_mps2,
                "force": sensor.force_n,
                "moment": sensor.moment_nm,
            }
            for quantity, table in values.items():
                if table is not None:
                    names += [f"{part}_{side}_{quantity}_{axis}_{_UNITS[quantity]}" for axis in "xyz"]
                    columns += list(table.T)
    np.savetxt(
        path, np.stack(columns, axis=1), delimiter=",", header=",".join(names), comments="", fmt="%.7g"
    )


def _table(path: Path) -> tuple[list[str], Float]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            names = [name.strip() for name in next(csv.reader(file), [])]
            rows = np.loadtxt(file, delimiter=",", ndmin=2)
    except (UnicodeDecodeError, csv.Error, ValueError) as error:
        raise RecordingFormatError(say("file.header_then_numbers")) from error
    if len(rows) < 2 or rows.shape[1] != len(names):
        raise RecordingFormatError(say("file.rows_and_header"))
    if rows.size > MAX_VALUES:
        raise RecordingFormatError(say("file.too_long"))
    if not np.isfinite(rows).all():
        raise RecordingFormatError(say("file.not_finite"))
    return names, rows


def _check_weight(sensors: dict[str, SensorSignals]) -> None:
    """Refuse loads that cannot be the weight of a person in newton."""
    felt = np.zeros(len(sensors["heel_left"].time_s))
    for sensor in sensors.values():
        if sensor.force_n is not None:
            felt += sensor.force_n[:, 2]
    weight = float(np.median(felt))
    if not _WEIGHTS_N[0] <= weight <= _WEIGHTS_N[1]:
        raise RecordingFormatError(
            say("shoe.weight", weight_n=weight, least_n=_WEIGHTS_N[0], most_n=_WEIGHTS_N[1])
        )


class InstrumentedShoeReader(Reader):
    """A walk on two instrumented shoes."""

    title = "Walk on instrumented shoes (CSV)"
    description = "Inertial sensors and load cells under heel and forefoot"
    endings = frozenset({".csv"})
    pipeline = "gait"
    placements = ("foot_left", "foot_right")

    def recognises(self, source: Source) -> bool:
        """By the column of a load cell."""
        return _MARK in source.first_lines[0]

    def read(self, source: Source) -> Recording:
        """Read one walk."""
        return read_instrumented_shoe(source.path)
