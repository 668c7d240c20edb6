"""HTTP of putting records right: a session under the wrong patient or exercise, two records of one person."""

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentAccount
from app.assessment.records.merging import merge
from app.assessment.records.moving import change
from app.assessment.records.schemas import MergeIn, MergeOut, SessionPatch
from app.database.dependencies import WriteSession
from app.recordings import service
from app.recordings.analysis.jobs import JobRunner
from app.recordings.schemas import SessionDetail
from app.services import services_of

router = APIRouter(prefix="/api")


@router.patch("/sessions/{session_id}", tags=["sessions"])
def change_session(
    session_id: str, wanted: SessionPatch, request: Request, session: WriteSession, subject: CurrentAccount
) -> SessionDetail:
    """Move a session to the patient who did it, or to the exercise that it was; it is compared again.

    Errors: `conflict` while it is live or being analysed, and where a template of the patient was made from it.
    """
    found = change(session, subject, session_id, wanted)
    services_of(request).get(JobRunner).wake()
    return service.detail(session, subject, found.id)


@router.post("/patients/{patient_id}/merge", tags=["patients"])
def merge_patients(
    patient_id: str, wanted: MergeIn, session: WriteSession, subject: CurrentAccount
) -> MergeOut:
    """Move everything of another record of the same person into this one; the other stays in the archive, empty."""
    return merge(session, subject, patient_id, wanted)
