"""HTTP of what therapists draw on templates."""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentSubject
from app.assessment.design import editing
from app.database.dependencies import WriteSession
from app.exercises.schemas import TemplateVersionDetail, TemplateVersionIn

router = APIRouter(prefix="/api", tags=["assessment"])


@router.post("/templates/{template_id}/versions", status_code=201)
def draw_version(
    template_id: str, wanted: TemplateVersionIn, session: WriteSession, subject: CurrentSubject
) -> TemplateVersionDetail:
    """Draw phases, bands and rules on a version's recording: a further version, with who, when and why."""
    return editing.draw(session, subject, template_id, wanted)


__all__ = ["router"]
