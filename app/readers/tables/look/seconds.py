"""The first seconds of a table, read by its mapping from what the guess has seen of it."""

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.tables.body import check_present
from app.readers.tables.clocks.stamps import nominal_rate
from app.readers.tables.columns import TableSensors, checked_mapping, columns_of, with_times
from app.readers.tables.head import TableHead
from app.readers.tables.schemas import CsvColumn, CsvMapping
from app.readers.tables.units import Body
from app.readers.units import check_accelerometer, check_gyroscope, check_magnetometer
from estimators.recording import Float, SensorSignals
from estimators.sentences import Sentence

SHOWN_S: Final = 10.0
_NO_FIELD_T: Final = (1e-6, 2e-3)
"""A field within is that of the earth or of iron on the device, which only the whole recording tells apart."""
_NOT_YET: Final = "file.too_few_rows"


@dataclass(frozen=True)
class FirstSeconds:
    """The first seconds of a table.

    Attributes
    ----------
    sensors : dict of str to SensorSignals
        By place or name; zero is their first sample. Without those that have no sample yet.
    rates_hz : dict of str to float
        Of the same sensors.
    doubts : tuple of Sentence
        Why it cannot be read so, or cannot be right so.
    """

    sensors: dict[str, SensorSignals]
    rates_hz: dict[str, float]
    doubts: tuple[Sentence, ...] = ()


def first_seconds(head: TableHead, mapping: CsvMapping) -> FirstSeconds:
    """Read the beginning of a table."""
    try:
        by_place = checked_mapping(mapping)
        table = _table(head, mapping)
        # Several tables in a zip have no rows to show: theirs stand side by side, each on its own clock.
        reader = TableSensors(mapping, table, head, is_one_table=bool(head.rows))
    except RecordingFormatError as error:
        return FirstSeconds({}, {}, (_said(error),))
    sensors: dict[str, SensorSignals] = {}
    doubts: list[Sentence] = []
    for place, quantities in by_place.items():
        try:
            sensors[place] = reader.as_mapped(place, quantities)
        except RecordingFormatError as error:
            # Of a sensor whose rows come later nothing can be said.
            if _NOT_YET not in _codes(_said(error)):
                doubts.append(_said(error))
        else:
            doubts += _doubts(place, quantities, sensors[place])
    rates = {place: nominal_rate(one.time_s) for place, one in sensors.items()}
    start_s = min((float(one.time_s[0]) for one in sensors.values()), default=0.0)
    return FirstSeconds(
        {place: _first(one, start_s) for place, one in sensors.items()}, rates, tuple(dict.fromkeys(doubts))
    )


def _table(head: TableHead, mapping: CsvMapping) -> dict[str, Any]:
    wanted, text = columns_of(mapping, head)
    check_present(wanted, head)
    body = Body(head)
    table: dict[str, Any] = {
        name: np.array(body.texts(name), dtype=object) if name in text else body.numbers(name)[:, 0]
        for name in wanted
    }
    with_times(mapping, table, text)
    return table


def _first(signals: SensorSignals, start_s: float) -> SensorSignals:
    time_s = signals.time_s - start_s
    shown = time_s <= time_s[0] + SHOWN_S
    field_t = signals.magnetometer_t
    return replace(
        signals,
        time_s=time_s[shown],
        gyroscope_radps=signals.gyroscope_radps[shown],
        accelerometer_mps2=signals.accelerometer_mps2[shown],
        magnetometer_t=None if field_t is None else field_t[shown],
    )


def _doubts(place: str, quantities: dict[str, CsvColumn], signals: SensorSignals) -> list[Sentence]:
    """Return why readings of this size cannot be in their units; nothing of what the rest of a recording may settle."""
    step_s = float(np.median(np.diff(signals.time_s)))
    found: list[Sentence] = []
    for quantity, one in quantities.items():
        try:
            if quantity == "gyroscope":
                check_gyroscope(signals.gyroscope_radps, one.unit, place)
            elif quantity == "accelerometer":
                check_accelerometer(signals.accelerometer_mps2, step_s, one.unit, place)
            elif not _NO_FIELD_T[0] <= _size(signals.magnetometer_t) <= _NO_FIELD_T[1]:
                assert signals.magnetometer_t is not None
                check_magnetometer(signals.magnetometer_t, one.unit, place)
        except RecordingFormatError as error:
            if "signal.no_numbers" not in _codes(_said(error)):
                found.append(_said(error))
    return found


def _size(field_t: Float | None) -> float:
    sizes = np.linalg.norm(field_t, axis=1) if field_t is not None else np.empty(0)
    sizes = sizes[np.isfinite(sizes)]
    return float(np.median(sizes)) if sizes.size else _NO_FIELD_T[0]


def _said(error: RecordingFormatError) -> Sentence:
    message = error.message
    assert isinstance(message, Sentence)
    return message


def _codes(message: Sentence) -> set[str]:
    inner = [_codes(one) for one in message.parameters.values() if isinstance(one, Sentence)]
    return {message.code}.union(*inner)
