"""Recordings of APDM sensors as CSV: a column a channel, the sensor's label, quantity, axis and unit in its name.

Four rows stand above the numbers: the test's name, the sample rate, names (`Lumbar/Angular Velocity/X`) and units.
"""

import re
from pathlib import Path
from typing import Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.contract import TEXT, Reader, Source
from app.readers.moments import as_metadata
from app.readers.tables.clocks.stamps import UNIT_FACTORS, nominal_rate
from app.readers.tables.head import TableHead, head_of_file
from app.readers.units import TO_SI, UNITS, check_accelerometer, check_gyroscope, check_magnetometer
from estimators.conventions import Placement
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say

_CHANNEL: Final = re.compile(
    r"(?P<label>.+)/(?P<quantity>Acceleration|Angular Velocity|Magnetic Field|Temperature)"
    r"/(?P<axis>[XYZ]|Scalar) (?P<unit>.+)"
)
_CELSIUS: Final = frozenset({"deg C", "°C", "C"})
_MARK: Final = b"/Angular Velocity/X"
_PARTS: Final[dict[str, str]] = {
    "upper arm": "upper_arm",
    "wrist": "forearm",
    "lower arm": "forearm",
    "hand": "hand",
    "thigh": "thigh",
    "upper leg": "thigh",
    "shank": "shank",
    "lower leg": "shank",
    "foot": "foot",
}
PLACEMENT_OF: Final[dict[str, Placement]] = {
    "lumbar": "pelvis",
    "sternum": "sternum",
    "head": "head",
    "forehead": "head",
}
"""By the label that the maker's software gives a sensor, without its side; another label is a single sensor's name."""


class ApdmReader(Reader):
    """What APDM's software exports."""

    title = "APDM sensors (CSV)"
    description = "Sensors named by where they are worn, as APDM's software writes them"
    endings = TEXT
    asks_pipeline = True

    def recognises(self, source: Source) -> bool:
        """By the names of its columns."""
        return source.first_lines != ("", "") and _MARK in source.start

    def read(self, source: Source) -> Recording:
        """Read all sensors of one recording."""
        return read_apdm(source.path)

    def announces(self, source: Source) -> tuple[tuple[str, ...], float]:
        """Return the sensors that the names of the columns say."""
        names = [_name_of(match["label"]) for match in _channels(head_of_file(source.path, ",")).values()]
        return tuple(dict.fromkeys(names)), 100.0


def read_apdm(path: Path) -> Recording:
    """Read one recording.

    Returns
    -------
    Recording
        A sensor a label: its placement where the maker's software names one (`Left Foot`, `Lumbar`), else the label.
        With magnetometers and temperature where the file has them; the stamps are the file's own.

    Raises
    ------
    RecordingFormatError
        Columns are missing, values are no numbers, time does not advance, or a unit cannot be right.
    """
    from app.readers.tables.body import read_table
    from app.readers.tables.clocks.mended import mended

    head = head_of_file(path, ",")
    time = next((name for name in head.columns if name.partition(" ")[0] == "Time"), None)
    found = _channels(head)
    if time is None or not found:
        raise RecordingFormatError(say("file.no_column", column="Time"))
    factor = UNIT_FACTORS.get(time.partition(" ")[2])
    if factor is None:
        raise RecordingFormatError(say("file.no_column", column="Time s"))
    table, notes = read_table(path, [time, *found], head)
    values = np.stack([table[name] for name in found], axis=1)
    stamps = mended(table[time], factor, values)
    columns = dict(zip(found, values[stamps.rows].T, strict=True))
    rate_hz = nominal_rate(stamps.time_s)
    sensors: dict[str, SensorSignals] = {}
    for label in dict.fromkeys(match["label"] for match in found.values()):
        name = _name_of(label)
        # Two labels of one placement: the second is a single sensor's name.
        name = label if name in sensors else name
        sensors[name] = _sensor(label, columns, stamps.time_s, rate_hz)
    about = {"format": "apdm", **as_metadata(float(table[time][0]) * factor)}
    return Recording(sensors, rate_hz, origin="APDM recording", metadata=about, notes=(*notes, *stamps.notes))


def _channels(head: TableHead) -> dict[str, re.Match[str]]:
    return {name: match for name in head.columns if (match := _CHANNEL.fullmatch(name))}


def _name_of(label: str) -> str:
    words = label.strip().lower()
    side, _, part = words.partition(" ")
    if side in ("left", "right") and part in _PARTS:
        return f"{_PARTS[part]}_{side}"
    return PLACEMENT_OF.get(words, words.replace(" ", "_"))


def _sensor(label: str, columns: dict[str, Float], time_s: Float, rate_hz: float) -> SensorSignals:
    found: dict[tuple[str, str], tuple[Float, str]] = {}
    for name, values in columns.items():
        match = _CHANNEL.fullmatch(name)
        if match and match["label"] == label:
            found[match["quantity"], match["axis"]] = values, match["unit"]

    def triple(name: str, quantity: str) -> tuple[Float, str]:
        wanted = [f"{label}/{name}/{axis}" for axis in "XYZ"]
        for axis, column in zip("XYZ", wanted, strict=True):
            if (name, axis) not in found:
                raise RecordingFormatError(say("file.no_column", column=column), sensor=label)
        for unit in (found[name, axis][1] for axis in "XYZ"):
            if unit not in UNITS[quantity]:
                raise RecordingFormatError(
                    say(
                        "mapping.unit",
                        unit=unit,
                        quantity=quantity,
                        columns=wanted,
                        units=list(UNITS[quantity]),
                    ),
                    sensor=label,
                )
        axes = [values * TO_SI[unit] for values, unit in (found[name, axis] for axis in "XYZ")]
        return np.stack(axes, axis=1), found[name, "X"][1]

    gyroscope, turned = triple("Angular Velocity", "gyroscope")
    accelerometer, forced = triple("Acceleration", "accelerometer")
    check_gyroscope(gyroscope, turned, label)
    check_accelerometer(accelerometer, 1.0 / rate_hz, forced, label)
    field = None
    if ("Magnetic Field", "X") in found:
        field, unit = triple("Magnetic Field", "magnetometer")
        check_magnetometer(field, unit, label)
    temperature, unit = found.get(("Temperature", "Scalar"), (None, ""))
    if temperature is not None and unit not in _CELSIUS:
        raise RecordingFormatError(
            say("file.no_column", column=f"{label}/Temperature/Scalar deg C"), sensor=label
        )
    return SensorSignals(time_s, gyroscope, accelerometer, field, temperature_degc=temperature)
