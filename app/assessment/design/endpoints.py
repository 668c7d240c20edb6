"""HTTP of what therapists draw on templates."""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentSubject
from app.assessment.design import editing, library
from app.database.dependencies import WriteSession
from app.exercises.schemas import (
    TemplateChange,
    TemplateCopyIn,
    TemplateOut,
    TemplateVersionDetail,
    TemplateVersionIn,
)

router = APIRouter(prefix="/api", tags=["assessment"])


@router.post("/templates/{template_id}/versions", status_code=201)
def draw_version(
    template_id: str, wanted: TemplateVersionIn, session: WriteSession, subject: CurrentSubject
) -> TemplateVersionDetail:
    """Draw phases, bands and rules on a version's recording: a further version, with who, when and why."""
    return editing.draw(session, subject, template_id, wanted)


@router.patch("/templates/{template_id}/entry")
def change_template(
    template_id: str, wanted: TemplateChange, session: WriteSession, subject: CurrentSubject
) -> TemplateOut:
    """Rename, tag, retire or restore a template; its versions stay as they are."""
    return library.change(session, subject, template_id, wanted)


@router.post("/template-versions/{version_id}/copies", status_code=201)
def copy_template(
    version_id: str, wanted: TemplateCopyIn, session: WriteSession, subject: CurrentSubject
) -> TemplateVersionDetail:
    """Copy a version as a new template, mirrored where the exercise is of the other side."""
    return library.copy(session, subject, version_id, wanted)
