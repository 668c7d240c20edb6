"""Reading and storing what a patient says after an exercise."""

from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.database.base import utc_now
from app.exercises.models import Prescription
from app.recordings import repository
from app.recordings.answers.schemas import AnswersIn, AnswersOut
from app.recordings.models import MotionSession, SessionAnswers


def answers_of(session: Session, subject: Subject, session_id: str) -> AnswersOut:
    """Return what was said of a session.

    Raises
    ------
    NotFound, NotAllowed
        The subject may not read the session.
    """
    found = repository.get_session(session, subject, session_id, action="session.answers")
    return stored_answers(session, found.id) or AnswersOut(question=_question(session, found))


def stored_answers(session: Session, session_id: str) -> AnswersOut | None:
    """Return what was said of a session whose access was checked; None before it was."""
    stored = session.get(SessionAnswers, session_id)
    return None if stored is None else _out(stored)


def store(session: Session, subject: Subject, session_id: str, wanted: AnswersIn) -> AnswersOut:
    """Store what was said of a session, beside the question as it is asked now.

    Raises
    ------
    NotFound, NotAllowed
        The session is not the subject's to record.
    """
    found = repository.get_session(session, subject, session_id, "record", action="session.answer")
    question = _question(session, found)
    stored = session.get(SessionAnswers, found.id) or SessionAnswers(session_id=found.id)
    said = wanted.model_dump()
    if stored.answered_at is not None and all(getattr(stored, name) == said[name] for name in said):
        # A telephone that heard no answer sends the same again: nothing new was said.
        return _out(stored)
    for name, value in said.items():
        setattr(stored, name, value)
    stored.most_pain = max((one for one in (stored.most_pain, wanted.pain) if one is not None), default=None)
    stored.question, stored.answered_at, stored.answered_by = question, utc_now(), subject.id
    session.add(stored)
    session.flush()
    return _out(stored)


def _out(stored: SessionAnswers) -> AnswersOut:
    names = ("pain", "effort", "third", "note", "question", "answered_at")
    return AnswersOut(**{name: getattr(stored, name) for name in names})


def _question(session: Session, found: MotionSession) -> str:
    if found.prescription_id is None:
        return ""
    prescription = session.get(Prescription, found.prescription_id)
    return "" if prescription is None else prescription.question
