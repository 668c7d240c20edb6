"""Findings about readings in words for a person who wears the sensor and has no table to correct."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final

from estimators.calibration import Finding
from estimators.sentences import Sentence, say

_OF_DEVICE: Final = {
    "readings.force_off",
    "readings.force_unknown",
    "readings.force_without_gravity",
    "readings.field_normalised",
}
"""Remedies that are the device's as they are."""


def in_live_words(found: Finding) -> Finding:
    """Return a finding whose message advises what can be done about a live sensor.

    Parameters
    ----------
    found : Finding
        As `RecordingCheck` words it: for a table, whose units and axes are declared by who reads this.
    """
    parameters = found.message.parameters
    remedy = parameters.get("remedy")
    if isinstance(remedy, Sentence) and remedy.code in _OF_DEVICE:
        return found
    worded = _WORDS.get(found.message.code)
    return found if worded is None else replace(found, message=worded(parameters))


def _axes(of: Mapping[str, Any]) -> Sentence:
    return say("readings.live_sensor_axes", where=of["where"], mapping=of["mapping"])


def _amiss(of: Mapping[str, Any]) -> Sentence:
    return say("readings.live_sensor_amiss", where=of["where"])


def _rate_unit(of: Mapping[str, Any]) -> Sentence:
    return say("readings.live_gyroscope_unit", where=of["where"])


_WORDS: Final[dict[str, Callable[[Mapping[str, Any]], Sentence]]] = {
    "readings.gyroscope_against_others": _axes,
    "readings.accelerometer_against_others": _axes,
    "readings.gyroscope_against_accelerometer": _axes,
    "readings.axes_apart": _axes,
    "readings.field_axes_apart": _axes,
    "readings.gyroscope_against_magnetometer": _axes,
    "readings.magnetometer_against_gyroscope": _axes,
    "readings.axes_in_doubt": _amiss,
    "readings.axes_in_doubt_six": _amiss,
    "readings.axes_unclear": _amiss,
    "readings.unexplained": _amiss,
    "readings.gyroscope_in_degrees": _rate_unit,
    "readings.gyroscope_twice": _rate_unit,
    "readings.gyroscope_scale": _rate_unit,
    "readings.gyroscope_pace": lambda of: say(
        "readings.live_gyroscope_pace", where=of["where"], factor=of["factor"]
    ),
    "readings.gyroscope_restless": lambda of: say(
        "readings.live_gyroscope_restless", where=of["where"], rate_radps=of["rate_radps"]
    ),
    "readings.accelerometer_unit": lambda of: say("readings.live_accelerometer_unit", where=of["where"]),
    "readings.magnetometer_unit": lambda of: say("readings.live_magnetometer_unit", where=of["where"]),
    "readings.field_up": lambda of: say(
        "readings.live_field_up", where=of["where"], angle_rad=of["angle_rad"]
    ),
    "readings.field_down": lambda of: say(
        "readings.live_field_down", where=of["where"], angle_rad=of["angle_rad"]
    ),
}
