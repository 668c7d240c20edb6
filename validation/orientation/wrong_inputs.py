"""Sound recordings turned wrong on purpose: what of it is named, and whether a sound one is doubted."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration import Finding, check_recording
from estimators.conventions import GRAVITY_MPS2
from estimators.orientation import create
from estimators.recording import Float, ImuChunk, Recording
from estimators.signals import to_common_ticks
from validation.protocol import Data, Figure, Protocol, Values

_WINDOW_S: Final = 6.0
_SHOWN_RAD: Final = np.radians(20.0)
_FEWEST_WINDOWS: Final = 3
_CUT_PERCENT: Final = 97.0
_SMALLEST_RANGE: Final = {"gyroscope": np.radians(125.0), "accelerometer": 2.0 * GRAVITY_MPS2}
"""No device ends below: what is cut off there is no case."""
_LEAST_CUT: Final = 0.01
"""Of the largest reading. What takes less cannot be distinguished from a calibration, and does no harm: of a sine about
one axis the level that 3 % exceed takes 0.4 %."""
_EVERY: Final = 3
"""Of the sensors of a whole body every third is taken: neighbours move alike."""
HALVES: Final = ("first", "second")

_FIELDS: Final = {
    "gyroscope": "gyroscope_radps",
    "accelerometer": "accelerometer_mps2",
    "magnetometer": "magnetometer_t",
}
_NAMED: Final = {
    "unit": {triad: {f"{triad}_unit"} for triad in _FIELDS},
    "axes": {
        "gyroscope": {"gyroscope_axes", "gyroscope_or_accelerometer_axes", "gyroscope_or_magnetometer_axes"},
        "accelerometer": {"accelerometer_axes", "gyroscope_or_accelerometer_axes"},
        "magnetometer": {"magnetometer_axes", "gyroscope_or_magnetometer_axes"},
    },
}
_SCALES: Final = {
    "57 times too large": 180.0 / np.pi,
    "57 times too small": np.pi / 180.0,
    "9.8 times too large": GRAVITY_MPS2,
    "a million times too large": 1e6,
    "a hundred times too large": 100.0,
}
_KINDS: Final = (
    *(f"{triad} {what}" for triad in _FIELDS for what in ("unit", "axes swapped", "axis reversed")),
    "all axes of one reversed",
    "gyroscope cut off",
    "accelerometer cut off",
)

Change = Callable[[Float], Float]


def _changes() -> Iterator[tuple[str, str, Change]]:
    """Yield kind, triad and how its readings are turned wrong."""
    eye = np.eye(3)
    for triad in _FIELDS:
        for factor in _SCALES.values():
            yield f"{triad} unit", triad, _mapped(factor * eye)
        for order in ([1, 0, 2], [2, 1, 0], [0, 2, 1]):
            yield f"{triad} axes swapped", triad, _mapped(eye[order])
        for axis in range(3):
            yield f"{triad} axis reversed", triad, _mapped(np.diag(np.where(np.arange(3) == axis, -1.0, 1.0)))
        # Gravity or a field that is reversed as a whole moves as it should.
        whole = "gyroscope axis reversed" if triad == "gyroscope" else "all axes of one reversed"
        yield whole, triad, _mapped(-eye)
    for triad in ("gyroscope", "accelerometer"):
        yield f"{triad} cut off", triad, _cut_off


def _mapped(matrix: Float) -> Change:
    def change(values: Float) -> Float:
        return np.asarray(values @ matrix.T)

    return change


def _cut_off(values: Float) -> Float:
    """Cut a triad off at a level, and calibrate it afterwards: the level differs by some thousandths."""
    level = np.nanpercentile(np.abs(values).max(axis=-1), _CUT_PERCENT)
    skew = np.eye(3) + 0.002 * np.random.default_rng(1).normal(size=(3, 3))
    return np.asarray(np.clip(values, -level, level) @ skew.T)


class _Movement:
    """How a sound recording moved, by motion capture where the recording has it, else by the published filter."""

    def __init__(self, recording: Recording, chunk: ImuChunk) -> None:
        truth = recording.reference.get("q_earth_sensor")
        if truth is None or len(truth) != chunk.tick_count:
            truth = create("vqf", 1, chunk.time_step_s).update(chunk).q_earth_sensor[0]
        self.rate, self.step_s = chunk.gyroscope_radps[0], chunk.time_step_s
        self.has_field = chunk.magnetometer_t is not None
        back = rotation.conjugate(truth)
        # Gravity and a field that dips by sixty degrees, in the sensor.
        self.directions = [rotation.rotate(back, np.array([0.0, 0.0, 1.0]))]
        if self.has_field:
            self.directions.append(rotation.rotate(back, np.array([0.0, 0.5, -np.sqrt(0.75)])))

    def shows(self, triad: str, change: Change) -> bool:
        """Return whether wrong readings and right ones disagree by more than 20 degrees in three windows or more."""
        length = round(_WINDOW_S / self.step_s)
        windows = len(self.rate) // length
        rate = (change(self.rate) if triad == "gyroscope" else self.rate)[: windows * length]
        steps = rotation.exp(np.nan_to_num(rate).reshape(windows, length, 3) * self.step_s)
        attitude = rotation.running_product(steps)
        is_shown = np.zeros(windows, dtype=np.bool_)
        for number, direction in enumerate(self.directions):
            seen = direction[: windows * length].reshape(windows, length, 3)
            if (triad, number) in (("accelerometer", 0), ("magnetometer", 1)):
                seen = change(seen)
            begun = rotation.rotate(attitude[:, :1], seen[:, :1])
            predicted = rotation.rotate(rotation.conjugate(attitude), begun)
            angle = np.arccos(np.clip(np.sum(predicted * seen, axis=2), -1.0, 1.0))
            # Where motion capture saw nothing the angle is none, and no window counts.
            is_shown |= np.sqrt(np.mean(angle**2, axis=1)) > _SHOWN_RAD
        return int(is_shown.sum()) >= _FEWEST_WINDOWS


def _with(chunk: ImuChunk, triad: str, values: Float) -> ImuChunk:
    if triad == "gyroscope":
        return replace(chunk, gyroscope_radps=values)
    if triad == "accelerometer":
        return replace(chunk, accelerometer_mps2=values)
    return replace(chunk, magnetometer_t=values)


def _is_shown(kind: str, triad: str, change: Change, movement: _Movement, chunk: ImuChunk) -> bool:
    if kind == "all axes of one reversed":
        # Gravity reversed and gravity move alike: only the dip of a field says which it is.
        return movement.has_field
    if "cut off" in kind:
        readings = chunk.gyroscope_radps if triad == "gyroscope" else chunk.accelerometer_mps2
        top, left = np.nanmax(np.abs(readings)), np.nanmax(np.abs(change(readings)))
        return bool(left > _SMALLEST_RANGE[triad] and left < (1.0 - _LEAST_CUT) * top)
    if kind.endswith("unit") and triad != "gyroscope":
        return True
    return movement.shows(triad, change)


def _is_named(kind: str, triad: str, found: Sequence[Finding]) -> bool:
    codes = {finding.code for finding in found}
    if kind == "all axes of one reversed":
        return "gravity_reversed" in codes
    if "cut off" in kind:
        return f"{triad}_clipped" in codes
    return bool(codes & _NAMED["unit" if kind.endswith("unit") else "axes"][triad])


def _measured(seeds: Sequence[int], data: Data) -> Values:
    named: dict[str, list[bool]] = defaultdict(list)
    hidden = 0
    refused: list[float] = []
    doubted: list[float] = []
    for number, (half, recording, chunk) in enumerate(_sensors(data)):
        found = check_recording(chunk, [str(number)])
        refused.append(float(any(finding.severity == "refuse" for finding in found)))
        doubted.append(float(any(f.code.endswith(("_unit", "_axes", "_reversed", "_dead")) for f in found)))
        movement = _Movement(recording, chunk)
        for kind, triad, change in _changes():
            values = getattr(chunk, _FIELDS[triad])
            if values is None:
                continue
            if not _is_shown(kind, triad, change, movement, chunk):
                hidden += 1
                continue
            wrong = _with(chunk, triad, change(values))
            named[f"{kind}, {half} half"].append(
                _is_named(kind, triad, check_recording(wrong, [str(number)]))
            )
    values = {
        f"{kind}, {half} half": np.array([_percent(named[f"{kind}, {half} half"])])
        for kind in _KINDS
        for half in HALVES
    }
    cases = sum(len(each) for each in named.values())
    return {
        **values,
        "sound recordings refused": np.array([100.0 * np.mean(refused)]),
        "sound recordings doubted": np.array([100.0 * np.mean(doubted)]),
        "cases that the movement shows": np.array([float(cases)]),
        "cases that it does not show": np.array([float(hidden)]),
    }


def _percent(cases: Sequence[bool]) -> float:
    """Return the share of cases that hold; NaN without any."""
    return 100.0 * float(np.mean(cases)) if cases else float("nan")


def _sensors(data: Data) -> Iterator[tuple[str, Recording, ImuChunk]]:
    """Yield half, recording and readings of each sensor."""
    for number, (_, recording) in enumerate(sorted(data.items())):
        names = list(recording.sensors)
        for name in names[:: _EVERY if len(names) > 4 else 1]:
            single = replace(recording, sensors={name: recording.sensors[name]})
            yield HALVES[number % 2], recording, to_common_ticks(single, recording.nominal_rate_hz)


WRONG_INPUTS = Protocol(
    name="wrong_inputs",
    title="Recordings turned wrong on purpose",
    source="every recording given; no published figure",
    what="Each sensor's readings are given in a wrong unit (57 and 9.8 times, a million, a hundred), with each pair of"
    " axes swapped, each axis reversed, or cut off at the level that 3 % of the samples exceed, one at a time. Shown is"
    " the share that is named with the right triad, of the cases that the movement shows: wrong and right readings put"
    " gravity or field more than 20 degrees apart in three windows of six seconds or more, by motion capture or the"
    " published filter on the sound recording; a cut-off takes more than 1 % of the largest reading. Recordings are"
    " halved in turn by name: a threshold that fits one half alone would show.",
    figures=(
        *(Figure(f"{kind}, {half} half", "%", 95.0, at_most=False) for kind in _KINDS for half in HALVES),
        Figure("sound recordings refused", "%", 0.0),
        Figure("sound recordings doubted", "%"),
        Figure("cases that the movement shows", "1"),
        Figure("cases that it does not show", "1"),
    ),
    measure=_measured,
    needs_data="sensor readings",
)
