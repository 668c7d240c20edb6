"""Reading worries from what is stored of sessions, and which of them were seen; access was checked.

A worry is all of one kind in one session. It is there for good: nothing that follows takes it away, and only a mark
that covers all of it (`known_at`) makes it seen.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import Select, or_, select
from sqlalchemy.orm import Session

from app.accounts.models import Account
from app.assessment.course.attention import PAIN
from app.assessment.models import Comparison, WorrySeen
from app.assessment.worries.compensation import compensation_text
from app.assessment.worries.schemas import KINDS, WorryKind, WorryOut
from app.exercises.models import Exercise
from app.recordings.models import DEAD_LINK, MotionSession, SessionAnswers, SessionEvent
from estimators.sentences import say

MUCH_PAIN: Final = 5
"""Of 10, answered after a session: from here on it is a worry."""
STOP_RULES: Final = ("limit", "wrong_in_a_row")
"""Kinds of stop rules that end or pause because of how somebody moves; others end what is done, or what is not seen."""
_STOPPED: Final = ("guidance_stop", "guidance_pause")


@dataclass
class _Facts:
    """What is stored of one session that makes worries."""

    patient_id: str
    began: datetime
    exercise_name: str | None
    events: dict[WorryKind, list[tuple[datetime, float, str]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    """By kind: when it became known, session time and words."""
    answers: Any = None
    compensation: tuple[datetime, dict[str, Any]] | None = None

    @property
    def has_hurt(self) -> bool:
        said = self.answers
        has_much = said is not None and said.most_pain is not None and said.most_pain >= MUCH_PAIN
        return PAIN in self.events or has_much


def worries_of(session: Session, patient_ids: Iterable[str]) -> dict[str, list[WorryOut]]:
    """Return all worries of patients, seen ones too, by patient; the newest first.

    Parameters
    ----------
    patient_ids : iterable of str
        Access was checked.
    """
    ids = list(patient_ids)
    facts = _facts(session, ids)
    marks = _marks(session, ids)
    found: dict[str, list[WorryOut]] = defaultdict(list)
    for session_id, one in facts.items():
        for kind in KINDS:
            if (worry := _worry(session_id, kind, one, marks[session_id, kind])) is not None:
                found[one.patient_id].append(worry)
    for rows in found.values():
        rows.sort(key=place)
    return found


def place(worry: WorryOut) -> list[Any]:
    """Return where a worry stands in the list of a patient, ascending: the newest first."""
    return [-worry.at.timestamp(), worry.session_id, KINDS.index(worry.kind)]


def unseen(worries: Iterable[WorryOut]) -> list[WorryOut]:
    """Return those that wait to be seen: the gravest first, of the same kind the newest.

    Parameters
    ----------
    worries : iterable of WorryOut
        The newest first.
    """
    return sorted((one for one in worries if one.seen_at is None), key=lambda one: KINDS.index(one.kind))


def _facts(session: Session, ids: list[str]) -> dict[str, _Facts]:
    found: dict[str, _Facts] = {}

    def of(row: Any) -> _Facts:
        if row.session_id not in found:
            found[row.session_id] = _Facts(row.patient_id, row.started_at or row.created_at, row.name)
        return found[row.session_id]

    for row in session.execute(_events(ids)):
        kind: WorryKind = PAIN if row.kind == PAIN else "link_lost" if row.kind == DEAD_LINK else "stop"
        of(row).events[kind].append((row.known_at, row.time_s, row.text))
    main: dict[str, Any] = {}
    for row in session.execute(_comparisons(ids)):
        # The newest of the main result says what is so; the first one said it first.
        first = main[row.session_id][0] if row.session_id in main else row.known_at
        main[row.session_id] = first, row
    for first, row in main.values():
        if row.compensation is not None:
            of(row).compensation = first, row.compensation
    for row in session.execute(_answers(ids)):
        if row.session_id in found or (row.most_pain is not None and row.most_pain >= MUCH_PAIN):
            of(row).answers = row
    return found


def _of_sessions(*columns: Any) -> Select[Any]:
    return select(
        *columns, MotionSession.patient_id, MotionSession.started_at, MotionSession.created_at, Exercise.name
    )


def _among(query: Select[Any], table: Any, ids: list[str]) -> Select[Any]:
    return (
        query.join(MotionSession, MotionSession.id == table.session_id)
        .outerjoin(Exercise, Exercise.id == MotionSession.exercise_id)
        .where(MotionSession.patient_id.in_(ids))
    )


def _events(ids: list[str]) -> Select[Any]:
    known = SessionEvent.created_at.label("known_at")
    columns = (SessionEvent.session_id, SessionEvent.kind, SessionEvent.time_s, SessionEvent.text, known)
    is_rule = SessionEvent.kind.in_(_STOPPED) & SessionEvent.details["cause"].as_string().in_(STOP_RULES)
    # Who records a template is no patient who exercises, but pain is pain.
    is_exercised = MotionSession.purpose == "exercise"
    return (
        _among(_of_sessions(*columns), SessionEvent, ids)
        .where(SessionEvent.kind.in_((PAIN, DEAD_LINK, *_STOPPED)))
        .where(or_(SessionEvent.kind == PAIN, is_exercised & or_(SessionEvent.kind == DEAD_LINK, is_rule)))
        .order_by(SessionEvent.created_at, SessionEvent.id)
    )


def _answers(ids: list[str]) -> Select[Any]:
    columns = (
        SessionAnswers.session_id,
        SessionAnswers.pain,
        SessionAnswers.most_pain,
        SessionAnswers.note,
        SessionAnswers.answered_at,
    )
    return _among(_of_sessions(*columns), SessionAnswers, ids)


def _comparisons(ids: list[str]) -> Select[Any]:
    known = Comparison.created_at.label("known_at")
    return (
        _among(_of_sessions(Comparison.session_id, Comparison.compensation, known), Comparison, ids)
        .where(MotionSession.purpose == "exercise", MotionSession.main_result_id == Comparison.result_id)
        .order_by(Comparison.created_at, Comparison.id)
    )


def _marks(session: Session, ids: list[str]) -> dict[tuple[str, str], list[tuple[Any, str | None]]]:
    rows = session.execute(
        select(WorrySeen, Account.display_name)
        .join(MotionSession, MotionSession.id == WorrySeen.session_id)
        .outerjoin(Account, Account.id == WorrySeen.seen_by)
        .where(MotionSession.patient_id.in_(ids))
        .order_by(WorrySeen.created_at, WorrySeen.id)
    )
    marks: dict[tuple[str, str], list[tuple[Any, str | None]]] = defaultdict(list)
    for mark, name in rows:
        marks[mark.session_id, mark.kind].append((mark, name))
    return marks


def _worry(
    session_id: str, kind: WorryKind, facts: _Facts, marks: list[tuple[WorrySeen, str | None]]
) -> WorryOut | None:
    if kind == "compensation" and facts.compensation is not None:
        known_at, found = facts.compensation
        at, text = facts.began, compensation_text(found)
    elif kind == "pain" and facts.has_hurt:
        at, known_at, text = _pain(facts)
    elif kind in facts.events:
        known_at, time_s, text = facts.events[kind][-1]
        at = facts.began + timedelta(seconds=time_s)
    else:
        return None
    # Who was first has seen it.
    seen, name = next(((one, name) for one, name in marks if one.known_until >= known_at), (None, None))
    return WorryOut(
        session_id=session_id,
        kind=kind,
        at=at,
        known_at=known_at,
        text=text,
        words="" if facts.answers is None else facts.answers.note,
        exercise_name=facts.exercise_name,
        seen_at=None if seen is None else seen.created_at,
        seen_by=name,
    )


def _pain(facts: _Facts) -> tuple[datetime, datetime, str]:
    """Return when it hurt, when the newest of it became known, and what is said of it."""
    said, at, known = facts.answers, facts.began, []
    mark = None if said is None else said.most_pain
    text = say("caseload.pain")
    if stopped := facts.events.get(PAIN):
        known_at, time_s, _ = stopped[-1]
        at += timedelta(seconds=time_s)
        known.append(known_at)
        if mark is not None:
            text = say("caseload.pain_marked", mark=mark)
    elif mark is not None:
        text = say("caseload.much_pain", mark=mark)
    if mark is not None and said.pain is not None and said.pain < mark:
        text = say("caseload.pain_corrected", before=text, mark=said.pain)
    if said is not None and (mark is not None or said.note):
        known.append(said.answered_at)
    return at, max(known), text
