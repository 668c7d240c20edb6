"""The values of a measure day by day, and where their series breaks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, tzinfo
from itertools import groupby, pairwise
from typing import Final, Literal

import numpy as np

from app.assessment.measures import SessionValue
from estimators.recording import Float

BreakKind = Literal["estimator", "template", "placement"]
_BESIDE: Final = (
    "duration_ratio",
    "timing_deviation",
    "shape_",
    "inside_band",
    "peak_deviation",
    "path_",
    "range_ratio:",
)
"""Measures against the template: another version of it is another measure."""
_SECONDS_A_DAY: Final = 86_400.0


@dataclass(frozen=True)
class Break:
    """Where the level may step: the first day measured in another way."""

    at: datetime
    kind: BreakKind


@dataclass(frozen=True)
class Days:
    """One measure of one patient, a value a day.

    Attributes
    ----------
    at : list of datetime
        When the day's sessions were, in the mean.
    days, values, errors, segments : ndarray, shape (N,)
        As `estimators.progress.trends` takes them; an error is one standard deviation of the value by the repetitions.
    """

    at: list[datetime]
    days: Float
    values: Float
    errors: Float
    segments: Float
    breaks: list[Break]


def days_of(values: Sequence[SessionValue], zone: tzinfo) -> Days:
    """Return the values of a measure by day: sessions of one day share its form.

    Parameters
    ----------
    values : sequence of SessionValue
        Of one measure, oldest first.
    zone : tzinfo
        Whose days.
    """
    by_day = [list(found) for _, found in groupby(values, key=lambda one: one.at.astimezone(zone).date())]
    at = [
        one[0].at + sum((other.at - one[0].at for other in one), one[0].at - one[0].at) / len(one)
        for one in by_day
    ]
    breaks: list[Break] = []
    segments = np.zeros(len(by_day))
    for number, (before, after) in enumerate(pairwise(by_day), start=1):
        kinds = broken(before[-1], after[-1])
        breaks += [Break(after[-1].at, kind) for kind in kinds]
        segments[number] = segments[number - 1] + bool(kinds)
    return Days(
        at,
        np.array([(one - at[0]).total_seconds() / _SECONDS_A_DAY for one in at]),
        np.array([math.fsum(one.mean for one in found) / len(found) for found in by_day]),
        np.array([_error(found) for found in by_day]),
        segments,
        breaks,
    )


def broken(before: SessionValue, after: SessionValue) -> list[BreakKind]:
    """Return in what two sessions differ so that a step between them is no change of the patient.

    Parameters
    ----------
    before, after : SessionValue
        Of one measure.
    """
    found: list[BreakKind] = []
    made = (before.orientation, before.orientation_version, before.pipeline_version)
    if made != (after.orientation, after.orientation_version, after.pipeline_version):
        found.append("estimator")
    is_beside = before.measure.startswith(_BESIDE)
    if before.template_id != after.template_id or (
        is_beside and before.template_version_id != after.template_version_id
    ):
        found.append("template")
    # Where nobody wrote down which sensors were worn, nothing speaks for others.
    if before.placements and after.placements and before.placements != after.placements:
        found.append("placement")
    return found


def _error(found: Sequence[SessionValue]) -> float:
    """Return the standard deviation of a day's mean; NaN where no repetitions say it."""
    known = [
        one.spread if one.is_of_all else one.spread / math.sqrt(max(one.count, 1))
        for one in found
        if one.spread is not None
    ]
    if not known:
        return math.nan
    return math.sqrt(math.fsum(one**2 for one in known) / len(known) / len(found))
