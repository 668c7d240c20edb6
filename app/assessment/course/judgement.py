"""One judgement of change in a patient's measures, for progress, caseload, reports and export."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta, tzinfo
from functools import lru_cache
from typing import Final

import numpy as np

from app.assessment.course.days import Days, days_of
from app.assessment.course.published import published_of
from app.assessment.course.scatter import Scatters
from app.assessment.measures import SessionValue
from app.assessment.schemas import ChangeWord, ProgressBreak, ProgressTrend
from estimators.comparison import channel_name
from estimators.progress import (
    FEWEST_DAYS,
    WINDOW_DAYS,
    Scatter,
    Trends,
    detectable_change,
    discoveries,
    trends,
)
from estimators.sentences import say

RAISED: Final = 0.95
"""From this probability on a decline is a reason to look, said as probable."""
_PROBABLE: Final = 0.8
_TO_RAD: Final = {"deg": math.radians(1.0), "rad": 1.0}
"""Factor to radians, by unit of an angle."""


def judged(
    values: Mapping[str, Sequence[SessionValue]], main: str | None, scatters: Scatters, zone: tzinfo
) -> dict[str, ProgressTrend]:
    """Return what may be said of each measure of a page.

    Parameters
    ----------
    values : mapping of str to sequence of SessionValue
        Of one patient and exercise by measure, oldest first.
    main : str or None
        The measure that is judged by itself; among the others false discoveries are held to one in twenty.
    zone : tzinfo
        Whose days.
    """
    days = {name: days_of(own, zone) for name, own in values.items()}
    together: dict[tuple[bytes, bytes], list[str]] = {}
    for name, one in days.items():
        together.setdefault((one.days.tobytes(), one.segments.tobytes()), []).append(name)
    found: dict[str, tuple[Trends, int]] = {}
    for names in together.values():
        first = days[names[0]]
        some = trends(
            first.days,
            np.array([days[name].values for name in names]),
            np.array([days[name].errors for name in names]),
            first.segments,
            [scatters.of(name)[0] for name in names],
        )
        found |= {name: (some, row) for row, name in enumerate(names)}
    order = list(days)
    probability = np.array([found[name][0].probability[found[name][1]] for name in order])
    at = order.index(main) if main in days else None
    holds = discoveries(probability, at)
    return {
        name: _trend(name, days[name], *found[name], bool(holds[k]), scatters) for k, name in enumerate(order)
    }


def _trend(
    measure: str, days: Days, found: Trends, row: int, is_found: bool, scatters: Scatters
) -> ProgressTrend:
    prior, source = scatters.of(measure)
    known = published_of(measure, scatters.movement)
    important = known.important if known else None
    scatter = float(found.scatter[row])
    detectable = detectable_change(scatter) if math.isfinite(scatter) else None
    count = len(days.days) - found.first
    is_judged = count >= FEWEST_DAYS
    numbers = [float(one[row]) for one in (found.start, found.end, found.change, found.half_width)]
    start, now, change, half = (one if is_judged else None for one in numbers)
    probability = float(found.probability[row])
    word: ChangeWord = "values"
    if is_judged:
        is_sure = is_found and bool(found.lasts[row])
        word = _word(probability, numbers[2], numbers[3], is_sure, important, detectable)
    last = -2 if found.unusual[row] else -1
    weeks = (days.at[last] - days.at[found.first]) / timedelta(weeks=1) if is_judged else 0.0
    return ProgressTrend(
        word=word,
        since=days.at[found.first],
        until=days.at[last] if is_judged else days.at[-1],
        days=count,
        start=start,
        now=now,
        change=change,
        half_width=half,
        per_week=numbers[2] / weeks if weeks > 0.0 else None,
        probability=probability if is_judged else None,
        important=important,
        important_source=known.important_source if known and important is not None else "",
        scatter=scatter if math.isfinite(scatter) else None,
        scatter_people=prior.people,
        scatter_source=source,
        minimal_detectable_change=detectable,
        is_last_day_unusual=bool(found.unusual[row]),
        expected=float(found.expected[row]) if found.unusual[row] else None,
        breaks=[
            ProgressBreak(at=one.at, kind=one.kind) for one in days.breaks if one.at > days.at[found.first]
        ],
    )


def _word(
    probability: float,
    change: float,
    half_width: float,
    is_sure: bool,
    important: float | None,
    detectable: float | None,
) -> ChangeWord:
    """Return what is said; nothing that is uncertain is called unchanged."""
    is_more = probability >= 0.5
    if is_sure:
        if important is not None and abs(change) < important:
            return "a_little_more" if is_more else "a_little_less"
        return "more" if is_more else "less"
    if max(probability, 1.0 - probability) >= _PROBABLE:
        return "probably_more" if is_more else "probably_less"
    # Without a published figure what two sessions differ by is the measure of what is little.
    narrow = important if important is not None else detectable
    if narrow is not None and abs(change) + half_width <= narrow:
        return "unchanged"
    return "unknown"


@dataclass(frozen=True)
class Decline:
    """A measure that declines with a probability of 0.95 or more.

    Attributes
    ----------
    text : str
        What a caseload says of it.
    """

    trend: ProgressTrend
    text: str


def decline_of(values: Sequence[SessionValue], scatters: Scatters, zone: tzinfo) -> Decline | None:
    """Return how a measure declines; None where that is less probable than 0.95.

    Parameters
    ----------
    values : sequence of SessionValue
        Of one measure, oldest first.

    Notes
    -----
    Whose straight line rises, with the last day and without it, is not asked about further: a caseload has hundreds.
    """
    if not values:
        return None
    days = days_of(values, zone)
    if not _may_decline(days):
        return None
    measure = values[0].measure
    prior, _ = scatters.of(measure)
    found = _one(
        days.days.tobytes(), days.values.tobytes(), days.errors.tobytes(), days.segments.tobytes(), prior
    )
    if not found.probability[0] <= 1.0 - RAISED:
        return None
    is_found = bool(discoveries(found.probability)[0])
    trend = _trend(measure, days, found, 0, is_found, scatters)
    return Decline(trend, _declining(trend, measure, values[0].unit))


def _declining(trend: ProgressTrend, measure: str, unit: str) -> str:
    """Say by how much a measure fell, as probable: a look at one line of many is no finding."""
    fell, half = -(trend.change or 0.0), trend.half_width or 0.0
    weeks = max(round((trend.until - trend.since) / timedelta(weeks=1)), 1)
    channel = channel_name(measure.partition(":")[2])
    if unit not in _TO_RAD:
        return say("caseload.declining", channel=channel, count=weeks)
    less_rad, half_rad = _TO_RAD[unit] * fell, _TO_RAD[unit] * half
    return say("caseload.declining_angle", channel=channel, less_rad=less_rad, half_rad=half_rad, count=weeks)


def _may_decline(days: Days) -> bool:
    inside = days.days >= days.days[-1] - WINDOW_DAYS
    if inside.sum() < FEWEST_DAYS:
        return False
    if days.segments[inside].any():
        return True
    times, values = days.days[inside], days.values[inside]
    return any(np.polyfit(times[:end], values[:end], 1)[0] < 0.0 for end in (len(times), len(times) - 1))


@lru_cache(maxsize=10_000)
def _one(times: bytes, values: bytes, errors: bytes, segments: bytes, prior: Scatter) -> Trends:
    """Judge one series once: a caseload is asked for every few seconds, and its numbers move once a day."""
    return trends(
        np.frombuffer(times),
        np.frombuffer(values)[None],
        np.frombuffer(errors)[None],
        np.frombuffer(segments),
        [prior],
    )
