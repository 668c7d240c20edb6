"""Whether a drawn table is read right, refused, or read wrong in silence."""

import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app import readers
from app.errors import RecordingFormatError
from app.readers.tables.schemas import CsvMapping
from estimators.recording import Recording, SensorSignals
from tests.app.readers.odd_draws.drawn import Draw
from tests.app.readers.odd_draws.motion import Sensor
from tests.said import codes

RIGHT, REFUSED, WRONG = "right", "refused", "wrong"
_MOST_OFF = 0.01
_MOST_OFF_OF_PACKETS = 0.05
"""Which sample of a packet was lost nobody knows."""
_NEAR, _FAR = 1.2, 3.1
"""In steps: how near a sample that is read must be to one of the table, and how far from all it was made up."""


@dataclass
class Verdict:
    """What came of a table: the kind, and why."""

    kind: str
    why: str = ""


def judge(draw: Draw) -> Verdict:
    """Read a table as `telemotion process --guess` does and compare it with what was drawn."""
    name = "table.csv"
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_bytes(draw.content)
            start, later = readers.start_of(path), readers.later_of(path)
            found = readers.preview_text(name, start, None, draw.said_hz, later).guess
            if found is None:
                return Verdict(WRONG, "taken for another format")
            if found.missing:
                return Verdict(REFUSED, f"missing {codes(found.missing)}")
            mapping = _turned(found.mapping, draw.turned)
            recording = readers.read(path, "csv", CsvMapping.model_validate(mapping))
    except RecordingFormatError as error:
        return Verdict(REFUSED, f"{codes(error.message)}")
    said = [*codes(found.notes), *codes(recording.notes)]
    why = _wrong(draw, recording, said)
    return Verdict(WRONG, f"{why}; said {dict(Counter(said))}") if why else Verdict(RIGHT)


def _turned(mapping: dict[str, Any], turned: str) -> dict[str, Any]:
    """Return a mapping in which a person turned the sign of the accelerometer."""
    change = {
        "": lambda one: {},
        "sign": lambda one: {"sign": -1},
        "names": lambda one: {"columns": [f"-{column}" for column in one["columns"]]},
    }[turned]
    signals = [
        {**one, **(change(one) if one["quantity"] == "accelerometer" else {})} for one in mapping["signals"]
    ]
    return {**mapping, "signals": signals}


def _wrong(draw: Draw, recording: Recording, said: list[str]) -> str:
    """Return what of a recording is not as it was drawn; empty when it is."""
    if len(recording.sensors) != len(draw.sensors):
        return f"{len(recording.sensors)} sensors of {len(draw.sensors)}"
    rate = recording.nominal_rate_hz
    if abs(rate / draw.rate_hz - 1.0) > _MOST_OFF:
        return f"{rate:.2f} Hz of {draw.rate_hz:.2f}"
    first_s = min(
        float(one.signals["gyroscope"].time_s[one.signals["gyroscope"].there][0]) for one in draw.sensors
    )
    left = dict(recording.sensors)
    for sensor in draw.sensors:
        told = {name: _unlike(sensor, signals, first_s, draw, said) for name, signals in left.items()}
        fitting = next((name for name, why in told.items() if not why), None)
        if fitting is None:
            likely = min(told, key=lambda name: len(told[name]))
            return f"{sensor.name}: {told[likely]}"
        del left[fitting]
    return ""


def _unlike(sensor: Sensor, read: SensorSignals, first_s: float, draw: Draw, said: list[str]) -> str:
    fields = {
        "gyroscope": (read.gyroscope_radps, 1.0),
        "accelerometer": (read.accelerometer_mps2, 1.0),
        "magnetometer": (read.magnetometer_t, 1e6),
    }
    time_s = read.time_s + first_s
    for quantity, (values, factor) in fields.items():
        drawn = sensor.signals.get(quantity)
        if drawn is None or values is None:
            if (drawn is None) != (values is None) and "guess.left_out" not in said:
                return f"{quantity} lost"
            continue
        step_s = float(np.median(np.diff(drawn.time_s)))
        most = _MOST_OFF_OF_PACKETS if draw.kinds["clock"] == "bursts" else _MOST_OFF
        why = _differs(drawn.time_s, drawn.values, time_s, factor * values, most)
        if why and quantity == "gyroscope" and "guess.unit_assumed" in said:
            why = ""
        if why:
            return f"{quantity} {why}"
        there_s = drawn.time_s[drawn.there]
        # Where the gyroscope has a hole nothing can be joined to it.
        base = sensor.signals["gyroscope"]
        there_s = there_s[_nearest(there_s, base.time_s[base.there]) < _NEAR * step_s]
        finite = np.isfinite(values).all(axis=1)
        near = _nearest(there_s, time_s[finite])
        reach = max(step_s, 1.0 / draw.rate_hz)
        if (lost := float((near > _NEAR * reach).mean())) > 0.03:
            return f"{lost:.0%} of the samples of the {quantity} lost"
        made_up = _nearest(time_s[finite], drawn.time_s[drawn.there]) > _FAR * reach
        if made_up.mean() > 0.01:
            return f"{made_up.mean():.0%} of the samples of the {quantity} made up"
    return ""


def _nearest(at: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return how far the nearest of the others is, shape of `at`."""
    if not others.size:
        return np.full(at.size, np.inf)
    place = np.clip(np.searchsorted(others, at), 1, max(others.size - 1, 1))
    return np.minimum(np.abs(at - others[place - 1]), np.abs(at - others[min(others.size - 1, 1) and place]))


def _differs(time_s: np.ndarray, drawn: np.ndarray, at_s: np.ndarray, read: np.ndarray, most: float) -> str:
    """Compare each sample that was read with those that were measured within a step of its time."""
    finite = np.isfinite(read).all(axis=1)
    at_s, read = at_s[finite], read[finite]
    if not at_s.size:
        return "without samples"
    step_s = float(np.median(np.diff(time_s)))
    shares = []
    for shift_s in (0.0, -0.5 * step_s, 0.5 * step_s):
        place = np.searchsorted(time_s, at_s + shift_s)
        window = np.clip(place[:, None] + np.arange(-2, 2), 0, time_s.size - 1)
        low, high = drawn[window].min(axis=1), drawn[window].max(axis=1)
        margin = 1e-5 * np.abs(drawn).max() + 1e-9
        shares.append(float(((read < low - margin) | (read > high + margin)).any(axis=1).mean()))
    if min(shares) <= most:
        return ""
    size = np.median(np.linalg.norm(read, axis=1)) / np.median(np.linalg.norm(drawn, axis=1))
    return f"differs in {min(shares):.0%} of the samples (size {size:.3g})"
