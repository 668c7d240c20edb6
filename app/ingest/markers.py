"""HTTP of marker trajectories: uploaded to an analysed session, fused by a task, reported."""

from pathlib import Path
from typing import Annotated, Final

from anyio import to_thread
from fastapi import APIRouter, Query, Request
from fastapi.responses import StreamingResponse
from pydantic import ValidationError
from sqlalchemy import Engine

from app.accounts.dependencies import CurrentSubject
from app.accounts.subject import Subject
from app.database.base import new_id
from app.database.dependencies import ReadSession
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput, TooLarge
from app.ingest._multipart import UploadReceiver, announced_bytes, described
from app.pages import WantedPage
from app.readers import read_markers
from app.readers.markers.schemas import MarkerMotionOut, MarkersOut, MarkerUploadIn
from app.recordings import marker_motion, markers, service
from app.recordings.analysis.jobs import JobRunner
from app.recordings.files_in_passing import upload_folder
from app.recordings.schemas import JobOut
from app.recordings.signals.disk import DiskUse, Room
from app.services import services_of
from estimators.sentences import say

FILE_LIMIT_BYTES: Final = 64 << 20
SESSION_LIMIT_BYTES: Final = 256 << 20
"""All marker files of one session together."""

router = APIRouter(prefix="/api", tags=["sessions"])


@router.post("/sessions/{session_id}/markers", status_code=202, openapi_extra=described("MarkerUploadIn"))
async def upload_markers(session_id: str, request: Request, subject: CurrentSubject) -> JobOut:
    """Upload marker trajectories, C3D or CSV, of somebody who wore the sensors of an analysed session.

    The JSON part `declaration` (`MarkerUploadIn`) comes first, then the part `file`. A task aligns the clocks and
    fuses the marker with the named sensor.
    """
    services = services_of(request)
    declared: list[MarkerUploadIn] = []

    async def check(text: bytes) -> None:
        declaration = _declaration(text)
        await to_thread.run_sync(_check, services.engine, subject, session_id, declaration)
        await to_thread.run_sync(room.take, path.name, announced_bytes(request))
        declared.append(declaration)

    room = Room(services.get(DiskUse), subject.clinic_id)
    path = upload_folder(services.settings) / f"{new_id()}.part"
    receiver = UploadReceiver(
        request.headers.get("content-type", ""), path, FILE_LIMIT_BYTES, check, room.grow
    )
    try:
        with services.limits.take("uploads", subject), room:
            await receiver.receive(request.stream())
            job = await to_thread.run_sync(register, services.engine, subject, session_id, declared[0], path)
    finally:
        # The database has it now, whole, or nobody has.
        path.unlink(missing_ok=True)
    services.get(JobRunner).wake()
    return job


@router.get("/sessions/{session_id}/markers")
def list_markers(
    session_id: str, session: ReadSession, subject: CurrentSubject, page: WantedPage
) -> list[MarkersOut]:
    """Return uploaded markers, newest first, with alignment, residuals and gaps of each."""
    return markers.markers_of(session, subject, session_id, page)


@router.get("/sessions/{session_id}/markers/motion", response_class=StreamingResponse)
def get_motion(
    session_id: str, session: ReadSession, subject: CurrentSubject, markers_id: str | None = None
) -> StreamingResponse:
    """Return place, velocity, acceleration and attitude at the rate of the sensor as CSV; the newest by default."""
    lines = marker_motion.motion_csv(session, subject, session_id, markers_id)
    return StreamingResponse(
        lines,
        media_type="text/csv",
        headers={
            "Content-Disposition": f'attachment; filename="markers-{session_id[:8]}.csv"',
            "Cache-Control": "no-store",
        },
    )


@router.get("/sessions/{session_id}/markers/motion/stretch")
def get_stretch(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    from_s: Annotated[float, Query(ge=0.0, le=1e6)] = 0.0,
    until_s: Annotated[float, Query(gt=0.0, le=1e6)] = 10.0,
    markers_id: str | None = None,
) -> MarkerMotionOut:
    """Return a stretch of the fused motion for curves, two minutes at most; the newest markers by default."""
    return marker_motion.motion_between(session, subject, session_id, markers_id, from_s, until_s)


def register(
    engine: Engine, subject: Subject, session_id: str, declaration: MarkerUploadIn, path: Path
) -> JobOut:
    """Keep an uploaded file with its session and queue its fusion.

    Raises
    ------
    RecordingFormatError
        The file is not what it was declared to be.
    """
    read_markers(path, declaration)
    with unit_of_work(engine) as session:
        found = markers.session_for(session, subject, session_id, declaration.segment)
        if markers.stored_bytes(session, session_id) + path.stat().st_size > SESSION_LIMIT_BYTES:
            raise TooLarge(say("markers.limit", limit_bytes=SESSION_LIMIT_BYTES), limit=SESSION_LIMIT_BYTES)
        return service.job_out(markers.store_file(session, found, declaration, path, subject))


def _check(engine: Engine, subject: Subject, session_id: str, declaration: MarkerUploadIn) -> None:
    with read_only(engine) as session:
        markers.session_for(session, subject, session_id, declaration.segment)


def _declaration(text: bytes) -> MarkerUploadIn:
    try:
        return MarkerUploadIn.model_validate_json(text)
    except ValidationError as error:
        problems = [
            {"field": ".".join(str(part) for part in item["loc"]), "problem": item["msg"]}
            for item in error.errors()
        ][:20]
        names = list(dict.fromkeys(item["field"] or "declaration" for item in problems))
        raise InvalidInput(say("upload.fields", fields=names), problems=problems) from error
