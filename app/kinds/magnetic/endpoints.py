"""HTTP of sessions with a magnetic source."""

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession, WriteSession
from app.kinds.magnetic import safety as magnetic
from app.kinds.magnetic.schemas import MagneticSafetyIn, MagneticSafetyOut, SourceUseOut
from app.kinds.magnetic.use import source_use
from app.services import services_of

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get("/sessions/{session_id}/magnetic-safety")
def get_safety(
    session_id: str, request: Request, session: ReadSession, subject: CurrentSubject
) -> MagneticSafetyOut:
    """Return whether the session has a magnetic source, and whether somebody confirmed that it may fire."""
    return magnetic.safety(session, subject, session_id, _hours(request))


@router.post("/sessions/{session_id}/magnetic-safety")
def confirm_safety(
    session_id: str,
    wanted: MagneticSafetyIn,
    request: Request,
    session: WriteSession,
    subject: CurrentSubject,
) -> MagneticSafetyOut:
    """Confirm that neither the patient nor people close by wear a pacemaker or a similar implant.

    Needs the right to treat. Audited: who, when, for which session. Asked again after the hours of the setting
    `TELEMOTION_IMPLANT_CONFIRMATION_HOURS`; `DELETE` takes it back.
    """
    return magnetic.confirm(session, subject, session_id, wanted, _hours(request))


@router.get("/sessions/{session_id}/source-use")
def get_source_use(
    session_id: str, session: ReadSession, subject: CurrentSubject, result_id: str | None = None
) -> SourceUseOut:
    """Return what the source of a session did, its energy account, and the accuracy that it bought."""
    return source_use(session, subject, session_id, result_id)


def _hours(request: Request) -> float:
    return services_of(request).settings.implant_confirmation_hours
