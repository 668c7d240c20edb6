"""HTTP of curves over time."""

from typing import Annotated

from fastapi import APIRouter, Query

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession
from app.recordings.analysis.series import series_of
from app.recordings.points import MAX_POINTS
from app.recordings.series_schemas import SeriesOut
from app.schemas import SessionTime

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get("/sessions/{session_id}/series")
def get_series(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    names: Annotated[str, Query(max_length=200)],
    result_id: str | None = None,
    start_s: SessionTime | None = None,
    end_s: SessionTime | None = None,
    max_points: Annotated[int, Query(ge=2, le=MAX_POINTS)] = 1000,
) -> SeriesOut:
    """Return curves of a result with their uncertainty; `names` between commas, such as `arm_points,mass_centre`."""
    wanted = [name for name in names.split(",") if name]
    return series_of(session, subject, session_id, wanted, result_id, start_s, end_s, max_points)
