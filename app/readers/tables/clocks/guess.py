"""Which column of a table is its clock, and what its head says of the rate.

A column of stamps that rise is the strongest evidence, then text with times of day, then a counter of samples with a
rate from a person or from the head; rows are counted as time only where nothing else says it. Whatever contradicts the
choice becomes a note.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from app.readers.tables.clocks.counter import COUNT, gone_on, unwrapped
from app.readers.tables.clocks.mended import usual_interval
from app.readers.tables.clocks.of_day import CLOCK
from app.readers.tables.clocks.stamps import HIGHEST_HZ, LOWEST_HZ, UNIT_FACTORS, units_of
from app.readers.tables.head import TableHead
from app.readers.tables.names import is_of_quantity, quantity_of, time_unit_of, without_unit, words_of
from app.readers.tables.units import Body
from estimators.recording import Float
from estimators.sentences import Sentence, say

_TIME: Final = frozenset(
    {"time", "t", "timestamp", "timestamps", "seconds", "second", "secs", "elapsed", "millis"}
) | {*("zeit", "zeitstempel", "micros", "datetime")}
_NO_STAMP: Final = frozenset({"fine", "utc", "date"})
"""Ticks of an unknown length, and parts of a calendar."""
_COUNTER: Final = frozenset({"fine", "counter", "packet", "sample", "frame", "seq", "sequence", "count"})
"""What counts samples, in ticks whose length only a rate says."""
_COUNTED: Final = re.compile(r"^(column [0-9]+|index|sensor axis|nr|no|id)$", re.IGNORECASE)
_RATE: Final = re.compile(
    r"(?:rate|frequency|freq\w*|\bfs\b)[^0-9\n]{0,20}([0-9]+(?:[.,][0-9]+)?)|([0-9]+(?:[.,][0-9]+)?)\s*Hz\b",
    re.IGNORECASE,
)
_OF_SAMPLES: Final = re.compile(
    r"sampl|update|output|abtast|\bodr\b|\bfs\b|data ?rate|logg|recording", re.IGNORECASE
)
_CLAUSE: Final = re.compile(r"[;|]|,\s|\t")
_OF_FIELD: Final = re.compile(r"^(?!.*(gyr|acc|imu)).*mag", re.IGNORECASE)
"""Magnetometers often have a slower rate of their own."""
_OF_OTHERS: Final = re.compile(
    r"heart|herz|puls|breath|atem|resp|notch|filter|d?lpf|hpf|cut|pass|mains|line freq|netz|baud|bit ?rate|range|band"
    r"|refresh|screen|bpm|carrier|radio|wifi|ghz|mhz",
    re.IGNORECASE,
)
_TICK_S: Final = (1e-6, 1e-4)
"""Of fine sample times whose rate nobody says: microseconds, or the ticks of 10 kHz of older devices."""
_SLOWEST_HZ: Final = 10.0
_USUAL_STEP_S: Final = 0.999e-3
_AGREES: Final = (0.8, 1.25)
_ARRIVED: Final = 0.5
"""Of a usual step: samples that follow closer arrived together."""
_MOST_ARRIVED: Final = 0.1


@dataclass(frozen=True)
class TimeGuess:
    """The clock of a table.

    Attributes
    ----------
    unit : str
        Of `CsvMapping.time_unit`.
    rate_hz : float or None
        Of a counter, or of rows that are counted.
    step_s : float or None
        Usual time between two rows.
    notes, missing : tuple of Sentence
        What was assumed or contradicts; what a person must add.
    """

    column: str | None = None
    unit: str = "s"
    rate_hz: float | None = None
    step_s: float | None = None
    notes: tuple[Sentence, ...] = ()
    missing: tuple[Sentence, ...] = ()


@dataclass(frozen=True)
class _Stamps:
    column: str
    unit: str
    step_s: float
    is_arrival: bool = False
    is_assumed: bool = False
    """Whether another unit would fit as well."""


def guess_time(head: TableHead, body: Body, signals: set[str], rate_hz: float | None = None) -> TimeGuess:
    """Find the clock of a table.

    Parameters
    ----------
    signals : set of str
        Columns of signals: none of them is a clock.
    rate_hz : float, optional
        Of the samples, where a person said it.
    """
    said_hz = rate_said(head.preamble) if rate_hz is None else rate_hz
    others = [column for column in head.columns if column not in signals]
    named = [column for column in others if _is_time(words_of(column))]
    named.sort(key=lambda column: not time_unit_of(column))
    unnamed = [c for c in others[:1] if _COUNTED.match(c)]
    clocks = [found for c in (*named, *unnamed) if (found := _stamps(body, c, said_hz, is_named=c in named))]
    if clocks:
        # Stamps of arrival come in bursts; beside them may stand those of the device.
        clocks.sort(key=lambda one: one.is_arrival)
        return _of_stamps(clocks[0], said_hz, [one.column for one in clocks[1:]])
    if (text := _text_clock(others, body)) is not None:
        return _of_stamps(text, said_hz)
    counted = {
        column: step
        for column in [c for c in others if _COUNTER & set(words_of(c))] + unnamed
        if (step := _counted_by(body, column)) is not None
    }
    for column, step in counted.items():
        of_ticks = _rate_of_ticks(step, said_hz) if "fine" in words_of(column) else None
        if of_ticks is not None and of_ticks[0] == _TICK_S[0]:
            # Stamps, which several streams share.
            note = say("guess.microseconds", column=column, rate_hz=of_ticks[1])
            return TimeGuess(column, "us", None, 1.0 / of_ticks[1], (note,))
        rate = said_hz or (of_ticks[1] if of_ticks else None)
        if rate is not None:
            note = say("guess.counter", column=column, rate_hz=rate)
            return TimeGuess(column, COUNT, rate, 1.0 / rate, (note,))
    if first := next((one for one in counted if one not in unnamed), None):
        return TimeGuess(first, COUNT, missing=(say("guess.counter_needs_rate", column=first),))
    if named and said_hz is None and np.isfinite(body.numbers(named[0])).any():
        # Its own refusal says more than that there is none.
        return TimeGuess(named[0], time_unit_of(named[0]) or "s")
    if said_hz is None:
        return TimeGuess(missing=(say("guess.no_time"),))
    return TimeGuess(None, "s", said_hz, 1.0 / said_hz, (say("guess.rows_counted", rate_hz=said_hz),))


def own_clocks(
    head: TableHead, body: Body, signals: list[tuple[str, str]], columns: set[str]
) -> dict[tuple[str, str], str]:
    """Return the clock of each signal where sensors or quantities have clocks of their own; else nothing.

    Parameters
    ----------
    signals : list of tuple of str
        Device and quantity of each.
    columns : set of str
        Of the signals.
    """
    clocks = [
        (column, words)
        for column in head.columns
        if column not in columns
        and _is_time(words := words_of(without_unit(column)))
        and _stamps(body, column, None, is_named=True) is not None
    ]
    found: dict[tuple[str, str], str] = {}
    for device, quantity in signals:
        fits = {column: _belongs(words, device, quantity) for column, words in clocks}
        own = max(fits, key=lambda column: fits[column], default=None)
        if own is None or not fits[own]:
            return {}
        found[device, quantity] = own
    return found if len(set(found.values())) > 1 else {}


def _belongs(words: list[str], device: str, quantity: str) -> int:
    """Return how well a time column's words name a signal; 0 where they name another one, or none."""
    rest, mine = list(words), [word for word in device.split("_") if word]
    is_device = bool(mine) and all(word in rest for word in mine)
    for word in mine if is_device else ():
        rest.remove(word)
    left = [word for word in rest if word not in _TIME]
    if len(left) == len(rest) or not all(is_of_quantity(word) for word in left):
        return 0
    if left and quantity_of(left) != quantity:
        return 0
    return 2 * is_device + bool(left)


def _is_time(words: list[str]) -> bool:
    """Return whether words name a time; `second` may be a device."""
    said = _TIME & set(words)
    return bool(said) and not _NO_STAMP & set(words) and (said != {"second"} or len(words) == 1)


def rate_said(lines: Iterable[str]) -> float | None:
    """Return the rate of the samples that lines above a table say; None where there is none.

    Parameters
    ----------
    lines : iterable of str
        A number of hertz of something else (a filter, a heart) is none.
    """
    found: dict[bool, set[float]] = {True: set(), False: set()}
    for clause in (part for line in lines for part in _CLAUSE.split(line)):
        of_samples = _OF_SAMPLES.search(clause) is not None
        if (_OF_OTHERS.search(clause) and not of_samples) or _OF_FIELD.search(clause):
            continue
        for said in _RATE.finditer(clause):
            rate = float((said[1] or said[2]).replace(",", "."))
            if LOWEST_HZ <= rate <= HIGHEST_HZ:
                found[of_samples].add(rate)
    # Of two different ones nobody knows which is meant.
    rates = found[True] or found[False]
    return rates.pop() if len(rates) == 1 else None


def _of_stamps(clock: _Stamps, said_hz: float | None, left: Sequence[str] = ()) -> TimeGuess:
    notes = [say("guess.clocks_left", columns=list(left), column=clock.column)] if left else []
    if clock.is_assumed:
        rate_hz = 1.0 / clock.step_s
        notes.append(say("guess.time_unit", column=clock.column, unit=clock.unit, rate_hz=rate_hz))
    if said_hz is not None and not _AGREES[0] < said_hz * clock.step_s < _AGREES[1]:
        notes.append(say("guess.rate_left", said_hz=said_hz, column=clock.column, rate_hz=1.0 / clock.step_s))
    return TimeGuess(clock.column, clock.unit, None, clock.step_s, tuple(notes))


def _stamps(body: Body, column: str, said_hz: float | None, *, is_named: bool) -> _Stamps | None:
    """Return a column of numbers that rise as time does; None where it is none."""
    values = body.numbers(column)[:, 0]
    # Where it ran over its end early, most of its rows stand behind that.
    values = gone_on(values[np.isfinite(values)])
    steps = np.diff(values)
    if steps.size < 1 or not (steps >= 0).mean() > 0.5 or not (steps > 0).any():
        return None
    written = time_unit_of(column)
    usual = _usual(values, written)
    # A unit that nobody wrote, and no rate that somebody said, must make a rate that most sensors have.
    possible = units_of(usual)
    fitting = [u for u in possible if written or said_hz or usual * UNIT_FACTORS[u] >= _USUAL_STEP_S]
    # Fewer samples a second than a filter can use have few tables.
    fitting.sort(key=lambda one: usual * UNIT_FACTORS[one] > 1.001 / _SLOWEST_HZ)
    if not is_named and (not fitting or (abs(usual - round(usual)) < 1e-6 * usual and fitting[0] != "s")):
        # A number of the row.
        return None
    said = [u for u in fitting if said_hz and _AGREES[0] < said_hz * usual * UNIT_FACTORS[u] < _AGREES[1]]
    unit = written if written in fitting or (written and not fitting) else (said or fitting or [""])[0]
    is_denied = said_hz is not None and not said
    if not unit or (
        is_denied and not written and abs(usual - 1.0) < 1e-6 and (values == np.rint(values)).all()
    ):
        # It counts, or measures, something else.
        return None
    is_arrival = bool((steps < _ARRIVED * usual).mean() > _MOST_ARRIVED)
    is_assumed = not written and not said and len(possible) > 1
    return _Stamps(column, unit, usual * UNIT_FACTORS[unit], is_arrival, is_assumed)


def _usual(values: Float, written: str) -> float:
    """Return the usual step of stamps in their unit; see `usual_interval`."""
    steps = np.diff(values)
    rising = steps[steps >= 0]
    middle, mean = float(np.median(rising)), float(rising.mean())
    unit = written or (units_of(middle) or units_of(mean) or ["s"])[0]
    factor = UNIT_FACTORS.get(unit, 1.0)
    return usual_interval(np.maximum.accumulate(values) * factor) / factor


def _text_clock(columns: list[str], body: Body) -> _Stamps | None:
    """Return the first column of times of day that advance, by its content."""
    for column in columns:
        times = body.times(column, CLOCK)
        steps = np.diff(times[np.isfinite(times)])
        if 2 * steps.size < times.size - 1 or not (steps > 0).any() or (steps < 0).mean() > 0.5:
            continue
        return _Stamps(column, CLOCK, float(steps[steps > 0].sum() / steps.size))
    return None


def _counted_by(body: Body, column: str) -> float | None:
    """Return the usual step of a counter; None where a column counts nothing."""
    values = body.numbers(column)[:, 0]
    values = values[np.isfinite(values)]
    if values.size < 3 or not (values == np.rint(values)).all():
        return None
    steps = np.diff(unwrapped(values)[0])
    usual = float(np.median(steps))
    return usual if usual > 0.0 and (steps >= 0.0).mean() > 0.9 else None


def _rate_of_ticks(step: float, said_hz: float | None) -> tuple[float, float] | None:
    """Return the tick of fine sample times and the rate that their step says; None where it says none."""
    low, high = (0.9 * said_hz, 1.1 * said_hz) if said_hz else (_SLOWEST_HZ, HIGHEST_HZ)
    return next(((tick, rate) for tick in _TICK_S if low <= (rate := 1.0 / (step * tick)) <= high), None)
