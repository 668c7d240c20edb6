"""Exercises, and the end of prescriptions; making and listing those is in `app.assessment`, which counts what was
done of them.

Errors: `not_found` for what is out of reach, `not_allowed` when the role or right does not cover the request,
`invalid_input` with the field.
"""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentAccount
from app.database.dependencies import ReadSession, WriteSession
from app.exercises import repository
from app.exercises.schemas import ExerciseChange, ExerciseIn, ExerciseOut

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


@router.patch("/exercises/{exercise_id}")
def change_exercise(
    exercise_id: str, body: ExerciseChange, subject: CurrentAccount, session: WriteSession
) -> ExerciseOut:
    """Change the name, the words or the posture of an exercise of the clinic."""
    return ExerciseOut.model_validate(repository.change_exercise(session, subject, exercise_id, body))


@router.delete("/prescriptions/{prescription_id}", status_code=204)
def delete_prescription(prescription_id: str, subject: CurrentAccount, session: WriteSession) -> None:
    """End a prescription now; what was done for it stays."""
    repository.end_prescription(session, subject, prescription_id)
