"""Measures of a patient's walks over sessions: the same values that progress shows of repetitions of an arm."""

from collections.abc import Iterator, Sequence
from typing import Final

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.assessment.measures import SessionValue, placed
from app.kinds.walk.stored import PIPELINE
from app.recordings.models import MotionSession, Result
from estimators.conventions import SIDES
from estimators.measures import MEASURES

_PREFIX: Final = "walk:"
_OF_BOTH: Final = "speed"
"""Both feet walk at one speed: it is followed once, by the left foot where that has a sensor."""


def _lines() -> Iterator[tuple[str, str]]:
    """Yield the key and the label of every measure that is followed, the most telling first."""
    for one in MEASURES:
        if one.part == "repetition":
            continue
        if one.label and one.part == "foot":
            is_once = one.name == _OF_BOTH
            yield from (
                (f"{one.name}:{side}", one.label if is_once else f"{one.label}, {side}") for side in SIDES
            )
        elif one.label:
            yield (f"uneven:{one.name}" if one.part == "asymmetry" else one.name), one.label


_LABELS: Final = dict(_lines())
_ORDER: Final = list(_LABELS)


def walk_values(
    session: Session, patient_ids: Sequence[str], exercise_id: str | Sequence[str] | None = None
) -> list[SessionValue]:
    """Return the values of every analysed walk, oldest first within each patient; access was checked.

    Parameters
    ----------
    exercise_id : str or sequence of str, optional
        Only walks of this exercise, or of these.

    Returns
    -------
    list of SessionValue
        Means over the strides that count, with their spread and number; results of a walking test stand alone.

    Notes
    -----
    One statement for all walks, and of each only `Result.followed`: strides and curves are nine tenths of a walk.
    """
    at = func.coalesce(MotionSession.started_at, MotionSession.created_at)
    wanted = (
        select(
            MotionSession.id,
            MotionSession.patient_id,
            MotionSession.exercise_id,
            MotionSession.started_at,
            MotionSession.created_at,
            Result.orientation,
            Result.orientation_version,
            Result.pipeline_version,
            Result.followed,
            MotionSession.setup["placements"].label("worn"),
        )
        .join(Result, Result.id == MotionSession.main_result_id)
        .where(
            MotionSession.patient_id.in_(patient_ids),
            MotionSession.purpose == "exercise",
            Result.pipeline == PIPELINE,
        )
        .order_by(MotionSession.patient_id, at, MotionSession.id)
    )
    if exercise_id is not None:
        of = [exercise_id] if isinstance(exercise_id, str) else exercise_id
        wanted = wanted.where(MotionSession.exercise_id.in_(of))
    found = []
    for row in session.execute(wanted):
        followed = row.followed or ()
        is_twice = any(name == f"{_OF_BOTH}:left" for name, *_ in followed)
        for name, unit, value, spread, count in followed:
            if name not in _LABELS or (is_twice and name == f"{_OF_BOTH}:right"):
                continue
            # Parts of one are shown in per cent.
            factor, shown = (100.0, "%") if unit == "1" else (1.0, unit)
            found.append(
                SessionValue(
                    patient_id=row.patient_id,
                    exercise_id=row.exercise_id,
                    session_id=row.id,
                    at=row.started_at or row.created_at,
                    measure=_PREFIX + name,
                    unit=shown,
                    mean=factor * value,
                    spread=None if spread is None else factor * spread,
                    count=count,
                    orientation=row.orientation,
                    orientation_version=row.orientation_version,
                    pipeline_version=row.pipeline_version,
                    template_version_id="",
                    placements=placed(row.worn),
                )
            )
    return found


def walk_label(measure: str) -> str:
    """Return what a person calls a measure of a walk: `Stride length, left`."""
    return _LABELS[measure.removeprefix(_PREFIX)]


def walk_order(measure: str) -> int:
    """Return the place of a measure among those of a walk, the most telling first."""
    return _ORDER.index(measure.removeprefix(_PREFIX))
