"""Measures of a patient's walks over sessions: the same values that progress shows of repetitions of an arm."""

from collections.abc import Iterator
from typing import Final

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.assessment.measures import SessionValue
from app.kinds.walk.history import walk_content
from app.kinds.walk.schemas import WalkContent, WalkMeasure
from app.kinds.walk.stored import PIPELINE
from app.recordings.models import MotionSession, Result
from estimators.conventions import SIDES
from estimators.measures import MEASURES

_PREFIX: Final = "walk:"


def _lines() -> Iterator[tuple[str, str]]:
    """Yield the key and the label of every measure that is followed, the most telling first."""
    for one in MEASURES:
        if one.part == "repetition":
            continue
        if one.label and one.part == "foot":
            yield from ((f"{one.name}:{side}", f"{one.label}, {side}") for side in SIDES)
        elif one.label:
            yield (f"uneven:{one.name}" if one.part == "asymmetry" else one.name), one.label


_LABELS: Final = dict(_lines())
_ORDER: Final = list(_LABELS)


def walk_values(session: Session, patient_id: str, exercise_id: str | None = None) -> list[SessionValue]:
    """Return the values of every analysed walk, oldest first; access was checked.

    Parameters
    ----------
    session : Session
    patient_id : str
    exercise_id : str, optional
        Only walks of this exercise.

    Returns
    -------
    list of SessionValue
        Means over the strides that count, with their spread and number; results of a walking test stand alone.
    """
    at = func.coalesce(MotionSession.started_at, MotionSession.created_at)
    wanted = (
        select(MotionSession, Result)
        .join(Result, Result.id == MotionSession.main_result_id)
        .where(
            MotionSession.patient_id == patient_id,
            MotionSession.purpose == "exercise",
            Result.pipeline == PIPELINE,
        )
        .order_by(at, MotionSession.id)
    )
    if exercise_id is not None:
        wanted = wanted.where(MotionSession.exercise_id == exercise_id)
    found = []
    for walked, result in session.execute(wanted):
        content = walk_content(session, walked)
        if content is None:
            continue
        for name, one in _chosen(content).items():
            if one.value is None:
                continue
            # Parts of one are shown in per cent.
            factor, unit = (100.0, "%") if one.unit == "1" else (1.0, one.unit)
            found.append(
                SessionValue(
                    patient_id=patient_id,
                    exercise_id=walked.exercise_id,
                    session_id=walked.id,
                    at=walked.started_at or walked.created_at,
                    measure=_PREFIX + name,
                    unit=unit,
                    mean=factor * one.value,
                    spread=None if one.spread is None else factor * one.spread,
                    count=one.count,
                    orientation=result.orientation,
                    orientation_version=result.orientation_version,
                    pipeline_version=result.pipeline_version,
                    template_version_id="",
                )
            )
    return found


def walk_label(measure: str) -> str:
    """Return what a person calls a measure of a walk: `Stride length, left`."""
    return _LABELS[measure.removeprefix(_PREFIX)]


def walk_order(measure: str) -> int:
    """Return the place of a measure among those of a walk, the most telling first."""
    return _ORDER.index(measure.removeprefix(_PREFIX))


def _chosen(content: WalkContent) -> dict[str, WalkMeasure]:
    found: dict[str, WalkMeasure] = {}
    test = content.test
    if test is not None and test.kind == "timed_up_and_go":
        found["test_time"] = _single("test_time", test.time_s, "s")
    if test is not None and test.kind == "six_minute_walk":
        found["test_distance"] = _single("test_distance", test.distance_m, "metres")
    for foot in content.feet:
        found |= {f"{one.measure}:{foot.side}": one for one in foot.measures}
    found |= {f"uneven:{one.measure}": one for one in content.asymmetry}
    balance = [] if content.balance is None else content.balance.measures
    found |= {one.measure: one for one in [*content.both, *balance]}
    return {key: one for key, one in found.items() if key in _LABELS}


def _single(name: str, value: float, unit: str) -> WalkMeasure:
    return WalkMeasure(measure=name, value=value, sigma=None, spread=None, count=1, unit=unit)


__all__ = ["walk_label", "walk_order", "walk_values"]
