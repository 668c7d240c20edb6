"""HTTP of what a therapist must have seen of a patient's sessions."""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentAccount
from app.assessment.worries import service
from app.assessment.worries.schemas import SeenIn, WorryOut
from app.database.dependencies import ReadSession, WriteSession
from app.pages import WantedPage

router = APIRouter(prefix="/api", tags=["patients"])


@router.get("/patients/{patient_id}/worries")
def list_worries(
    patient_id: str, subject: CurrentAccount, session: ReadSession, page: WantedPage
) -> list[WorryOut]:
    """Return what happened in a patient's sessions that a therapist must have seen, seen ones too, newest first."""
    return service.list_worries(session, subject, patient_id, page)


@router.post("/patients/{patient_id}/worries/seen")
def mark_worries_seen(
    patient_id: str, body: SeenIn, subject: CurrentAccount, session: WriteSession
) -> list[WorryOut]:
    """Mark worries as seen and return them as they are now; what a colleague marked before stays the colleague's.

    What became known after `known_at` is not marked by it. Errors: `not_found` for no such worry, `not_allowed` for
    somebody who may not treat the patient.
    """
    return service.mark_seen(session, subject, patient_id, body.worries)
