"""References beside a patient's values: the other side of the same patient, and published values."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.assessment.course.norms import norm_of
from app.assessment.measures import SessionValue, session_values
from app.assessment.schemas import MeasureValue, OtherSide, ProgressBand
from app.exercises.models import Exercise
from app.patients.models import Patient
from estimators.comparison.measures import symmetry_angle, symmetry_ratio
from estimators.conventions import SIDES
from estimators.sentences import say

_SIDE = re.compile("left|right")


def other_side_values(
    session: Session, patient: Patient, exercise: Exercise | None
) -> dict[str, SessionValue]:
    """Return the newest value of each measure on the unaffected side, by the name it has on the affected one.

    Parameters
    ----------
    patient : Patient
        Access was checked.
    exercise : Exercise or None
        The one whose progress is asked for. Its twin is the exercise of the same movement for the other side.

    Returns
    -------
    dict of str to SessionValue
        Empty unless the exercise is one of the affected side and its twin was practised.
    """
    if exercise is None or exercise.side not in SIDES or patient.affected_side != exercise.side:
        return {}
    twins = session.scalars(
        select(Exercise.id).where(
            Exercise.clinic_id == exercise.clinic_id,
            Exercise.movement == exercise.movement,
            Exercise.side == _mirrored(exercise.side),
            Exercise.primary_angle == _mirrored(exercise.primary_angle),
        )
    ).all()
    if not twins:
        return {}
    values = session_values(session, [patient.id], twins)
    return {_mirrored(value.measure): value for value in values}


def walked_other_side(patient: Patient, values: Sequence[SessionValue]) -> dict[str, SessionValue]:
    """Return the newest value of each measure of the unaffected foot, by the name it has of the affected one.

    Parameters
    ----------
    values : sequence of SessionValue
        Of walks, oldest first.
    """
    side = patient.affected_side
    if side not in SIDES:
        return {}
    return {
        _mirrored(value.measure): value for value in values if value.measure.endswith(f":{_mirrored(side)}")
    }


@dataclass(frozen=True)
class _Reading:
    """What symmetry needs of a value: mean, spread between repetitions and their number."""

    mean: float
    spread: float | None
    count: int


def beside_other_side(
    session: Session, patient: Patient, exercise: Exercise | None, summary: Sequence[MeasureValue]
) -> list[OtherSide]:
    """Return the measures of one session beside those of the newest session with the unaffected side.

    Parameters
    ----------
    patient : Patient
        Access was checked.
    exercise : Exercise or None
        Of the session.
    summary : sequence of MeasureValue
        Of the session's comparison.
    """
    others = other_side_values(session, patient, exercise)
    found = []
    for one in summary:
        other = others.get(one.measure)
        if other is None or one.value is None:
            continue
        here, there = _Reading(one.value, one.uncertainty, one.count), _reading(other)
        symmetry = _symmetry(patient.affected_side or "", here, there)
        if symmetry is None:
            continue
        found.append(
            OtherSide(
                measure=one.measure,
                label=one.label,
                unit=one.unit,
                value=here.mean,
                other_value=there.mean,
                other_count=there.count,
                symmetry_ratio=symmetry.ratio,
                symmetry_ratio_sigma=symmetry.ratio_sigma,
                symmetry_angle_percent=symmetry.angle_percent,
            )
        )
    return found


def bands_of(
    patient: Patient, newest: SessionValue, others: Mapping[str, SessionValue]
) -> list[ProgressBand]:
    """Return what a measure is shown beside.

    Parameters
    ----------
    newest : SessionValue
        Of the measure.
    others : mapping of str to SessionValue
        From `other_side_values` or `walked_other_side`.
    """
    found = []
    other = others.get(newest.measure)
    if other is not None:
        found.append(_other_side(patient.affected_side or "", newest, other))
    norm = norm_of(newest.measure, patient.birth_date, newest.at.date())
    if norm is not None:
        first, last = norm.ages
        if norm.meaning == "confidence":
            text = say("progress.norm_confidence", first=first, last=last, source=norm.source)
        else:
            text = say("progress.norm_means", first=first, last=last, source=norm.source)
        found.append(ProgressBand(kind="norm", low=norm.low, high=norm.high, text=text))
    return found


def _other_side(affected: str, newest: SessionValue, other: SessionValue) -> ProgressBand:
    spread = other.spread or 0.0
    symmetry = _symmetry(affected, _reading(newest), _reading(other))
    return ProgressBand(
        kind="other_side",
        low=other.mean - spread,
        high=other.mean + spread,
        text=say("progress.other_side", side=_mirrored(affected), count=other.count),
        value=other.mean,
        symmetry_ratio=symmetry and symmetry.ratio,
        symmetry_ratio_sigma=symmetry and symmetry.ratio_sigma,
        symmetry_angle_percent=symmetry and symmetry.angle_percent,
    )


@dataclass(frozen=True)
class _Symmetry:
    ratio: float
    ratio_sigma: float
    angle_percent: float


def _symmetry(affected: str, newest: _Reading, other: _Reading) -> _Symmetry | None:
    """Return how alike both sides are; None where one of them may be nothing."""
    sigma = max(_standard_error(newest), _standard_error(other))
    ratio = symmetry_ratio(newest.mean, other.mean, sigma)
    if not np.isfinite(ratio):
        return None
    left, right = (newest, other) if affected == "left" else (other, newest)
    return _Symmetry(
        ratio,
        float(np.hypot(_standard_error(newest) / newest.mean, _standard_error(other) / other.mean)),
        100.0 * symmetry_angle(left.mean, right.mean, sigma),
    )


def _reading(value: SessionValue) -> _Reading:
    return _Reading(value.mean, value.spread, value.count)


def _standard_error(value: _Reading) -> float:
    return 0.0 if value.spread is None else value.spread / float(np.sqrt(max(value.count, 1)))


def _mirrored(name: str) -> str:
    return _SIDE.sub(lambda found: "right" if found.group() == "left" else "left", name)
