"""HTTP of templates and comparisons.

Building and comparing are done before the writing transaction is opened, because it holds the database's one
write lock.
"""

from typing import Annotated

from fastapi import APIRouter, Query, Request

from app.accounts.dependencies import CurrentSubject
from app.assessment import comparisons
from app.assessment.design import recorded, shown
from app.assessment.repository import TemplateSearch
from app.assessment.schemas import ComparisonDetail, ComparisonIn, ComparisonOut
from app.database.dependencies import ReadSession
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.schemas import (
    TemplateContent,
    TemplateIn,
    TemplateOut,
    TemplatePreviewIn,
    TemplateVersionDetail,
)
from app.pages import WantedPage
from app.services import services_of

router = APIRouter(prefix="/api", tags=["assessment"])


@router.get("/templates")
def list_templates(
    session: ReadSession,
    subject: CurrentSubject,
    page: WantedPage,
    exercise_id: Annotated[str | None, Query(max_length=32)] = None,
    patient_id: Annotated[str | None, Query(max_length=32)] = None,
    words: Annotated[str, Query(max_length=200)] = "",
    is_retired: bool = False,
) -> list[TemplateOut]:
    """Return the clinic's templates and, with `patient_id`, those made for that patient.

    `words` are looked for in names, exercises and tags. With `is_retired` those that are no longer offered come too.
    """
    wanted = TemplateSearch(exercise_id, patient_id, words, is_retired)
    return shown.list_of(session, subject, wanted, page)


@router.post("/templates/preview")
def preview_template(
    wanted: TemplatePreviewIn, session: ReadSession, subject: CurrentSubject
) -> TemplateContent:
    """Cut a recorded session into repetitions and average them, without storing anything."""
    return recorded.preview(session, subject, wanted)


@router.post("/templates", status_code=201)
def create_template(wanted: TemplateIn, request: Request, subject: CurrentSubject) -> TemplateVersionDetail:
    """Store a template, or with `template_id` a further version; versions never change."""
    engine = services_of(request).engine
    with read_only(engine) as session:
        version, content = recorded.prepare(session, subject, wanted)
    with unit_of_work(engine) as session:
        return recorded.store(session, subject, wanted, version, content)


@router.get("/template-versions/{version_id}")
def get_template_version(
    version_id: str, session: ReadSession, subject: CurrentSubject
) -> TemplateVersionDetail:
    """Return a version of a template with its curves."""
    return shown.detail(session, subject, version_id)


@router.get("/sessions/{session_id}/comparisons")
def list_comparisons(
    session_id: str, session: ReadSession, subject: CurrentSubject, page: WantedPage
) -> list[ComparisonOut]:
    """Return a session's comparisons, newest first."""
    return comparisons.list_of(session, subject, session_id, page)


@router.post("/sessions/{session_id}/comparisons", status_code=201)
def create_comparison(
    session_id: str, wanted: ComparisonIn, request: Request, subject: CurrentSubject
) -> ComparisonOut:
    """Compare a session with a template version now."""
    return comparisons.compare_session(services_of(request).engine, subject, session_id, wanted)


@router.get("/comparisons/{comparison_id}")
def get_comparison(comparison_id: str, session: ReadSession, subject: CurrentSubject) -> ComparisonDetail:
    """Return a comparison with every repetition and curve."""
    return comparisons.detail(session, subject, comparison_id)
