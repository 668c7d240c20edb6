"""Measures of a patient's walks over sessions: the same values that progress shows of repetitions of an arm."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from pydantic import TypeAdapter
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.assessment.measures import SessionValue
from app.kinds.walk.stored import PIPELINE
from app.recordings.models import WALK_STREAM, MotionSession, Result, SignalChunk
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


@dataclass(frozen=True)
class _Measure:
    measure: str
    value: float | None
    spread: float | None
    count: int
    unit: str


@dataclass(frozen=True)
class _Foot:
    side: str
    measures: list[_Measure]


@dataclass(frozen=True)
class _Balance:
    measures: list[_Measure]


@dataclass(frozen=True)
class _Test:
    kind: str
    time_s: float
    distance_m: float


@dataclass(frozen=True)
class _Followed:
    """The part of `WalkContent` that is followed over sessions; strides, paths and curves are skipped when read."""

    feet: list[_Foot]
    both: list[_Measure]
    asymmetry: list[_Measure]
    test: _Test | None = None
    balance: _Balance | None = None


_READER: Final = TypeAdapter(_Followed)


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

    Notes
    -----
    One statement for all walks, and of each only its measures are read: strides and curves are nine tenths of it.
    """
    at = func.coalesce(MotionSession.started_at, MotionSession.created_at)
    wanted = (
        select(
            MotionSession.id,
            MotionSession.exercise_id,
            MotionSession.started_at,
            MotionSession.created_at,
            Result.orientation,
            Result.orientation_version,
            Result.pipeline_version,
            SignalChunk.data,
        )
        .join(Result, Result.id == MotionSession.main_result_id)
        .join(
            SignalChunk,
            (SignalChunk.session_id == MotionSession.id) & (SignalChunk.stream == WALK_STREAM + Result.id),
        )
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
    for row in session.execute(wanted):
        for name, one in _chosen(_READER.validate_json(zlib.decompress(row.data))).items():
            if one.value is None:
                continue
            # Parts of one are shown in per cent.
            factor, unit = (100.0, "%") if one.unit == "1" else (1.0, one.unit)
            found.append(
                SessionValue(
                    patient_id=patient_id,
                    exercise_id=row.exercise_id,
                    session_id=row.id,
                    at=row.started_at or row.created_at,
                    measure=_PREFIX + name,
                    unit=unit,
                    mean=factor * one.value,
                    spread=None if one.spread is None else factor * one.spread,
                    count=one.count,
                    orientation=row.orientation,
                    orientation_version=row.orientation_version,
                    pipeline_version=row.pipeline_version,
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


def _chosen(content: _Followed) -> dict[str, _Measure]:
    found: dict[str, _Measure] = {}
    test = content.test
    if test is not None and test.kind == "timed_up_and_go":
        found["test_time"] = _single("test_time", test.time_s, "s")
    if test is not None and test.kind == "six_minute_walk":
        found["test_distance"] = _single("test_distance", test.distance_m, "metres")
    for foot in content.feet:
        found |= {f"{one.measure}:{foot.side}": one for one in foot.measures}
    found |= {f"uneven:{one.measure}": one for one in content.asymmetry}
    balance = content.balance
    found |= {one.measure: one for one in (*content.both, *(balance.measures if balance else ()))}
    return {key: one for key, one in found.items() if key in _LABELS}


def _single(name: str, value: float, unit: str) -> _Measure:
    return _Measure(measure=name, value=value, spread=None, count=1, unit=unit)


__all__ = ["walk_label", "walk_order", "walk_values"]
