"""Stored frames over HTTP, in the same blocks and columns as the live view, so one player shows both."""

from typing import Annotated

from fastapi import APIRouter, Query, Response
from sqlalchemy.orm import Session

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession
from app.errors import NotFound
from app.live.blocks import encode_block, layout_message
from app.live.messages import LayoutMessage
from app.recordings import repository, service
from app.recordings.models import MotionSession
from app.schemas import SessionTime
from estimators import pipelines
from estimators.pipelines import SessionSetup

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get(
    "/sessions/{session_id}/frames",
    response_class=Response,
    responses={200: {"content": {"application/octet-stream": {}}, "description": "One frame block."}},
)
def get_frames(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    result_id: str | None = None,
    start_s: SessionTime | None = None,
    end_s: SessionTime | None = None,
    max_points: Annotated[int | None, Query(ge=2, le=service.MAX_POINTS)] = None,
) -> Response:
    """Return a result's frames of the half-open session time `[start_s, end_s)` as one binary block.

    At most `max_points` ticks: with more, every n-th is sent and the block's tick interval is n times longer.
    The columns are those of `/layout`.
    """
    frames = service.frames(session, subject, session_id, result_id, start_s, end_s, max_points)
    layout_path = f"/api/sessions/{session_id}/layout" + (f"?result_id={result_id}" if result_id else "")
    return Response(
        encode_block(frames),
        media_type="application/octet-stream",
        headers={"X-Columns-Url": layout_path, "Cache-Control": "private, no-store"},
    )


@router.get("/sessions/{session_id}/layout")
def get_layout(
    session_id: str, session: ReadSession, subject: CurrentSubject, result_id: str | None = None
) -> LayoutMessage:
    """Return the columns of a result's frames."""
    found = repository.get_session(session, subject, session_id, action="session.layout")
    rate_hz, delay_s = _timing(session, found, result_id)
    return layout_message(
        session_id, service.layout_of(session, found, result_id), rate_hz, delay_s * rate_hz
    )


def _timing(session: Session, found: MotionSession, result_id: str | None) -> tuple[float, float]:
    """Return how many frames a second a result keeps, and by how much they are late: live ones may be."""
    rate_hz = float(found.setup["rate_hz"])
    try:
        result = repository.result_of(session, found, result_id)
        kind, kept_hz = result.kind, rate_hz / result.stride
    except NotFound:
        kind, kept_hz = "live", rate_hz
    if kind != "live":
        return kept_hz, 0.0
    return kept_hz, pipelines.create(SessionSetup.from_dict(found.setup)).delay_ticks / rate_hz
