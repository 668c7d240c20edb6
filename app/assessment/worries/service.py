"""Listing a patient's worries and marking them as seen."""

from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.subject import Subject
from app.assessment.models import WorrySeen
from app.assessment.worries.found import place, worries_of
from app.assessment.worries.schemas import SeenWorry, WorryOut
from app.errors import NotAllowed, NotFound
from app.pages import Page
from app.patients.access import require_patient
from app.patients.repository import may_treat
from estimators.sentences import say


def list_worries(session: Session, subject: Subject, patient_id: str, page: Page) -> list[WorryOut]:
    """Return a page of a patient's worries, seen ones too, the newest first.

    Parameters
    ----------
    subject : Subject
        With the level `read`.
    """
    require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "worry.list", patient_id)
    return page.cut(worries_of(session, [patient_id])[patient_id], place)


def mark_seen(session: Session, subject: Subject, patient_id: str, shown: list[SeenWorry]) -> list[WorryOut]:
    """Mark worries as seen, and return them as they are now.

    What a colleague has marked before stays marked by the colleague. What became known after it was shown stays unseen.

    Parameters
    ----------
    subject : Subject
        Who may treat the patient; neither consent nor archive keeps anybody from having seen something.

    Raises
    ------
    NotFound
        The patient has no such worry.
    NotAllowed
        The subject may read, but not treat.
    """
    patient = require_patient(session, subject, patient_id, "read")
    if not may_treat(session, subject, patient):
        raise NotAllowed(say("patient.level", level="treat"), level="treat")
    there = {(one.session_id, one.kind): one for one in worries_of(session, [patient_id])[patient_id]}
    for one in shown:
        worry = there.get((one.session_id, one.kind))
        if worry is None:
            raise NotFound(say("worry.not_found"))
        if worry.seen_at is None:
            known_until = min(one.known_at, worry.known_at)
            session.add(
                WorrySeen(
                    session_id=one.session_id,
                    kind=one.kind,
                    known_until=known_until,
                    seen_by=subject.account_id or "",
                )
            )
            audit.record(session, subject, "worry.seen", patient_id, one.session_id, {"kind": one.kind})
    session.flush()
    marked = {(one.session_id, one.kind) for one in shown}
    return [
        one for one in worries_of(session, [patient_id])[patient_id] if (one.session_id, one.kind) in marked
    ]
