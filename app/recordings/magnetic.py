"""Sessions with a magnetic source: nobody with a pacemaker may be near one, and somebody must have made sure.

The field beside a coil exceeds the limit of pacemakers and similar implants. Until a therapist has confirmed, for this
session, that neither the patient nor people close by have one, no gateway gets in: no coil is ever asked to fire.
The confirmation is an event of the session and in the audit trail: who, when, for which session.
"""

import math
from typing import Any, Final

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import Conflict, SafetyUnconfirmed
from app.recordings import repository
from app.recordings.magnetic_schemas import MagneticSafetyIn, MagneticSafetyOut
from app.recordings.models import MotionSession, SessionEvent
from estimators.errors import SetupError
from estimators.magnetic import PACEMAKER_LIMIT_T, keep_away_distance_m
from estimators.pipelines import RelativePosePipeline, SessionSetup, relative_source

PIPELINE: Final = RelativePosePipeline.name
EVENT: Final = "implants_excluded"
WARNING: Final = (
    "The source makes magnetic pulses. Nobody with a pacemaker, an implanted defibrillator, a nerve stimulator, a"
    " cochlear implant or a medicine pump may wear it or be close to it while it is worn."
)
NOT_CONFIRMED: Final = (
    "This session has a magnetic source: before it can start, the therapist must confirm that neither the patient nor"
    " people close by wear a pacemaker or a similar implant."
)


def confirm(
    session: Session, subject: Subject, session_id: str, wanted: MagneticSafetyIn
) -> MagneticSafetyOut:
    """Note the therapist's confirmation for one session; saying it twice is saying it once.

    Raises
    ------
    Conflict
        The session has no magnetic source.
    """
    found = repository.get_session(session, subject, session_id, "treat", action="")
    if found.setup["pipeline"] != PIPELINE:
        raise Conflict("This session has no magnetic source; there is nothing to confirm.")
    if _event(session, found.id) is None:
        said = wanted.model_dump()
        audit.record(session, subject, "session.implants_excluded", found.patient_id, found.id, said)
        session.add(
            SessionEvent(
                session_id=found.id,
                kind=EVENT,
                time_s=0.0,
                text="No implants: confirmed",
                details={"by": subject.id, "at": utc_now().isoformat(), **said},
            )
        )
        session.flush()
    return _told(session, subject, found)


def safety(session: Session, subject: Subject, session_id: str) -> MagneticSafetyOut:
    """Return whether a session has a source, and whether it may fire."""
    return _told(session, subject, repository.get_session(session, subject, session_id))


def require_confirmed(session: Session, found: MotionSession) -> None:
    """Refuse to start a session with a magnetic source that nobody has confirmed to be safe.

    Raises
    ------
    SafetyUnconfirmed
        With the session and what to do.
    """
    if found.setup.get("pipeline") == PIPELINE and _event(session, found.id) is None:
        raise SafetyUnconfirmed(
            NOT_CONFIRMED,
            session_id=found.id,
            confirm=f"POST /api/sessions/{found.id}/magnetic-safety",
        )


def _event(session: Session, session_id: str) -> SessionEvent | None:
    return session.scalars(
        select(SessionEvent).where(SessionEvent.session_id == session_id, SessionEvent.kind == EVENT)
    ).first()


def _told(session: Session, subject: Subject, found: MotionSession) -> MagneticSafetyOut:
    is_magnetic = found.setup["pipeline"] == PIPELINE
    event = _event(session, found.id) if is_magnetic else None
    details: dict[str, Any] = {} if event is None else event.details
    name = None
    if subject.role in ("therapist", "administrator") and "by" in details:
        account = session.get(Account, details["by"])
        name = None if account is None else account.display_name
    worn, away = None, None
    if is_magnetic:
        worn, away = _source_of(found.setup)
    return MagneticSafetyOut(
        required=is_magnetic,
        confirmed=event is not None,
        confirmed_at=details.get("at"),
        confirmed_by=name,
        source=worn,
        keep_away_m=away,
        limit_t=PACEMAKER_LIMIT_T,
        warning=WARNING if is_magnetic else "",
    )


def _source_of(setup: dict[str, Any]) -> tuple[str | None, float | None]:
    try:
        settings = relative_source(SessionSetup.from_dict(setup))
        source = settings.coils
        out_m = max(math.dist(coil.centre_m, (0.0, 0.0, 0.0)) for coil in source.coils)
        # From the middle of the source, to the next centimetre: what is told to people must not be too short.
        return settings.source, math.ceil(100.0 * (out_m + keep_away_distance_m(source))) / 100.0
    except SetupError:
        return None, None


__all__ = ["EVENT", "NOT_CONFIRMED", "PIPELINE", "WARNING", "confirm", "require_confirmed", "safety"]
