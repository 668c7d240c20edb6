"""Recordings at more samples a second than are estimated are averaged down, at fewer are filled up; both is said."""

import math
from dataclasses import replace
from typing import Any, Final

import numpy as np

from estimators.channels import CHANNELS
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say

MOST_HZ: Final = 1000.0
"""What sessions and packets hold; movement of people has nothing above it."""
LEAST_HZ: Final = 10.0
"""What the filters need: below it a sensor turns and turns back between two samples."""
_FILLED_HZ: Final = 20.0
_LONGEST: Final = 1.5
"""In intervals: across longer ones nothing is filled."""


def slower(recording: Recording) -> Recording:
    """Return a recording at a rate that is estimated.

    Above `MOST_HZ` it is the means of consecutive samples, which leave no alias behind; below `LEAST_HZ` the samples
    and, on the lines between them, as many more as `_FILLED_HZ` takes.

    Parameters
    ----------
    recording : Recording
        Its sensors share their stamps.
    """
    if recording.nominal_rate_hz < LEAST_HZ:
        return _filled(recording)
    count = math.ceil(recording.nominal_rate_hz / MOST_HZ - 1e-9)
    if count < 2:
        return recording
    rate_hz = recording.nominal_rate_hz / count
    note = say("file.averaged_down", from_hz=recording.nominal_rate_hz, rate_hz=rate_hz, count=count)
    sensors = {name: _means(one, count, recording.nominal_rate_hz) for name, one in recording.sensors.items()}
    return replace(recording, sensors=sensors, nominal_rate_hz=rate_hz, notes=(*recording.notes, note))


def _filled(recording: Recording) -> Recording:
    count = math.ceil(_FILLED_HZ / recording.nominal_rate_hz)
    note = say("file.slow", rate_hz=recording.nominal_rate_hz, least_hz=LEAST_HZ)
    sensors = {name: _on_lines(one, count) for name, one in recording.sensors.items()}
    rate_hz = count * recording.nominal_rate_hz
    return replace(recording, sensors=sensors, nominal_rate_hz=rate_hz, notes=(*recording.notes, note))


def _on_lines(signals: SensorSignals, count: int) -> SensorSignals:
    """Return the samples and those between neighbours, on the line through both."""
    steps = np.diff(signals.time_s)
    begins = np.flatnonzero(steps < _LONGEST * float(np.median(steps)))
    share = np.arange(1, count) / count
    time_s = (signals.time_s[begins, None] + steps[begins, None] * share).ravel()
    order = np.argsort(np.concatenate([signals.time_s, time_s]), kind="stable")

    def filled(values: Float) -> Float:
        along = share[None, :, *[None] * (values.ndim - 1)]
        between = (1.0 - along) * values[begins, None] + along * values[begins + 1, None]
        return np.asarray(np.concatenate([values, between.reshape(-1, *values.shape[1:])])[order])

    measured = {spec.field: getattr(signals, spec.field, None) for spec in CHANNELS}
    found: dict[str, Any] = {
        field: filled(values) for field, values in measured.items() if values is not None
    }
    return replace(signals, time_s=filled(signals.time_s), **found)


def _means(signals: SensorSignals, count: int, rate_hz: float) -> SensorSignals:
    """Return the means over even stretches of time, where more than half of their samples are there."""
    place = np.floor((signals.time_s - signals.time_s[0]) * rate_hz / count + 1e-3).astype(np.int64)
    starts = np.flatnonzero(np.append(True, np.diff(place) > 0))
    # Of fewer the mean would be no mean.
    whole = 2 * np.diff(np.append(starts, place.size)) > count

    def mean(values: Float) -> Float:
        there = np.isfinite(values)
        total = np.add.reduceat(np.where(there, values, 0.0), starts, axis=0)
        number = np.add.reduceat(there.astype(np.float64), starts, axis=0)
        return np.asarray(np.where(number > 0.0, total / np.maximum(number, 1.0), np.nan)[whole])

    measured = {spec.field: getattr(signals, spec.field, None) for spec in CHANNELS}
    means: dict[str, Any] = {field: mean(values) for field, values in measured.items() if values is not None}
    return replace(signals, time_s=mean(signals.time_s), **means)
