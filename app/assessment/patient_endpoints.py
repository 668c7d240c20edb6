"""HTTP of what is drawn together about a patient: the caseload, progress, and prescriptions with what was done.

The paths are those of patients; the code is here because it reads recordings and comparisons, which the room
`patients` does not know.
"""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentAccount
from app.assessment import practice
from app.assessment.caseload import caseload
from app.assessment.progress import progress
from app.assessment.schemas import CaseloadRow, Progress
from app.database.dependencies import ReadSession, WriteSession
from app.exercises.schemas import PrescriptionIn, PrescriptionOut

router = APIRouter(prefix="/api")


@router.get("/caseload", tags=["patients"])
def read_caseload(subject: CurrentAccount, session: ReadSession) -> list[CaseloadRow]:
    """Return one line per patient in reach, those with a reason to look first."""
    return caseload(session, subject)


@router.get("/patients/{patient_id}/progress", tags=["patients"])
def read_progress(
    patient_id: str, subject: CurrentAccount, session: ReadSession, exercise_id: str | None = None
) -> Progress:
    """Return progress in one exercise; without `exercise_id` in the one practised last."""
    return progress(session, subject, patient_id, exercise_id)


@router.get("/patients/{patient_id}/prescriptions", tags=["exercises"])
def list_prescriptions(
    patient_id: str, subject: CurrentAccount, session: ReadSession
) -> list[PrescriptionOut]:
    """Return what is prescribed now or soon, with the sessions done this week (from Monday, UTC)."""
    return practice.list_prescriptions(session, subject, patient_id)


@router.post("/patients/{patient_id}/prescriptions", status_code=201, tags=["exercises"])
def create_prescription(
    patient_id: str, body: PrescriptionIn, subject: CurrentAccount, session: WriteSession
) -> PrescriptionOut:
    """Prescribe an exercise."""
    return practice.prescribe(session, subject, patient_id, body)


__all__ = ["router"]
