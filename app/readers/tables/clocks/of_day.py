"""Times of day as text (`2026-11-22T10:00:00.123Z`, `11/22/26 10:00:00.123`, `10:00:00.123`, `59:50.5`) as seconds.

Only differences count. Dates with slashes do not say whether the month or the day comes first: read in the order that
is a date in most rows, and of two such orders in the one where fewer days pass. A zone that is written is respected, so
clocks that are put forward or back in the recording do no harm; without one, and without a date, what happened is
concluded from the jump, and a warning says so.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from datetime import date
from typing import Final

import numpy as np

from estimators.recording import Float
from estimators.sentences import Sentence, say

CLOCK: Final = "clock"
"""Stands for a unit of time in a mapping whose time column holds such text."""
_TEXT: Final = re.compile(
    r"\s*(?:(?P<date>\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-./]\d{1,2}[-./](?:\d{4}|\d{2}))(?:T|\s+))?"
    r"(?P<h>\d{1,2}):(?P<m>\d{1,2}):(?P<s>\d{1,2})(?:(?P<mark>[.,:])(?P<part>\d{1,9}))?\s*(?P<half>[AaPp]\.?[Mm]\.?)?"
    r"\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}:?(?:\d{2})?)?\s*"
)
_MINUTES: Final = re.compile(r"\s*(?P<m>\d{1,3}):(?P<s>\d{1,2})(?P<mark>[.,])(?P<part>\d{1,9})\s*")
"""Minutes and seconds; without a fraction `10:20` is more often an hour."""
_DAY_S, _HOUR_S = 86_400.0, 3600.0
_NEAR_S: Final = 2.0
"""So close to full hours, and to one hour, is a jump of a clock that was put forward or back."""


def is_clock(text: str) -> bool:
    """Return whether a field holds a time of day."""
    return (_TEXT.fullmatch(text) or _MINUTES.fullmatch(text)) is not None


def seconds_of_clock(column: Sequence[str | None]) -> tuple[Float, tuple[Sentence, ...]]:
    """Return times as text in seconds from the first day of the column.

    Returns
    -------
    seconds : ndarray, shape (N,)
        NaN where there is no time of day, or one that no clock shows.
    notes : tuple of Sentence
        What was concluded from jumps.
    """
    if not any(text and _TEXT.fullmatch(text) for text in column):
        return _seconds_of_minutes(column)
    matches = [_TEXT.fullmatch(text) if text else None for text in column]
    part_s = _part_s([found for found in matches if found])
    days = _days(Counter(found["date"] for found in matches if found and found["date"]))
    seconds = np.full(len(column), np.nan)
    has_date = has_zone = False
    first_day = zone_s = 0.0
    for row, found in enumerate(matches):
        if found is None:
            continue
        time_s = _time_of_day(found, part_s)
        day = days.get(found["date"]) if found["date"] else 0.0
        if time_s is None or day is None:
            continue
        if found["date"]:
            first_day = first_day if has_date else day
            time_s += (day - first_day) * _DAY_S
            has_date = True
        if found["zone"]:
            zone_s = _zone(found["zone"])
            has_zone = True
        seconds[row] = time_s - zone_s
    rows = np.flatnonzero(np.isfinite(seconds))
    notes: list[Sentence] = []
    if not has_date and rows.size:
        whole = np.unwrap(seconds[rows], period=_DAY_S)
        if nights := round(float(whole[-1] - seconds[rows[-1]]) / _DAY_S):
            notes.append(say("time.midnight", count=abs(nights)))
        seconds[rows] = whole
    if not has_zone and rows.size:
        seconds[rows], changes = _without_changes(seconds[rows])
        if changes:
            notes.append(say("time.clock_changed", count=changes))
    return seconds, tuple(notes)


def _seconds_of_minutes(column: Sequence[str | None]) -> tuple[Float, tuple[Sentence, ...]]:
    """Return times as minutes and seconds; those that fall by about an hour have passed one."""
    matches = [_MINUTES.fullmatch(text) if text else None for text in column]
    part_s = _part_s([found for found in matches if found])
    seconds = np.array(
        [
            60.0 * int(one["m"]) + int(one["s"]) + part_s(one) if one and int(one["s"]) < 60 else np.nan
            for one in matches
        ]
    )
    rows = np.flatnonzero(np.isfinite(seconds))
    notes: tuple[Sentence, ...] = ()
    if rows.size and seconds[rows].max() < _HOUR_S:
        whole = np.unwrap(seconds[rows], period=_HOUR_S)
        if hours := round(float(whole[-1] - seconds[rows[-1]]) / _HOUR_S):
            notes = (say("time.hour_passed", count=abs(hours)),)
        seconds[rows] = whole
    return seconds, notes


def _part_s(rows: Sequence[re.Match[str]]) -> Callable[[re.Match[str]], float]:
    """Return how to read what stands behind the seconds: their decimals, or thousandths without leading zeros.

    `10:00:01:7` is 7 ms where `10:00:01:12` follows it: read as decimals the time would run backwards.
    """
    parts = [found["part"] for found in rows if found["part"]]
    widths = {len(part) for part in parts}

    def decimals(found: re.Match[str]) -> float:
        part = found["part"]
        return int(part) / 10.0 ** len(part) if part else 0.0

    def thousandths(found: re.Match[str]) -> float:
        return int(found["part"] or 0) / 1000.0

    if len(widths) < 2 or max(widths) != 3 or any(len(part) > 1 and part[0] == "0" for part in parts):
        return decimals
    backwards = []
    for reading in (decimals, thousandths):
        steps = np.diff([int(found["s"]) + reading(found) for found in rows])
        backwards.append(int((np.remainder(steps + 30.0, 60.0) < 30.0).sum()))
    return thousandths if backwards[1] < backwards[0] else decimals


def _time_of_day(found: re.Match[str], part_s: Callable[[re.Match[str]], float]) -> float | None:
    hour, minute, second = int(found["h"]), int(found["m"]), int(found["s"])
    if found["half"]:
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + (12 if found["half"][0] in "pP" else 0)
    # A leap second is written as 60.
    if hour > 24 or minute > 59 or second > 60:
        return None
    return hour * _HOUR_S + minute * 60.0 + second + part_s(found)


def _days(rows: Counter[str]) -> dict[str, float]:
    """Return the number of each day that a calendar has, of texts with how many rows have them."""
    tried = [_numbered(rows, order) for order in ("mdy", "dmy", "ymd")]
    return min(
        tried,
        key=lambda days: (
            -sum(rows[text] for text in days),
            max(days.values()) - min(days.values()) if days else 0.0,
        ),
    )


def _numbered(texts: Iterable[str], order: str) -> dict[str, float]:
    """Return the number of each day, read in this order where the text itself does not say the year or day first."""
    days: dict[str, float] = {}
    for text in texts:
        numbers = [int(part) for part in re.split(r"[-/.]", text)]
        if numbers[0] > 31:
            placed = "ymd"
        elif "." in text and numbers[2] > 99:
            placed = "dmy"
        else:
            # A year of four digits stands last.
            placed = order if numbers[2] < 100 or order != "ymd" else "dmy"
        of = dict(zip(placed, numbers, strict=True))
        with suppress(ValueError):
            days[text] = float(
                date(of["y"] if of["y"] > 99 else 2000 + of["y"], of["m"], of["d"]).toordinal()
            )
    return days


def _zone(text: str) -> float:
    """Return how far a zone is ahead of UTC, s."""
    if text[0] not in "+-":
        return 0.0
    digits = text[1:].replace(":", "").ljust(4, "0")
    ahead_s = int(digits[:2]) * _HOUR_S + int(digits[2:]) * 60.0
    return -ahead_s if text[0] == "-" else ahead_s


def _without_changes(time_s: Float) -> tuple[Float, int]:
    """Take out jumps by one hour at full hours, as summer time begins and ends with; return how many there were.

    A pause of one hour from a full hour to the next looks the same, and is much rarer.
    """
    steps = np.diff(time_s)
    to_hour = np.abs(time_s - _HOUR_S * np.round(time_s / _HOUR_S))
    # Forward an hour is missing after 01:59:59, back one is there twice after 02:59:59.
    is_change = (
        (np.abs(np.abs(steps) - _HOUR_S) < _NEAR_S) & (to_hour[:-1] < _NEAR_S) & (to_hour[1:] < _NEAR_S)
    )
    shift = np.concatenate([[0.0], np.cumsum(np.where(is_change, np.sign(steps) * _HOUR_S, 0.0))])
    return np.asarray(time_s - shift), int(is_change.sum())
