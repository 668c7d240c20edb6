"""The small curve of a line of the caseload: one point a day, over eight weeks."""

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta, tzinfo
from itertools import groupby
from typing import Final

from app.assessment.measures import SessionValue

SHOWN: Final = timedelta(weeks=8)
"""Before the newest session; a busy day would push everything else out of a curve of so many sessions."""


def by_day(values: Sequence[SessionValue], zone: tzinfo) -> list[SessionValue]:
    """Return the values of one measure drawn together day by day, those of the last eight weeks with any.

    Parameters
    ----------
    values : sequence of SessionValue
        Of one patient, exercise and measure, oldest first.
    zone : tzinfo
        In which days begin.

    Returns
    -------
    list of SessionValue
        One a day, which stands for its last session: the mean over all repetitions of the day, and the standard
        deviation between them.
    """
    if not values:
        return []
    since = values[-1].at - SHOWN
    days = groupby((one for one in values if one.at >= since), lambda one: one.at.astimezone(zone).date())
    return [_together(list(day)) for _, day in days]


def _together(day: list[SessionValue]) -> SessionValue:
    if len(day) == 1:
        return day[0]
    count = sum(one.count for one in day)
    mean = sum(one.count * one.mean for one in day) / count
    # Within the sessions, and between them.
    squares = sum(one.count * ((one.spread or 0.0) ** 2 + (one.mean - mean) ** 2) for one in day)
    return replace(day[-1], mean=mean, spread=math.sqrt(squares / count), count=count)
