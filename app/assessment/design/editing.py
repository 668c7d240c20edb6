"""Changes to templates after they were recorded: each makes a further version, and none changes one that is there."""

from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment import repository
from app.assessment.design import shown
from app.assessment.design.compiled import apply_design
from app.assessment.design.rules import check_rules
from app.assessment.design.weighted import check_weights
from app.errors import InvalidInput
from app.exercises.models import TemplateVersion
from app.exercises.schemas import TemplateVersionDetail, TemplateVersionIn
from app.sentences import say
from estimators.comparison import template_from_bytes


def draw(
    session: Session, subject: Subject, template_id: str, wanted: TemplateVersionIn
) -> TemplateVersionDetail:
    """Store a design as a further version, on the recording of the version it is based on.

    Raises
    ------
    NotFound, NotAllowed
        The template is not the subject's to change.
    InvalidInput
        The version is another template's, or the design does not fit its curves; the message says where.
    """
    template = repository.treated_template(session, subject, template_id)
    base = session.get(TemplateVersion, wanted.based_on)
    if base is None or base.template_id != template.id:
        raise InvalidInput(say("template.no_base"), field="based_on")
    recorded = template_from_bytes(base.content)
    check_rules(wanted.design, apply_design(recorded, wanted.design))
    check_weights(wanted.design, recorded)
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


__all__ = ["draw"]
