"""Exercises and prescriptions: every query, who may, and the audit event it leaves."""

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy import or_, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.subject import Subject
from app.database.base import new_id, utc_now
from app.errors import InvalidInput, NotAllowed, NotFound
from app.exercises.design import StopDesign
from app.exercises.models import Exercise, Prescription, Template
from app.exercises.schemas import ExerciseChange, ExerciseIn, PrescriptionIn
from app.patients.access import require_patient
from app.sentences import say
from estimators.arm import MODEL_ANGLES
from estimators.comparison import TRUNK_CHANNELS
from estimators.gait import GUIDED_KINDS
from estimators.leg import LEG_ANGLES

NO_SUCH_PRESCRIPTION = say("prescription.not_found")


def list_exercises(session: Session, subject: Subject) -> list[Exercise]:
    """Return the clinic's exercises by name; they are no patient data.

    Parameters
    ----------
    session : Session
    subject : Subject
    """
    query = select(Exercise).where(Exercise.clinic_id == subject.clinic_id)
    return list(session.scalars(query.order_by(Exercise.name, Exercise.id)))


def get_exercise(session: Session, subject: Subject, exercise_id: str) -> Exercise:
    """Return an exercise of the subject's clinic.

    Parameters
    ----------
    session : Session
    subject : Subject
    exercise_id : str

    Raises
    ------
    NotFound
        No such exercise in this clinic.
    """
    exercise = session.get(Exercise, exercise_id)
    if exercise is None or exercise.clinic_id != subject.clinic_id:
        raise NotFound(say("exercise.not_found"))
    return exercise


def create_exercise(session: Session, subject: Subject, body: ExerciseIn) -> Exercise:
    """Store a new exercise of the clinic.

    Parameters
    ----------
    session : Session
    subject : Subject
        A therapist or administrator.
    body : ExerciseIn

    Raises
    ------
    NotAllowed
        Another role.
    InvalidInput
        The primary angle is not a joint angle of the exercise's side.
    """
    _require_staff(subject)
    known = [""] if body.movement in GUIDED_KINDS else joint_angles(body.side)
    if body.primary_angle not in known:
        raise InvalidInput(
            say("exercise.walk_angle") if known == [""] else say("exercise.angle", side=body.side),
            field="primary_angle",
            allowed=known,
        )
    exercise = Exercise(id=new_id(), clinic_id=subject.clinic_id, **body.model_dump())
    session.add(exercise)
    session.flush()
    audit.record(session, subject, "exercise.create", None, exercise.id)
    return exercise


def change_exercise(session: Session, subject: Subject, exercise_id: str, body: ExerciseChange) -> Exercise:
    """Change what an exercise of the clinic is called, its words, or how it is done.

    Parameters
    ----------
    session : Session
    subject : Subject
        A therapist or administrator.
    exercise_id : str
    body : ExerciseChange

    Raises
    ------
    NotAllowed
        Another role.
    NotFound
        No such exercise in this clinic.
    """
    _require_staff(subject)
    exercise = get_exercise(session, subject, exercise_id)
    for name, value in body.model_dump(exclude_unset=True).items():
        setattr(exercise, name, value)
    session.flush()
    audit.record(session, subject, "exercise.change", None, exercise.id)
    return exercise


def _require_staff(subject: Subject) -> None:
    if subject.role not in {"therapist", "administrator", "system"}:
        raise NotAllowed(say("exercise.create_not_allowed"))


def joint_angles(side: str) -> list[str]:
    """Return the names of the joint angles of one side, of arm and leg.

    Parameters
    ----------
    side : {"left", "right"}
    """
    return [name for name in (*MODEL_ANGLES, *LEG_ANGLES) if f"_{side}_" in name]


def list_prescriptions(
    session: Session, subject: Subject, patient_id: str
) -> list[tuple[Prescription, str, str | None]]:
    """Return a patient's present and coming prescriptions, with the names of exercise and template.

    Parameters
    ----------
    session : Session
    subject : Subject
        With the level `read`.
    patient_id : str
    """
    require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "prescription.list", patient_id)
    return present_prescriptions(session, patient_id)


def present_prescriptions(session: Session, patient_id: str) -> list[tuple[Prescription, str, str | None]]:
    """Return the same without a question who may; access was checked.

    Parameters
    ----------
    session : Session
    patient_id : str
    """
    now = utc_now()
    rows = session.execute(
        select(Prescription, Exercise.name, Template.name)
        .join(Exercise, Exercise.id == Prescription.exercise_id)
        .outerjoin(Template, Template.id == Prescription.template_id)
        .where(
            Prescription.patient_id == patient_id,
            or_(Prescription.ends_at.is_(None), Prescription.ends_at > now),
        )
        .order_by(Prescription.starts_at, Prescription.id)
    ).all()
    return [(prescription, exercise, template) for prescription, exercise, template in rows]


def create_prescription(
    session: Session, subject: Subject, patient_id: str, body: PrescriptionIn
) -> tuple[Prescription, str, str | None]:
    """Prescribe an exercise; returned with the names of exercise and template.

    Parameters
    ----------
    session : Session
    subject : Subject
        With the level `treat`.
    patient_id : str
    body : PrescriptionIn

    Raises
    ------
    InvalidInput
        Exercise or template cannot be used for this patient, or the period is empty.
    """
    patient = require_patient(session, subject, patient_id, "treat")
    exercise = session.get(Exercise, body.exercise_id)
    if exercise is None or exercise.clinic_id != patient.clinic_id:
        raise InvalidInput(say("exercise.not_found"), field="exercise_id")
    template = None
    if body.template_id is not None:
        template = session.get(Template, body.template_id)
        if (
            template is None
            or template.clinic_id != patient.clinic_id
            or template.exercise_id != exercise.id
            or template.patient_id not in {None, patient_id}
        ):
            raise InvalidInput(say("prescription.no_such_template"), field="template_id")
        if template.retired_at is not None:
            raise InvalidInput(say("template.retired", name=template.name), field="template_id")
    starts_at = _with_zone(body.starts_at, "starts_at") or utc_now()
    ends_at = _with_zone(body.ends_at, "ends_at")
    if ends_at is not None and ends_at <= starts_at:
        raise InvalidInput(say("prescription.ends_before_start"), field="ends_at")
    days = sorted(set(body.days))
    times = sorted(set(body.times))
    _check_stops(body.stops, exercise)
    prescription = Prescription(
        id=new_id(),
        patient_id=patient_id,
        exercise_id=exercise.id,
        template_id=body.template_id,
        repetitions=body.repetitions,
        sets=body.sets,
        times_per_week=len(days) * max(1, len(times)) if days else body.times_per_week,
        days=days,
        times=times,
        tolerance_scale=body.tolerance_scale,
        stops=[one.model_dump(mode="json") for one in body.stops],
        question=body.question.strip(),
        prescribed_by=subject.account_id or subject.id,
        starts_at=starts_at,
        ends_at=ends_at,
    )
    session.add(prescription)
    session.flush()
    audit.record(session, subject, "prescription.create", patient_id, prescription.id)
    return prescription, exercise.name, template.name if template else None


def end_prescription(session: Session, subject: Subject, prescription_id: str) -> None:
    """End a prescription now; the sessions made for it stay.

    Parameters
    ----------
    session : Session
    subject : Subject
        With the level `treat` for its patient.
    prescription_id : str

    Raises
    ------
    NotFound
        No such prescription, or no right to know of it.
    """
    prescription = session.get(Prescription, prescription_id)
    if prescription is None:
        raise NotFound(NO_SUCH_PRESCRIPTION)
    try:
        require_patient(session, subject, prescription.patient_id, "treat")
    except NotFound:
        raise NotFound(NO_SUCH_PRESCRIPTION) from None
    now = utc_now()
    if prescription.ends_at is None or prescription.ends_at > now:
        prescription.starts_at = min(prescription.starts_at, now)
        prescription.ends_at = now
    audit.record(session, subject, "prescription.end", prescription.patient_id, prescription.id)


def _check_stops(stops: Sequence[StopDesign], exercise: Exercise) -> None:
    angles = {*joint_angles(exercise.side), *TRUNK_CHANNELS}
    for number, one in enumerate(stops, start=1):
        if (one.kind == "limit" and one.channel not in angles) or (one.kind != "limit" and one.limit <= 0.0):
            raise InvalidInput(say("design.stop", number=number), field=f"stops.{number - 1}")


def _with_zone(value: datetime | None, field: str) -> datetime | None:
    if value is not None and value.tzinfo is None:
        raise InvalidInput(say("prescription.time_needs_zone"), field=field)
    return value
