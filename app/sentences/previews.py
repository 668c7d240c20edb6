"""English sentences of a table before it is read: what each sensor is taken for, and what that assumes."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "place.imu": "sensor",
    "unit.deg/s": "°/s",
    "unit.mdps": "m°/s",
    "unit.m/s^2": "m/s²",
    "unit.uT": "µT",
    "unit.us": "µs",
    "mapping.text_and_signal": "The mapping takes {columns:and} for numbers of a signal and for text; choose another"
    " column for one of them.",
    "guess.signal": "{quantity:quantity} in {unit:unit} ({columns})",
    "guess.signal_of_rows": "{quantity:quantity} in {unit:unit} ({columns}, in rows with {rows})",
    "guess.signal_without_unit": "{quantity:quantity} in an unknown unit ({columns})",
    "guess.sensor": "{where:place}: {signals:and}.",
    "guess.sensor_unread": "{where:place}: {signals:and}; its time is in the column {column}.",
    "guess.sensor_stamped": "{where:place}: {signals:and}; {rate_hz:number~4} samples a second by the column"
    " {column}.",
    "guess.sensor_stamped_in": "{where:place}: {signals:and}; {rate_hz:number~4} samples a second by the column"
    " {column}, in {unit:unit}.",
    "guess.sensor_of_day": "{where:place}: {signals:and}; {rate_hz:number~4} samples a second by the times of day in"
    " the column {column}.",
    "guess.sensor_counted": "{where:place}: {signals:and}; {rate_hz:number~4} samples a second, counted by the column"
    " {column}.",
    "guess.sensor_of_rows": "{where:place}: {signals:and}; {rate_hz:number~4} samples a second, one in each row.",
    "guess.units_from_numbers": "{quantity:quantity}: the columns of {count:number} sensors say no unit; their numbers"
    " are {unit:unit}.",
    "guess.units_assumed": "{quantity:quantity}: the columns of {count:number} sensors say no unit and their numbers"
    " none either; {unit:unit} is assumed.",
    "guess.time_unit_assumed": "The column {column} says no unit; by its steps it counts in {unit:unit}.",
    "guess.rate_of_line": "The rate of {rate_hz:number~4} samples a second stands in a line above the table.",
    "guess.turned": "{where:place}: the {quantity:quantity} is taken with the other sign, as you chose.",
    "guess.sign_assumed": "Without a magnetometer the signals do not show the sign of the accelerometer: at rest it is"
    " taken to point up, as most devices give it.",
    "guess.hemisphere_north": "It is taken as recorded north of the equator, where the magnetic field points down.",
    "guess.hemisphere_south": "It is taken as recorded south of the equator, where the magnetic field points up.",
    "guess.hemisphere_unknown": "Where it was recorded is not known: its magnetic field does not show a reversed"
    " accelerometer.",
}
