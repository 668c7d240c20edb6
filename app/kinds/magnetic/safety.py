"""Sessions with a magnetic source: nobody with a pacemaker may be near one, and somebody must have made sure.

The field beside a coil exceeds the limit of pacemakers and similar implants. Until a therapist has confirmed, for this
session, that neither the patient nor people close by have one, no gateway gets in: no coil is ever asked to fire.
The confirmation is an event of the session and in the audit trail: who, when, for which session. It holds for some
hours; a therapist can take it back, and the source stops at once.
"""

import math
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import Conflict, SafetyUnconfirmed
from app.kinds.magnetic.schemas import MagneticSafetyIn, MagneticSafetyOut
from app.recordings import repository
from app.recordings.models import MotionSession, SessionEvent
from estimators.errors import SetupError
from estimators.magnetic import PACEMAKER_LIMIT_T, keep_away_distance_m
from estimators.pipelines import (
    NOMINAL_GAIN_SIGMA,
    RelativePosePipeline,
    SessionSetup,
    SourceSettings,
    relative_source,
)
from estimators.sentences import say

PIPELINE: Final = RelativePosePipeline.name
EVENT: Final = "implants_excluded"
WITHDRAWN: Final = "implants_withdrawn"
CONFIRMATION_HOURS: Final = 12.0
"""Who was in the room yesterday says nothing of today."""
WARNING: Final = say("magnetic.warning")
NO_LONGER_CONFIRMED: Final = say("magnetic.withdrawn")
EXPIRED: Final = say("magnetic.expired")
NOT_CONFIRMED: Final = say("magnetic.not_confirmed")
# Asked again and again while a source fires: a statement that is built again leaves cycles behind.
_WORDS: Final = select(SessionEvent).where(
    SessionEvent.session_id == bindparam("session_id"), SessionEvent.kind.in_((EVENT, WITHDRAWN))
)


def confirm(
    session: Session,
    subject: Subject,
    session_id: str,
    wanted: MagneticSafetyIn,
    hours: float = CONFIRMATION_HOURS,
) -> MagneticSafetyOut:
    """Note the therapist's confirmation for one session; saying it twice while it holds is saying it once.

    Raises
    ------
    Conflict
        The session has no magnetic source.
    """
    found = repository.get_session(session, subject, session_id, "treat", action="")
    if found.setup["pipeline"] != PIPELINE:
        raise Conflict(say("magnetic.nothing_to_confirm"))
    if not _word(session, found.id).holds(hours):
        said = wanted.model_dump()
        audit.record(session, subject, "session.implants_excluded", found.patient_id, found.id, said)
        session.add(
            SessionEvent(
                session_id=found.id,
                kind=EVENT,
                time_s=0.0,
                text=say("magnetic.event_confirmed"),
                details={"by": subject.id, "at": utc_now().isoformat(), **said},
            )
        )
        session.flush()
    return _told(session, subject, found, hours)


def withdraw(
    session: Session, subject: Subject, session_id: str, hours: float = CONFIRMATION_HOURS
) -> MagneticSafetyOut:
    """Note that a therapist takes the confirmation back; whoever runs the source stops it.

    Raises
    ------
    Conflict
        The session has no magnetic source, or nothing is confirmed.
    """
    found = repository.get_session(session, subject, session_id, "treat", action="")
    if found.setup["pipeline"] != PIPELINE:
        raise Conflict(say("magnetic.nothing_to_withdraw"))
    if not _word(session, found.id).holds(hours):
        raise Conflict(say("magnetic.not_confirmed_yet"))
    audit.record(session, subject, "session.implants_withdrawn", found.patient_id, found.id)
    session.add(
        SessionEvent(
            session_id=found.id,
            kind=WITHDRAWN,
            time_s=0.0,
            text=say("magnetic.event_withdrawn"),
            details={"by": subject.id, "at": utc_now().isoformat()},
        )
    )
    session.flush()
    return _told(session, subject, found, hours)


def safety(
    session: Session, subject: Subject, session_id: str, hours: float = CONFIRMATION_HOURS
) -> MagneticSafetyOut:
    """Return whether a session has a source, and whether it may fire."""
    return _told(session, subject, repository.get_session(session, subject, session_id), hours)


def require_confirmed(session: Session, found: MotionSession, hours: float = CONFIRMATION_HOURS) -> None:
    """Refuse to start a session with a magnetic source that nobody has confirmed to be safe within `hours`.

    Raises
    ------
    SafetyUnconfirmed
        With the session and what to do.
    """
    if found.setup.get("pipeline") != PIPELINE:
        return
    word = _word(session, found.id)
    if not word.holds(hours):
        raise SafetyUnconfirmed(
            NOT_CONFIRMED
            if word.confirmed_at is None
            else NO_LONGER_CONFIRMED
            if word.withdrawn_at
            else EXPIRED,
            session_id=found.id,
            confirm=f"POST /api/sessions/{found.id}/magnetic-safety",
        )


@dataclass(frozen=True)
class _Word:
    """The newest word on a session."""

    confirmed_at: datetime | None = None
    confirmed_by: str | None = None
    withdrawn_at: datetime | None = None
    withdrawn_by: str | None = None

    def expires_at(self, hours: float) -> datetime | None:
        return None if self.confirmed_at is None else self.confirmed_at + timedelta(hours=hours)

    def holds(self, hours: float) -> bool:
        end = self.expires_at(hours)
        return end is not None and self.withdrawn_at is None and utc_now() < end


def _word(session: Session, session_id: str) -> _Word:
    events = session.scalars(_WORDS, {"session_id": session_id})
    word = _Word()
    for event in sorted(events, key=lambda one: str(one.details["at"])):
        at, by = datetime.fromisoformat(event.details["at"]), event.details.get("by")
        word = _Word(at, by) if event.kind == EVENT else replace(word, withdrawn_at=at, withdrawn_by=by)
    return word


def _told(session: Session, subject: Subject, found: MotionSession, hours: float) -> MagneticSafetyOut:
    is_magnetic = found.setup["pipeline"] == PIPELINE
    word = _word(session, found.id) if is_magnetic else _Word()

    def name(by: str | None) -> str | None:
        if subject.role not in ("therapist", "administrator") or by is None:
            return None
        account = session.get(Account, by)
        return None if account is None else account.display_name

    settings, away = _source_of(found.setup) if is_magnetic else (None, None)
    return MagneticSafetyOut(
        required=is_magnetic,
        confirmed=word.holds(hours),
        confirmed_at=word.confirmed_at,
        confirmed_by=name(word.confirmed_by),
        expires_at=word.expires_at(hours),
        withdrawn_at=word.withdrawn_at,
        withdrawn_by=name(word.withdrawn_by),
        source=None if settings is None else settings.source,
        keep_away_m=away,
        source_name="" if settings is None else settings.source_name,
        source_serial="" if settings is None else settings.source_serial,
        calibrated_on="" if settings is None else settings.calibrated_on,
        gain_sigma=None if settings is None else _gain_sigma(found.setup),
        limit_t=PACEMAKER_LIMIT_T,
        warning=WARNING if is_magnetic else "",
    )


def _gain_sigma(setup: dict[str, Any]) -> float:
    return float(setup.get("orientation_parameters", {}).get("gain_sigma", NOMINAL_GAIN_SIGMA))


def _source_of(setup: dict[str, Any]) -> tuple[SourceSettings | None, float | None]:
    try:
        settings = relative_source(SessionSetup.from_dict(setup))
        source = settings.coils
        out_m = max(math.dist(coil.centre_m, (0.0, 0.0, 0.0)) for coil in source.coils)
        # From the middle of the source, to the next centimetre: a distance stated to people must not be too short.
        return settings, math.ceil(100.0 * (out_m + keep_away_distance_m(source))) / 100.0
    except SetupError:
        return None, None
