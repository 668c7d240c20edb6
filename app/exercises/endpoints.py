"""Exercises and prescriptions.

Errors: `not_found` for what is out of reach, `not_allowed` when the role or right does not cover the request,
`invalid_input` with the field.
"""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentAccount
from app.database.dependencies import ReadSession, WriteSession
from app.exercises import repository
from app.exercises.models import Prescription
from app.exercises.schemas import ExerciseIn, ExerciseOut, PrescriptionIn, PrescriptionOut

router = APIRouter(prefix="/api", tags=["exercises"])


@router.get("/exercises")
def list_exercises(subject: CurrentAccount, session: ReadSession) -> list[ExerciseOut]:
    """Return the clinic's exercises."""
    return [ExerciseOut.model_validate(row) for row in repository.list_exercises(session, subject)]


@router.post("/exercises", status_code=201)
def create_exercise(body: ExerciseIn, subject: CurrentAccount, session: WriteSession) -> ExerciseOut:
    """Create an exercise of the clinic."""
    return ExerciseOut.model_validate(repository.create_exercise(session, subject, body))


@router.get("/exercises/{exercise_id}")
def read_exercise(exercise_id: str, subject: CurrentAccount, session: ReadSession) -> ExerciseOut:
    """Return an exercise."""
    return ExerciseOut.model_validate(repository.get_exercise(session, subject, exercise_id))


@router.get("/patients/{patient_id}/prescriptions")
def list_prescriptions(
    patient_id: str, subject: CurrentAccount, session: ReadSession
) -> list[PrescriptionOut]:
    """Return what is prescribed now or soon, with the sessions done this week (from Monday, UTC)."""
    return [_out(*row) for row in repository.list_prescriptions(session, subject, patient_id)]


@router.post("/patients/{patient_id}/prescriptions", status_code=201)
def create_prescription(
    patient_id: str, body: PrescriptionIn, subject: CurrentAccount, session: WriteSession
) -> PrescriptionOut:
    """Prescribe an exercise."""
    return _out(*repository.create_prescription(session, subject, patient_id, body))


@router.delete("/prescriptions/{prescription_id}", status_code=204)
def delete_prescription(prescription_id: str, subject: CurrentAccount, session: WriteSession) -> None:
    """End a prescription now; what was done for it stays."""
    repository.end_prescription(session, subject, prescription_id)


def _out(row: Prescription, exercise: str, template: str | None, done: int) -> PrescriptionOut:
    return PrescriptionOut(
        id=row.id,
        exercise_id=row.exercise_id,
        exercise_name=exercise,
        template_id=row.template_id,
        template_name=template,
        repetitions=row.repetitions,
        sets=row.sets,
        times_per_week=row.times_per_week,
        starts_at=row.starts_at,
        ends_at=row.ends_at,
        done_this_week=done,
    )
