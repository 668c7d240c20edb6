"""The request of a gateway that is switched on: which session of its patient to join, and the ticket for it."""

from datetime import datetime

from fastapi import APIRouter, Request
from sqlalchemy import Engine, select

from app.accounts.audit import record
from app.accounts.credentials.tickets import issue_ticket
from app.accounts.dependencies import CurrentDevice
from app.accounts.subject import Subject
from app.database.unit_of_work import unit_of_work
from app.errors import NoOpenSession
from app.live.session.states import OPEN
from app.patients.access import require_patient
from app.recordings.analysis.kinds import kind_of
from app.recordings.models import MotionSession
from app.schemas import Schema, SessionState
from app.services import services_of
from estimators.conventions import Placement
from estimators.sentences import say

router = APIRouter(prefix="/api/devices", tags=["live"])

_JOINED = OPEN - {"failed"}


class NextSessionOut(Schema):
    """A session that waits for its gateway, and a one-use right to open its socket within 30 seconds."""

    session_id: str
    state: SessionState
    pipeline: str
    placements: list[Placement]
    """Where sensors are worn, in the order in which the packets hold them."""
    rate_hz: float
    ticket: str
    expires_at: datetime
    path: str


@router.post("/next-session", responses={404: {}, 409: {}})
def find_next_session(request: Request, subject: CurrentDevice) -> NextSessionOut:
    """Get the open session of the device's patient, with its placements and a ticket for `/ws/ingest`.

    Only with a device token. The newest session is meant that is open and streamed; one that streams already too, so
    that a gateway that was switched off and on finds back. `no_open_session` (404) says that there is none: ask again
    after some seconds. Audited like a ticket.
    """
    services = services_of(request)
    return next_session(services.engine, subject, services.settings.implant_confirmation_hours)


def next_session(engine: Engine, device: Subject, confirmation_hours: float) -> NextSessionOut:
    """Return the newest open session of a device's patient and issue an ingest ticket for it.

    Parameters
    ----------
    device : Subject
        Of a device token; its patient is the only one that is looked at.
    confirmation_hours : float
        How long the word counts that a magnetic source is safe.

    Raises
    ------
    NotAllowed
        The patient is archived or has not agreed to recording at home.
    NoOpenSession
        Nobody has begun a session.
    SafetyUnconfirmed
        The session has a magnetic source that nobody has confirmed to be safe.
    """
    patient_id = device.patient_id or ""
    with unit_of_work(engine) as session:
        require_patient(session, device, patient_id, "record")
        row = session.scalars(
            select(MotionSession)
            .where(
                MotionSession.patient_id == patient_id,
                MotionSession.source == "stream",
                MotionSession.state.in_(_JOINED),
                MotionSession.ended_at.is_(None),
            )
            .order_by(MotionSession.created_at.desc(), MotionSession.id)
            .limit(1)
        ).first()
        if row is None:
            raise NoOpenSession(say("device.no_open_session"))
        kind_of(row.setup).require_safe(session, row, confirmation_hours)
        record(session, device, "session.ticket", patient_id, row.id, {"purpose": "ingest"})
        token, ticket = issue_ticket(session, device, "ingest", row.id)
        return NextSessionOut.model_validate(
            {
                "session_id": row.id,
                "state": row.state,
                "pipeline": row.setup["pipeline"],
                "placements": row.setup["placements"],
                "rate_hz": row.setup["rate_hz"],
                "ticket": token,
                "expires_at": ticket.expires_at,
                "path": "/ws/ingest",
            }
        )
