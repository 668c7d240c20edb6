"""The library of templates: what they are called, which are offered, and copies for another exercise or side."""

from dataclasses import replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.subject import Subject
from app.assessment import repository
from app.assessment.design import shown
from app.assessment.design.compiled import design_of, mirrored_design
from app.database.base import utc_now
from app.errors import InvalidInput
from app.exercises.models import Exercise, TemplateVersion
from app.exercises.repository import create_exercise
from app.exercises.schemas import (
    ExerciseIn,
    TemplateChange,
    TemplateCopyIn,
    TemplateOut,
    TemplateVersionDetail,
)
from estimators.comparison import (
    Template,
    channel_label,
    is_of_stride,
    mirror_template,
    mirrored_name,
    template_from_bytes,
    template_to_bytes,
)
from estimators.conventions import Side
from estimators.sentences import say


def change(session: Session, subject: Subject, template_id: str, wanted: TemplateChange) -> TemplateOut:
    """Rename, tag, retire or restore a template.

    Raises
    ------
    NotFound, NotAllowed
        The template is not the subject's to change.
    """
    template = repository.treated_template(session, subject, template_id)
    given = wanted.model_fields_set
    if given & {"name", "tags"}:
        template.name = wanted.name if "name" in given else template.name
        if "tags" in given:
            template.tags = sorted({tag.strip().lower() for tag in wanted.tags if tag.strip()})
        audit.record(session, subject, "template.change", template.patient_id, template.id)
    if "is_retired" in given and wanted.is_retired != (template.retired_at is not None):
        template.retired_at = utc_now() if wanted.is_retired else None
        action = "template.retire" if wanted.is_retired else "template.restore"
        audit.record(session, subject, action, template.patient_id, template.id)
    session.flush()
    versions = list(
        session.scalars(
            select(TemplateVersion)
            .where(TemplateVersion.template_id == template.id, TemplateVersion.is_published)
            .order_by(TemplateVersion.number.desc())
        )
    )
    return shown.template_out(template, versions, repository.names_of_makers(session, versions))


def copy(
    session: Session, subject: Subject, version_id: str, wanted: TemplateCopyIn
) -> TemplateVersionDetail:
    """Copy a version as a new template, with everything drawn on it; mirrored for an exercise of the other side.

    Raises
    ------
    NotFound, NotAllowed
        The version is not the subject's to use, or the patient not theirs to treat.
    InvalidInput
        A patient's template can be copied for that patient only; the exercise must have an angle of the template.
    """
    source, version = repository.get_version(session, subject, version_id, audited=False)
    repository.treated_template(session, subject, source.id)
    if source.patient_id is not None and source.patient_id != wanted.patient_id:
        raise InvalidInput(say("template.other_patient"), field="patient_id")
    recorded, design = template_from_bytes(version.content), design_of(version)
    own = session.get_one(Exercise, source.exercise_id)
    is_walk = is_of_stride(recorded.primary_channel)
    if wanted.exercise_id is not None:
        exercise = repository.exercise_of(session, subject, wanted.exercise_id)
    else:
        # A walk is of both feet: the other foot is one of the same exercise.
        exercise = own if is_walk else _across(session, subject, own)
    if wanted.exercise_id is None if is_walk else exercise.side != recorded.side:
        recorded, design = mirror_template(recorded), mirrored_design(design, recorded)
    made = TemplateVersion(
        source_session_id=version.source_session_id,
        source_result_id=version.source_result_id,
        repetitions=version.repetitions,
        tolerance_scale={
            mirrored_name(name) if name not in recorded.channels else name: factor
            for name, factor in version.tolerance_scale.items()
        },
        content=template_to_bytes(_led_by(recorded, exercise)),
        design=design.model_dump(mode="json"),
        reason=wanted.reason.strip(),
    )
    template = repository.add_version(
        session, subject, None, exercise, wanted.patient_id, wanted.name.strip(), made
    )
    template.tags = source.tags
    return shown.detail_of(session, subject, template, made)


def _led_by(recorded: Template, exercise: Exercise) -> Template:
    """Return the template with the main angle of an exercise; that of a walk leads itself."""
    if not exercise.primary_angle and is_of_stride(recorded.primary_channel):
        return recorded
    if not exercise.primary_angle:
        raise InvalidInput(say("template.other_kind"), field="exercise_id")
    if exercise.primary_angle not in recorded.channels:
        name = channel_label(exercise.primary_angle)
        raise InvalidInput(say("template.other_angle", name=name), field="exercise_id")
    return replace(recorded, primary_channel=exercise.primary_angle)


def _across(session: Session, subject: Subject, exercise: Exercise) -> Exercise:
    """Return the same exercise of the other side; added where the clinic has none."""
    side: Side = "left" if exercise.side == "right" else "right"
    angle = mirrored_name(exercise.primary_angle)
    there = session.scalars(
        select(Exercise).where(
            Exercise.clinic_id == subject.clinic_id,
            Exercise.movement == exercise.movement,
            Exercise.side == side,
            Exercise.primary_angle == angle,
        )
    ).all()
    if there:
        return next((one for one in there if one.name == exercise.name), there[0])
    body = ExerciseIn.model_validate(
        {
            "name": exercise.name,
            "description": exercise.description,
            "movement": exercise.movement,
            "side": side,
            "primary_angle": angle,
        }
    )
    return create_exercise(session, subject, body)
