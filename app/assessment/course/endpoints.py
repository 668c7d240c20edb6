"""HTTP of the report of a course of therapy."""

from fastapi import APIRouter, Request

from app.accounts.dependencies import CurrentAccount
from app.assessment.course import report
from app.assessment.course.schemas import CourseNoteIn, CourseNoteOut, CourseOut
from app.database.dependencies import ReadSession, WriteSession
from app.services import services_of

router = APIRouter(prefix="/api", tags=["patients"])


@router.get("/patients/{patient_id}/course")
def read_course(
    patient_id: str, exercise_id: str, subject: CurrentAccount, session: ReadSession, request: Request
) -> CourseOut:
    """Return what a course of therapy in one exercise was, with the therapist's words."""
    zone = services_of(request).settings.time_zone
    return report.course(session, subject, patient_id, exercise_id, zone)


@router.post("/patients/{patient_id}/course-notes", status_code=201)
def create_course_note(
    patient_id: str, body: CourseNoteIn, subject: CurrentAccount, session: WriteSession
) -> CourseNoteOut:
    """Store the therapist's words for the report; earlier ones stay stored."""
    return report.write_note(session, subject, patient_id, body)
