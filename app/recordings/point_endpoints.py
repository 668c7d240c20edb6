"""HTTP of the points of interest."""

from typing import Annotated

from fastapi import APIRouter, Query

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession
from app.recordings.point_schemas import PointsOut
from app.recordings.points import MAX_POINTS, points_of
from app.schemas import SessionTime

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get("/sessions/{session_id}/points")
def get_points(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    result_id: str | None = None,
    start_s: SessionTime | None = None,
    end_s: SessionTime | None = None,
    max_points: Annotated[int, Query(ge=2, le=MAX_POINTS)] = 1000,
) -> PointsOut:
    """Return elbows, wrists and hands with their uncertainty, speed and acceleration."""
    return points_of(session, subject, session_id, result_id, start_s, end_s, max_points)


__all__ = ["router"]
