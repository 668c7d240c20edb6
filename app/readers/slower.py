"""Recordings at more samples a second than are estimated: averaged down, and said."""

import math
from dataclasses import replace
from typing import Any, Final

import numpy as np

from app.sentences import say
from estimators.channels import CHANNELS
from estimators.recording import Float, Recording, SensorSignals

MOST_HZ: Final = 1000.0
"""What sessions and packets hold; movement of people has nothing above it."""


def slower(recording: Recording) -> Recording:
    """Return a recording at no more than `MOST_HZ`: means of consecutive samples, which leave no alias behind.

    Parameters
    ----------
    recording : Recording
        Its sensors share their stamps.
    """
    count = math.ceil(recording.nominal_rate_hz / MOST_HZ - 1e-9)
    if count < 2:
        return recording
    rate_hz = recording.nominal_rate_hz / count
    note = say("file.averaged_down", from_hz=recording.nominal_rate_hz, rate_hz=rate_hz, count=count)
    sensors = {name: _means(one, count, recording.nominal_rate_hz) for name, one in recording.sensors.items()}
    return replace(recording, sensors=sensors, nominal_rate_hz=rate_hz, notes=(*recording.notes, note))


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


__all__ = ["MOST_HZ", "slower"]
