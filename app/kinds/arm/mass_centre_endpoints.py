"""HTTP of the centre of mass of a body with worn sensors."""

from typing import Annotated

from fastapi import APIRouter, Query

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession
from app.kinds.arm.mass_centre import mass_centre_of
from app.kinds.arm.mass_centre_schemas import MassCentreOut
from app.recordings.points import MAX_POINTS
from app.schemas import SessionTime

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get("/sessions/{session_id}/mass-centre")
def get_mass_centre(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    result_id: str | None = None,
    start_s: SessionTime | None = None,
    end_s: SessionTime | None = None,
    max_points: Annotated[int, Query(ge=2, le=MAX_POINTS)] = 1000,
) -> MassCentreOut:
    """Return the centre of mass against the ankles and the floor, how well it is known, and what is assumed."""
    return mass_centre_of(session, subject, session_id, result_id, start_s, end_s, max_points)


__all__ = ["router"]
