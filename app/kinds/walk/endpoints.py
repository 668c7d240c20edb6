"""Routes of walks: one in numbers, those of a patient, and two conditions compared."""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession
from app.kinds.walk.history import compare, walks_of
from app.kinds.walk.schemas import ConditionsIn, ConditionsOut, GaitOut, WalkRow
from app.kinds.walk.stored import gait
from app.pages import WantedPage

router = APIRouter(prefix="/api", tags=["walks"])


@router.get("/sessions/{session_id}/gait")
def get_gait(
    session_id: str, session: ReadSession, subject: CurrentSubject, result_id: str | None = None
) -> GaitOut:
    """Return a walk: footprints, strides, numbers of each foot with uncertainty and count, and their asymmetry."""
    return gait(session, subject, session_id, result_id)


@router.get("/patients/{patient_id}/walks")
def list_walks(
    patient_id: str, session: ReadSession, subject: CurrentSubject, page: WantedPage
) -> list[WalkRow]:
    """Return the analysed walks of a patient, newest first."""
    return walks_of(session, subject, patient_id, page)


@router.post("/patients/{patient_id}/walks/comparison")
def compare_walks(
    patient_id: str, body: ConditionsIn, session: ReadSession, subject: CurrentSubject
) -> ConditionsOut:
    """Compare the walks of one condition with those of another, measure by measure; nothing is stored."""
    return compare(session, subject, patient_id, body)


__all__ = ["router"]
