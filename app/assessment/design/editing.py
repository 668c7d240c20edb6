"""Changes to templates after they were recorded: each makes a further version, and none changes one that is there."""

from dataclasses import replace

from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment import repository
from app.assessment.design import shown
from app.assessment.design.compiled import apply_design
from app.assessment.design.limits import check_band, check_stops, resting_pose
from app.assessment.design.rules import check_rules
from app.assessment.design.weighted import check_weights
from app.errors import Conflict, InvalidInput
from app.exercises.models import TemplateVersion
from app.exercises.schemas import TemplateVersionDetail, TemplateVersionIn
from estimators.comparison import template_from_bytes
from estimators.sentences import say


def draw(
    session: Session, subject: Subject, template_id: str, wanted: TemplateVersionIn
) -> TemplateVersionDetail:
    """Store a design as a further version, on the recording of the version it is based on.

    Raises
    ------
    NotFound, NotAllowed
        The template is not the subject's to change.
    Conflict
        Somebody saved a version after the one that this is based on: the message says who,
        and its details which version is stored now and since when.
    InvalidInput
        The version is another template's, the design does not fit its curves, or the recording itself or the
        patient at rest breaks a rule of it; the message says where, and with which value.
    """
    template = repository.treated_template(session, subject, template_id)
    base = session.get(TemplateVersion, wanted.based_on)
    if base is None or base.template_id != template.id:
        raise InvalidInput(say("template.no_base"), field="based_on")
    newest = repository.newest_version(session, template.id)
    if newest is not None and newest.number > base.number:
        names = repository.names_of_makers(session, [newest])
        name = names[newest.created_by]
        raise Conflict(
            say(
                "template.changed_meanwhile",
                name=name,
                number=newest.number,
                reason=newest.reason,
            ),
            changed_by=name,
            changed_at=newest.created_at.isoformat(),
            newest=newest.id,
        )
    recorded = template_from_bytes(base.content)
    drawn = apply_design(recorded, wanted.design)
    check_rules(wanted.design, drawn)
    check_weights(wanted.design, recorded)
    reached = shown.reached_of(session, subject, base, drawn)
    if template.patient_id is not None:
        reached = replace(reached, rest=resting_pose(session, template.patient_id, template.exercise_id))
    check_stops(wanted.design.stops or (), reached, "design.stops")
    check_band(reached, recorded, "design.tolerances")
    version = TemplateVersion(
        source_session_id=base.source_session_id,
        source_result_id=base.source_result_id,
        repetitions=base.repetitions,
        tolerance_scale=base.tolerance_scale,
        content=base.content,
        design=wanted.design.model_dump(mode="json"),
        reason=wanted.reason.strip(),
    )
    repository.add_drawn_version(session, subject, template, version)
    return shown.detail_of(session, subject, template, version)
