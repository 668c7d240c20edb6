"""Columns that tell the rows of a table apart: devices that take turns, and kinds of rows.

A column of names, addresses or numbers makes sensors only where each of its values has samples of its own at an even
rate while others have theirs; a mark that somebody set, a button or the phase of an exercise, does not.
"""

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.readers.tables.clocks.counter import COUNT
from app.readers.tables.clocks.mended import usual_interval
from app.readers.tables.head import TableHead, is_number
from app.readers.tables.names import placement_of, quantity_of, side_of, words_of
from app.readers.tables.units import Body
from estimators.recording import Float

_MOST_DEVICES: Final = 17
_FEWEST_ROWS: Final = 8
"""Of each device in the beginning of a table."""
_EVEN: Final = (0.5, 1.5)
_MOST_UNEVEN: Final = 0.2
"""Of the steps of a device: its samples come at one rate."""
_TURN: Final = 1.2
"""Times the mean step of all rows: what one device of several takes at least to its next sample."""
_FEWEST_SWITCHES: Final = 0.1
"""Of the rows: devices that send in turns change from row to row."""
_OVERLAP: Final = 0.5
"""Of the time of a device: while it was on, others were, too."""
_JUMP: Final = 3.0
_MOST_BENT: Final = 0.05
"""Of the changes of a text, that look like a jump of one device by chance."""
DEVICE: Final = re.compile(
    r"device(name)?|sensor|imu|node|mac|addr(ess)?|serial|unit|gerät|placement|position|location|limb|segment|side"
)
"""What a column of devices is called."""
_DEVICE_ITSELF: Final = re.compile(r"device(name)?|sensor|imu|node|mac|addr(ess)?|serial|gerät")
_OF_NAMES: Final = frozenset({"name", "id", "nr", "no", "number", "uuid"})
DECIMAL: Final = re.compile(r"[+-]?\d*[.,]\d+")
"""What is measured, and no name."""
_NO_DEVICE: Final = re.compile(
    r"trial|rep(etition)?|run|set|subject|participant|session|round|block|phase|activity|label|event|seq(uence)?"
    r"|count(er)?|sync|index"
)
"""What a column of marks is called, whose values may take turns too."""
_OF_SIGNALS: Final = frozenset({"gyroscope", "accelerometer", "magnetometer"})


@dataclass(frozen=True)
class Turns:
    """A column whose values take turns.

    Attributes
    ----------
    values : tuple of str
        As they are written, in the order of the table.
    quantities : dict of str to str
        Of a column of kinds: which quantity the rows of a value hold.
    is_one : bool
        They are names of one device after the other and not of several: its rows belong together.
    """

    column: str
    values: tuple[str, ...]
    quantities: dict[str, str]
    is_one: bool = False


def kinds_of_rows(head: TableHead, body: Body) -> Turns | None:
    """Return the column that says of each row which quantity it holds; None where there is none."""
    for column in head.columns:
        values = _values(body, column)
        quantities = {value: found for value in values if (found := _quantity_said(value))}
        if {"gyroscope", "accelerometer"} <= set(quantities.values()):
            return Turns(column, tuple(quantities), quantities)
    return None


def devices_of_pieces(
    bodies: Sequence[Body],
    columns: list[str],
    time: str | None,
    unit: str,
    signals: tuple[str, ...],
    *,
    is_told_apart: bool = False,
) -> Turns | None:
    """Return the column by which rows of several devices differ in any of some pieces of a table; None for none.

    Parameters
    ----------
    bodies : sequence of Body
        A device may be switched on later: its rows are in some of them.
    columns, time, unit
        See `devices_of_rows`.
    signals : tuple of str
        Of one sensor, three of each quantity.
    is_told_apart : bool
        Columns of their own tell the sensors apart already: devices that were never on at once are none besides.

    Returns
    -------
    Turns or None
        Of a column of devices by which one sensor is only named again, `is_one`.
    """
    found = [devices_of_rows(body, columns, time, unit, signals[:3]) for body in bodies]
    if turns := max((one for one in found if one is not None), key=lambda one: len(one.values), default=None):
        return replace(turns, values=_often(bodies, turns.column) or turns.values)
    for column in columns:
        values = _often(bodies, column)
        if not 2 <= len(values) <= _MOST_DEVICES:
            continue
        if follow_each_other(bodies, column, values, time, unit):
            return Turns(column, values, {})
        # Devices that are named, and were never on at once, are not one; numbers may be marks.
        if names_devices(column) and not any(map(is_number, values)):
            is_one = is_told_apart or _goes_on(bodies, column, values, time, unit, signals)
            return Turns(column, values, {}, is_one)
    return None


def _goes_on(
    bodies: Sequence[Body],
    column: str,
    values: Collection[str],
    time: str | None,
    unit: str,
    signals: tuple[str, ...],
) -> bool:
    """Return whether time and signals go on over each change of a text: then it says something of one device.

    No person changes a sensor for another between two samples, and none lies as the other did.
    """
    changes = bent = 0
    for body in bodies:
        texts, measured = np.array(body.texts(column), dtype=str), body.numbers(*signals)
        at = np.arange(texts.size, dtype=np.float64) if time is None else body.times(time, unit)
        rows = np.isfinite(at) & np.isfinite(measured).all(axis=1) & np.isin(texts, list(values))
        at, texts, measured = at[rows], texts[rows], measured[rows]
        if texts.size < 2 * _FEWEST_ROWS:
            continue
        steps = np.diff(measured, axis=0)
        seams = np.flatnonzero(texts[2:-1] != texts[1:-2])
        if (np.abs(np.diff(at)[1:-1][seams]) > _EVEN[1] * usual_interval(at)).any():
            return False
        # By how much each step differs from those around it, as a share of what is exceeded by one in a hundred.
        bends = (
            np.abs(steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])).reshape(len(steps) - 2, -1, 3).sum(axis=2)
        )
        usual = np.percentile(np.delete(bends, seams, axis=0), 99.0, axis=0)
        bent += int((bends[seams] > usual).any(axis=1).sum())
        changes += seams.size
    return changes > 0 and bent <= _MOST_BENT * changes


def follow_each_other(
    bodies: Sequence[Body], column: str, values: Collection[str], time: str | None, unit: str
) -> bool:
    """Return whether one device stands below the other: time begins again with each text of a column.

    Parameters
    ----------
    bodies : sequence of Body
        Of the beginning of a table, and of pieces of its rest, in their order.
    column : str
        Called as devices are, or holding places; else it may say what was done, one run after the other.
    values : collection of str
        That it holds.
    """
    words = words_of(column)
    if time is None or any(map(_NO_DEVICE.fullmatch, words)) or any(map(DECIMAL.fullmatch, values)):
        return False
    if not any(map(DEVICE.fullmatch, words)) and not all(placement_of(one) or side_of(one) for one in values):
        return False
    at = np.concatenate([body.times(time, unit) for body in bodies])
    texts = np.array([text for body in bodies for text in body.texts(column)], dtype=str)
    rows = np.isfinite(at) & np.isin(texts, list(values))
    at, texts = at[rows], texts[rows]
    again = np.diff(at) < 0.0
    each = [at[texts == value] for value in values]
    # Of a recording that was begun again, as of stamps that go to and fro, time falls within a text too.
    if (
        not again.any()
        or (texts[1:] == texts[:-1])[again].any()
        or any((np.diff(a) < 0.0).any() for a in each)
    ):
        return False
    begun, ended = [a[0] for a in each], [a[-1] for a in each]
    return bool(min(ended) - max(begun) > _OVERLAP * min(np.subtract(ended, begun)))


def only_device(bodies: Sequence[Body], columns: list[str]) -> dict[str, str]:
    """Return the column of devices in which all rows of some pieces hold one text, with that; empty where none does."""
    for column in filter(names_devices, columns):
        values = {value for body in bodies for value in body.texts(column) if value != column}
        # A column of numbers may be one of marks, such as a button.
        if len(values) == 1 and not all(not value or is_number(value) for value in values):
            return {column: values.pop()}
    return {}


def names_devices(column: str) -> bool:
    """Return whether a column is called as nothing but devices are; a side may be that which a person moved."""
    words = words_of(column)
    # `imu3 button` is something of a device.
    of_devices = [word for word in words if _DEVICE_ITSELF.fullmatch(word)]
    return bool(of_devices) and set(words) <= {*of_devices, *_OF_NAMES}


def devices_of_rows(
    body: Body, columns: list[str], time: str | None, unit: str, signals: tuple[str, ...]
) -> Turns | None:
    """Return the column by which rows of several devices differ; None where there is none.

    Parameters
    ----------
    columns : list of str
        Those that are neither signal nor clock.
    time : str or None
        The clock; None: rows are counted.
    signals : tuple of str
        Of one quantity: what jumps from device to device.
    """
    for column in columns:
        values, words = _values(body, column), words_of(column)
        if not 2 <= len(values) <= _MOST_DEVICES or any(map(DECIMAL.fullmatch, values)):
            continue
        texts = np.array(body.texts(column))
        is_mark = any(map(_NO_DEVICE.fullmatch, words))
        is_named = not is_mark and (
            any(map(DEVICE.fullmatch, words)) or all(placement_of(one) or side_of(one) for one in values)
        )
        # What nobody calls a device makes devices only where its rows take turns and do not belong together.
        if not is_named and (is_mark or not _jumps(texts, body.numbers(*signals))):
            continue
        if float((texts[1:] != texts[:-1]).mean()) < _FEWEST_SWITCHES and not _begins_again(body, time, unit):
            # Phases of one recording, one after the other.
            continue
        clocks = (
            [] if time is None else [[body.of_rows({column: value}).seconds(time, unit) for value in values]]
        )
        if time is None or unit == COUNT:
            # Devices may count from numbers of their own: then the order of the rows says it.
            clocks.append([np.flatnonzero(texts == value).astype(np.float64) for value in values])
        if any(_take_turns(parts, is_named=is_named) for parts in clocks):
            return Turns(column, values, {})
    return None


def _begins_again(body: Body, time: str | None, unit: str) -> bool:
    """Return whether the time of rows falls, as where one device stands below the other."""
    if time is None:
        return False
    at = body.times(time, unit)
    return bool((np.diff(at[np.isfinite(at)]) < 0.0).any())


def _jumps(texts: NDArray[np.str_], signals: Float) -> bool:
    """Return whether a signal differs far more from row to row than from one row of a value to its next."""
    across = np.linalg.norm(np.diff(signals, axis=0), axis=1)[texts[1:] != texts[:-1]]
    inside = [np.linalg.norm(np.diff(signals[texts == value], axis=0), axis=1) for value in np.unique(texts)]
    within = np.concatenate(inside)
    across, within = across[np.isfinite(across)], within[np.isfinite(within)]
    if across.size < 0.3 * texts.size or not within.size:
        return False
    return float(np.median(across)) > _JUMP * float(np.median(within))


def _take_turns(parts: list[Float], *, is_named: bool) -> bool:
    """Return whether parts are on at once, each at its own rate, which is even where no name says what they are."""
    parts = [one[np.isfinite(one)] for one in parts]
    if min(one.size for one in parts) < _FEWEST_ROWS:
        return False
    at = np.concatenate(parts)
    usually = [usual_interval(np.maximum.accumulate(one)) for one in parts]
    # Blocks one below the other begin again: in order of their time, and without what all of them miss.
    steps = np.diff(np.sort(at))
    near = steps[steps < 2.0 * max(usually)]
    if not near.size:
        # Every row has the same time.
        return False
    mean = float(near.mean())
    is_slower = False
    for place, one in enumerate(parts):
        steps = np.diff(one)
        usual = usually[place]
        uneven = (steps < _EVEN[0] * usual) | (steps > _EVEN[1] * usual)
        if usual <= 0.0 or (not is_named and float(uneven.mean()) > _MOST_UNEVEN):
            return False
        others = np.concatenate([other for k, other in enumerate(parts) if k != place])
        shared = min(one[-1], others.max()) - max(one[0], others.min())
        if shared < _OVERLAP * (one[-1] - one[0]):
            return False
        is_slower |= usual > _TURN * mean
    return is_slower


def _values(body: Body, column: str) -> tuple[str, ...]:
    return _often([body], column)


def _often(bodies: Sequence[Body], column: str) -> tuple[str, ...]:
    counted = Counter(text for body in bodies for text in body.texts(column) if text and text != column)
    # A head that stands again, or a damaged row, is no value that takes turns.
    often = tuple(text for text, rows in counted.items() if rows >= _FEWEST_ROWS)
    return often if len(often) <= 4 * _MOST_DEVICES else ()


def _quantity_said(value: str) -> str:
    if is_number(value):
        return ""
    words = words_of(value)
    if {"linear", "user", "free", "uncalibrated", "gravity"} & set(words):
        return ""
    found = quantity_of(words)
    return found if found in _OF_SIGNALS else ""
