"""HTTP of what a patient says after an exercise."""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession, WriteSession
from app.recordings.answers import service
from app.recordings.answers.schemas import AnswersIn, AnswersOut

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get("/sessions/{session_id}/answers")
def get_answers(session_id: str, session: ReadSession, subject: CurrentSubject) -> AnswersOut:
    """Return what the patient said after the exercise, and which question the therapist asks besides."""
    return service.answers_of(session, subject, session_id)


@router.put("/sessions/{session_id}/answers")
def put_answers(
    session_id: str, wanted: AnswersIn, session: WriteSession, subject: CurrentSubject
) -> AnswersOut:
    """Store what the patient says after the exercise; saying it again replaces it."""
    return service.store(session, subject, session_id, wanted)
