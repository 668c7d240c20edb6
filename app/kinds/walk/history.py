"""Walks of a patient side by side: the list, and two conditions or two times compared."""

import zlib
from collections.abc import Iterable, Sequence
from typing import Final

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.subject import Subject
from app.errors import InvalidInput
from app.kinds.walk.schemas import (
    ConditionsIn,
    ConditionsOut,
    MeasureChange,
    WalkContent,
    WalkMeasure,
    WalkRow,
)
from app.kinds.walk.stored import PIPELINE, walk_stream
from app.pages import Page
from app.recordings import repository
from app.recordings.models import MotionSession, SignalChunk
from estimators.balance import Sample, compare_conditions
from estimators.errors import ShapeError
from estimators.measures import measures_of
from estimators.sentences import say

_SUFFIX: Final = "_asymmetry"
"""An asymmetry is named `<measure>_asymmetry` in a comparison."""
_LEAST_FOR_SPREAD: Final = 3


def walks_of(session: Session, subject: Subject, patient_id: str, page: Page) -> list[WalkRow]:
    """Return a page of the analysed walks of a patient, newest first.

    Parameters
    ----------
    subject : Subject
        May read the patient.
    """
    rows = []
    for found, exercise, chunk in repository.list_walks(session, subject, patient_id, page):
        content = _content(chunk)
        test = content.test
        rows.append(
            WalkRow(
                session_id=found.id,
                started_at=found.started_at or found.created_at,
                exercise_name=exercise,
                kind=test.kind if test else "walk",
                time_s=test.time_s if test else None,
                distance_m=test.distance_m if test else None,
                speed_mps=test.speed_mps if test else None,
                stride_count=sum(len(foot.strides) for foot in content.feet),
            )
        )
    return rows


def compare(session: Session, subject: Subject, patient_id: str, wanted: ConditionsIn) -> ConditionsOut:
    """Compare the walks of one condition with those of another.

    Raises
    ------
    InvalidInput
        A session is no analysed walk of this patient, or is in both conditions.
    """
    known = repository.sessions_among(session, subject, patient_id, [*wanted.a, *wanted.b])
    audit.record(session, subject, "walks.compare", patient_id)
    if set(wanted.a) & set(wanted.b):
        raise InvalidInput(say("walk.in_both"), field="b")
    sides: list[list[WalkContent]] = []
    for field, ids in (("a", wanted.a), ("b", wanted.b)):
        chosen = [walk_content(session, known[one]) if one in known else None for one in ids]
        contents = [content for content in chosen if content is not None]
        if len(contents) != len(ids):
            raise InvalidInput(say("walk.not_analysed"), field=field)
        sides.append(contents)
    is_paired = len(wanted.a) == len(wanted.b) >= 2
    return ConditionsOut(method="pairs" if is_paired else "strides", changes=changes_between(*sides))


def changes_between(a: Sequence[WalkContent], b: Sequence[WalkContent]) -> list[MeasureChange]:
    """Compare every measure that both conditions have.

    Parameters
    ----------
    a, b : sequence of WalkContent
        Walks of each condition, in order.

    Returns
    -------
    list of MeasureChange
        Each foot, both feet, left against right (named `<measure>_asymmetry`), and balance on instrumented shoes.
    """
    sides = (a, b)
    return [
        *_changes(sides, "left", measures_of("foot")),
        *_changes(sides, "right", measures_of("foot")),
        *_changes(sides, "both", measures_of("both")),
        *_changes(sides, "both", [name + _SUFFIX for name in measures_of("asymmetry")]),
        *_changes(sides, "both", measures_of("balance")),
    ]


def _changes(
    sides: Sequence[Sequence[WalkContent]], foot: str, names: Iterable[str]
) -> Iterable[MeasureChange]:
    for name in names:
        samples = [[_sample(content, foot, name) for content in side] for side in sides]
        try:
            found = compare_conditions(*samples)
        except ShapeError:
            continue
        yield MeasureChange(
            measure=name,
            foot=foot,
            unit=_unit(sides, foot, name),
            a=found.mean_a,
            b=found.mean_b,
            difference=found.difference,
            sigma=_plain(found.sigma),
            p=_plain(found.p),
            effect=_plain(found.effect),
            count=found.count,
            method=found.method,
        )


def _measures(content: WalkContent, foot: str) -> list[WalkMeasure]:
    if foot == "both":
        apart = [one.model_copy(update={"measure": one.measure + _SUFFIX}) for one in content.asymmetry]
        balance = [] if content.balance is None else content.balance.measures
        return [*content.both, *apart, *balance]
    return next((one.measures for one in content.feet if one.side == foot), [])


def _sample(content: WalkContent, foot: str, name: str) -> Sample:
    """Return a measure of a walk with a spread that agrees with its standard error.

    Some measures no single stride has (a variation, an asymmetry), and what the sensors leave uncertain in all strides
    alike (how far the feet are apart) does not average out: strides that scatter by the standard error times the root
    of their number have a mean that is known as well.
    """
    for one in _measures(content, foot):
        if one.measure == name and one.value is not None:
            known = [] if one.spread is None else [one.spread]
            if one.sigma is not None and one.count >= _LEAST_FOR_SPREAD:
                known.append(one.sigma * one.count**0.5)
            return Sample(one.value, max(known, default=float("nan")), one.count)
    return Sample(float("nan"), float("nan"), 0)


def _unit(sides: Sequence[Sequence[WalkContent]], foot: str, name: str) -> str:
    walks = (content for side in sides for content in side)
    found = (one.unit for content in walks for one in _measures(content, foot) if one.measure == name)
    return next(found, "")


def walk_content(session: Session, found: MotionSession) -> WalkContent | None:
    """Return the walk of a session's main result; None where it is none, or not analysed. Access was checked."""
    if found.setup["pipeline"] != PIPELINE or found.main_result_id is None:
        return None
    return stored_walk(session, found.id, found.main_result_id)


def any_walk(session: Session, found: MotionSession) -> WalkContent | None:
    """Return the walk of the main result, or the one beside it where a magnetic source was worn on one shoe.

    Access was checked.
    """
    content = walk_content(session, found)
    beside = repository.results_of(session, found.id) if content is None else []
    for result in reversed(beside):
        if result.pipeline == PIPELINE and content is None:
            content = stored_walk(session, found.id, result.id)
    return content


def stored_walk(session: Session, session_id: str, result_id: str) -> WalkContent | None:
    """Return the walk of a result; None where it has none. Access was checked."""
    row = session.scalar(
        select(SignalChunk).where(
            SignalChunk.session_id == session_id, SignalChunk.stream == walk_stream(result_id)
        )
    )
    return None if row is None else _content(row)


def _content(row: SignalChunk) -> WalkContent:
    return WalkContent.model_validate_json(zlib.decompress(row.data))


def _plain(value: float) -> float | None:
    return value if value == value else None
