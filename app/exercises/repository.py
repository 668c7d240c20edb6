"""Exercises and prescriptions: every query, who may, and the audit event it leaves."""

from collections.abc import Sequence
from datetime import datetime

from pydantic_core import to_jsonable_python
from sqlalchemy import or_, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.database.base import new_id, utc_now
from app.errors import Conflict, InvalidInput, NotAllowed, NotFound
from app.exercises.design import StopDesign
from app.exercises.models import Exercise, Prescription, PrescriptionChange, Template
from app.exercises.schemas import ExerciseChange, ExerciseIn, PrescriptionChangeIn, PrescriptionIn
from app.patients.access import require_patient
from app.patients.models import Patient
from estimators.arm import MODEL_ANGLES
from estimators.comparison import TRUNK_CHANNELS
from estimators.gait import GUIDED_KINDS
from estimators.leg import LEG_ANGLES
from estimators.sentences import say

NO_SUCH_PRESCRIPTION = say("prescription.not_found")


def list_exercises(session: Session, subject: Subject) -> list[Exercise]:
    """Return the clinic's exercises by name; they are no patient data."""
    query = select(Exercise).where(Exercise.clinic_id == subject.clinic_id)
    return list(session.scalars(query.order_by(Exercise.name, Exercise.id)))


def get_exercise(session: Session, subject: Subject, exercise_id: str) -> Exercise:
    """Return an exercise of the subject's clinic.

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
    subject : Subject
        A therapist or administrator.

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
    subject : Subject
        A therapist or administrator.

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
    subject : Subject
        With the level `read`.
    """
    require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "prescription.list", patient_id)
    return present_prescriptions(session, patient_id)


def present_prescriptions(session: Session, patient_id: str) -> list[tuple[Prescription, str, str | None]]:
    """Return the same without a question who may; access was checked."""
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
    subject : Subject
        With the level `treat`.

    Raises
    ------
    InvalidInput
        Exercise or template cannot be used for this patient, or the period is empty.
    """
    patient = require_patient(session, subject, patient_id, "treat")
    exercise = session.get(Exercise, body.exercise_id)
    if exercise is None or exercise.clinic_id != patient.clinic_id:
        raise InvalidInput(say("exercise.not_found"), field="exercise_id")
    template = _usable_template(session, patient, exercise, body.template_id)
    prescription = Prescription(
        id=new_id(),
        patient_id=patient_id,
        exercise_id=exercise.id,
        prescribed_by=subject.account_id or subject.id,
        starts_at=_with_zone(body.starts_at, "starts_at") or utc_now(),
    )
    _fill(prescription, body, exercise)
    session.add(prescription)
    session.flush()
    audit.record(session, subject, "prescription.create", patient_id, prescription.id)
    return prescription, exercise.name, template.name if template else None


def change_prescription(
    session: Session, subject: Subject, prescription_id: str, body: PrescriptionChangeIn
) -> tuple[Prescription, str, str | None]:
    """Change what is prescribed; what it was stays, with who and when. Returned as by `create_prescription`.

    Parameters
    ----------
    subject : Subject
        With the level `treat` for its patient.

    Raises
    ------
    NotFound
        No such prescription, or no right to know of it.
    Conflict
        Somebody changed it since it was read: the message says who, its details when; or it has ended.
    InvalidInput
        As of `create_prescription`.
    """
    prescription = _treated(session, subject, prescription_id)
    patient = require_patient(session, subject, prescription.patient_id, "treat")
    exercise = session.get_one(Exercise, prescription.exercise_id)
    if prescription.ends_at is not None and prescription.ends_at <= utc_now():
        raise Conflict(say("prescription.has_ended"))
    number = 1 + len(changes_of(session, [prescription_id])[prescription_id])
    if body.number != number:
        raise _changed_meanwhile(session, prescription_id)
    given = body.model_dump(exclude_unset=True, exclude={"number"})
    now = {name: getattr(prescription, name) for name in PrescriptionIn.model_fields}
    wanted = PrescriptionIn.model_validate({**now, **given})
    template_id = given.get("template_id", prescription.template_id)
    if template_id != prescription.template_id:
        _usable_template(session, patient, exercise, template_id)
        prescription.template_id = template_id
    _fill(prescription, wanted, exercise)
    after = {name: getattr(prescription, name) for name in now}
    before = {name: value for name, value in now.items() if value != after[name]}
    if before:
        change = PrescriptionChange(
            prescription_id=prescription_id,
            number=number,
            before=to_jsonable_python(before),
            changed_by=subject.account_id or subject.id,
        )
        try:
            with session.begin_nested():
                session.add(change)
        except IntegrityError:
            raise _changed_meanwhile(session, prescription_id) from None
        audit.record(
            session, subject, "prescription.change", patient.id, prescription_id, {"fields": sorted(before)}
        )
    template = session.get(Template, prescription.template_id) if prescription.template_id else None
    return prescription, exercise.name, template.name if template else None


def changes_of(
    session: Session, prescription_ids: Sequence[str]
) -> dict[str, list[tuple[PrescriptionChange, str]]]:
    """Return the changes of prescriptions, newest first, each with the name of who made it; access was checked."""
    found: dict[str, list[tuple[PrescriptionChange, str]]] = {one: [] for one in prescription_ids}
    rows = session.execute(
        select(PrescriptionChange, Account.display_name)
        .join(Account, Account.id == PrescriptionChange.changed_by)
        .where(PrescriptionChange.prescription_id.in_(prescription_ids))
        .order_by(PrescriptionChange.number.desc())
    )
    for change, name in rows:
        found[change.prescription_id].append((change, name))
    return found


def _changed_meanwhile(session: Session, prescription_id: str) -> Conflict:
    changes = changes_of(session, [prescription_id])[prescription_id]
    if not changes:
        return Conflict(say("edited.elsewhere"))
    change, name = changes[0]
    return Conflict(
        say("edited.meanwhile", name=name),
        changed_by=name,
        changed_at=change.created_at.isoformat(),
    )


def _usable_template(
    session: Session, patient: Patient, exercise: Exercise, template_id: str | None
) -> Template | None:
    if template_id is None:
        return None
    template = session.get(Template, template_id)
    if (
        template is None
        or template.clinic_id != patient.clinic_id
        or template.exercise_id != exercise.id
        or template.patient_id not in {None, patient.id}
    ):
        raise InvalidInput(say("prescription.no_such_template"), field="template_id")
    if template.retired_at is not None:
        raise InvalidInput(say("template.retired", name=template.name), field="template_id")
    return template


def _fill(prescription: Prescription, body: PrescriptionIn, exercise: Exercise) -> None:
    """Write what is prescribed into a row; raises `InvalidInput` for what cannot be."""
    ends_at = _with_zone(body.ends_at, "ends_at")
    if ends_at is not None and ends_at <= prescription.starts_at:
        raise InvalidInput(say("prescription.ends_before_start"), field="ends_at")
    _check_stops(body.stops, exercise)
    days, times = sorted(set(body.days)), sorted(set(body.times))
    prescription.template_id = body.template_id
    prescription.repetitions, prescription.sets = body.repetitions, body.sets
    prescription.times_per_week = len(days) * max(1, len(times)) if days else body.times_per_week
    prescription.days, prescription.times = days, times
    prescription.tolerance_scale = body.tolerance_scale
    prescription.stops = [one.model_dump(mode="json") for one in body.stops]
    prescription.question = body.question.strip()
    prescription.ends_at = ends_at


def _treated(session: Session, subject: Subject, prescription_id: str) -> Prescription:
    prescription = session.get(Prescription, prescription_id)
    if prescription is None:
        raise NotFound(NO_SUCH_PRESCRIPTION)
    try:
        require_patient(session, subject, prescription.patient_id, "treat")
    except NotFound:
        raise NotFound(NO_SUCH_PRESCRIPTION) from None
    return prescription


def end_prescription(session: Session, subject: Subject, prescription_id: str) -> None:
    """End a prescription now; the sessions made for it stay.

    Parameters
    ----------
    subject : Subject
        With the level `treat` for its patient.

    Raises
    ------
    NotFound
        No such prescription, or no right to know of it.
    """
    prescription = _treated(session, subject, prescription_id)
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
