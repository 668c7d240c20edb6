"""Routes of walks: one in numbers, those of a patient, and two conditions compared."""

from typing import Annotated, Final

from fastapi import APIRouter, Query

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession
from app.kinds.walk.compared import foot_curves
from app.kinds.walk.history import compare, walks_of
from app.kinds.walk.schemas import ConditionsIn, ConditionsOut, FootCurvesOut, FootStride, GaitOut, WalkRow
from app.kinds.walk.stored import gait, strides_page
from app.pages import WantedPage

_MOST_POINTS: Final = 20_000
"""Three minutes and a bit of every tick; a stride of a longer walk still has dozens."""

router = APIRouter(prefix="/api", tags=["walks"])


@router.get("/sessions/{session_id}/gait")
def get_gait(
    session_id: str, session: ReadSession, subject: CurrentSubject, result_id: str | None = None
) -> GaitOut:
    """Return a walk: footprints, strides, numbers of each foot with uncertainty and count, and their asymmetry.

    Of a walk with more than 200 strides of a foot these are the first; `/gait/strides` has all of them.
    """
    return gait(session, subject, session_id, result_id)


@router.get("/sessions/{session_id}/gait/strides")
def list_strides(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    page: WantedPage,
    result_id: str | None = None,
) -> list[FootStride]:
    """Return the strides of both feet of a walk in the order of time."""
    return strides_page(session, subject, session_id, result_id, page)


@router.get("/sessions/{session_id}/gait/curves")
def get_foot_curves(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    result_id: str | None = None,
    max_points: Annotated[int, Query(ge=2, le=_MOST_POINTS)] = _MOST_POINTS,
) -> FootCurvesOut:
    """Return pitch, height and forward speed of each foot over the whole walk, as templates of walks have them."""
    return foot_curves(session, subject, session_id, result_id, max_points)


@router.get("/patients/{patient_id}/walks")
def list_walks(
    patient_id: str, session: ReadSession, subject: CurrentSubject, page: WantedPage
) -> list[WalkRow]:
    """Return the analysed walks of a patient, newest first."""
    return walks_of(session, subject, patient_id, page)


@router.post("/patients/{patient_id}/walks/comparison")
def compare_walks(
    patient_id: str, body: ConditionsIn, session: ReadSession, subject: CurrentSubject
) -> ConditionsOut:
    """Compare the walks of one condition with those of another, measure by measure; nothing is stored."""
    return compare(session, subject, patient_id, body)
