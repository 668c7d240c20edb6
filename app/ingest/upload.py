"""Uploading a whole recording: received to disk, stored as packets, analysed like a streamed session.

The request ends when the file is on disk and its task is queued; reading, storing and estimating are the
task's work, in the worker process, with progress. A file is removed when its task has ended, however it ended
(`app.recordings.files_in_passing`).
"""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Final, cast

from anyio import to_thread
from fastapi import APIRouter, Request
from pydantic import ValidationError
from sqlalchemy import Engine

from app import readers
from app.accounts.dependencies import CurrentSubject
from app.accounts.subject import Subject
from app.database.base import new_id
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput
from app.ingest._multipart import UploadReceiver, announced_bytes, described, too_large
from app.readers.moments import is_possible
from app.recordings import repository, service
from app.recordings.analysis.jobs import JobRunner
from app.recordings.analysis.kinds import kinds
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import MotionSession
from app.recordings.schemas import JobOut, UploadIn
from app.recordings.signals.disk import DiskUse, Room
from app.services import services_of
from app.settings import Settings
from estimators.conventions import Placement
from estimators.pipelines import SessionSetup
from estimators.sentences import say

MULTIPART_SLACK_BYTES: Final = 1 << 20
router = APIRouter(prefix="/api", tags=["sessions"])


@router.post("/uploads", status_code=202, openapi_extra=described("UploadIn"))
async def upload_recording(request: Request, subject: CurrentSubject) -> JobOut:
    """Upload a recording: a packet log, CSV with its mapping, or a whole-body `.mat`.

    The JSON part `declaration` (`UploadIn`) comes first, then the part `file`.
    """
    services = services_of(request)
    settings: Settings = services.settings
    length = announced_bytes(request)
    if length > settings.upload_limit_bytes + MULTIPART_SLACK_BYTES:
        raise too_large(settings.upload_limit_bytes)
    declared: list[UploadIn] = []
    room = Room(services.get(DiskUse), subject.clinic_id)

    async def check(text: bytes) -> None:
        declaration = parse_declaration(text)
        await to_thread.run_sync(_check_right, services.engine, subject, declaration)
        await to_thread.run_sync(room.take, whole.name, length)
        declared.append(declaration)

    folder = upload_folder(settings)
    name = new_id()
    partial, whole = folder / f"{name}.part", folder / f"{name}.upload"
    receiver = UploadReceiver(
        request.headers.get("content-type", ""), partial, settings.upload_limit_bytes, check, room.grow
    )
    try:
        with services.limits.take("uploads", subject), room:
            await receiver.receive(request.stream())
            await to_thread.run_sync(partial.rename, whole)
            job = await to_thread.run_sync(register, services.engine, settings, subject, declared[0], whole)
    except BaseException:
        # Also when the client went away: nothing half received stays on the disk.
        partial.unlink(missing_ok=True)
        whole.unlink(missing_ok=True)
        raise
    services.get(JobRunner).wake()
    return job


def parse_declaration(text: bytes) -> UploadIn:
    """Read the JSON part.

    Raises
    ------
    InvalidInput
        With the fields that are wrong.
    """
    try:
        declaration = UploadIn.model_validate_json(text)
    except ValidationError as error:
        fields = [".".join(str(part) for part in item["loc"]) or "declaration" for item in error.errors()]
        raise InvalidInput(
            say("upload.fields", fields=fields[:8]),
            problems=[
                {"field": name, "problem": item["msg"]}
                for name, item in zip(fields, error.errors(), strict=True)
            ][:20],
        ) from error
    if declaration.format and readers.reader_of(declaration.format).needs_mapping and declaration.csv is None:
        raise InvalidInput(say("upload.csv_needs_mapping"), field="csv")
    if declaration.recorded_at is not None and not is_possible(declaration.recorded_at):
        raise InvalidInput(say("upload.recorded_at"), field="recorded_at")
    pose = declaration.calibration_pose_s
    if pose is not None and not 0 <= pose[0] < pose[1]:
        raise InvalidInput(
            say("upload.pose"),
            field="calibration_pose_s",
        )
    return declaration


def _check_right(engine: Engine, subject: Subject, declaration: UploadIn) -> None:
    with read_only(engine) as session:
        repository.patient_of(
            session, subject, declaration.patient_id, repository.recording_level(declaration.purpose)
        )


def register(
    engine: Engine, settings: Settings, subject: Subject, declaration: UploadIn, path: Path
) -> JobOut:
    """Make the session of an uploaded file and queue its task.

    Parameters
    ----------
    path : Path
        Inside `upload_folder(settings)`; from now on the task's.

    Raises
    ------
    RecordingFormatError
        The beginning of the file is not what it was declared to be.
    """
    placements, rate_hz = _announced(declaration, path)
    with unit_of_work(engine) as session:
        patient = repository.patient_of(
            session, subject, declaration.patient_id, repository.recording_level(declaration.purpose)
        )
        kind = pipeline_of(declaration, placements)
        setup = service.checked(
            SessionSetup(
                pipeline=kind,
                placements=kinds()[kind].pipeline.used(placements, with_legs=declaration.with_legs),
                rate_hz=rate_hz,
                orientation=declaration.orientation,
                body=service.body_of(patient),
                feet_apart_m=declaration.feet_apart_m,
                feet_apart_end_m=declaration.feet_apart_end_m,
            )
        )
        found = repository.create_session(
            session,
            subject,
            MotionSession(
                patient_id=patient.id,
                exercise_id=declaration.exercise_id,
                prescription_id=declaration.prescription_id,
                purpose=declaration.purpose,
                source="upload",
                state="closing",
                setup=setup.to_dict(),
                started_at=declaration.recorded_at or _recorded_at(declaration, path),
                created_by=subject.id,
            ),
        )
        arguments = {"file": path.name, "declaration": declaration.model_dump(mode="json")}
        return service.job_out(repository.add_job(session, found, "upload", arguments, subject))


def _recorded_at(declaration: UploadIn, path: Path) -> datetime | None:
    """Return when a file says that it was recorded, as far as that stands at its beginning."""
    if declaration.format is None or not readers.reader_of(declaration.format).holds_packets:
        return None
    return readers.LogReader(path).recorded_at


def pipeline_of(declaration: UploadIn, placements: Sequence[str]) -> str:
    """Return the pipeline of an upload: some formats hold nothing else; by default what its sensors are worn for.

    Parameters
    ----------
    placements : sequence of str
        Of its sensors, as far as they are known.
    """
    only = declaration.format and readers.reader_of(declaration.format).pipeline
    return only or declaration.pipeline or readers.pipeline_for(list(placements))


def _announced(declaration: UploadIn, path: Path) -> tuple[list[Placement], float]:
    """Return placements and rate as far as they are known without reading the whole file."""
    source = readers.Source(path, declaration.file_name, declaration.csv)
    # Where only the contents say the format, the most that any format holds; the task replaces it by what is there.
    most = max(readers.readers().values(), key=lambda one: len(one.placements))
    reader = readers.reader_of(declaration.format) if declaration.format else most
    placements, rate_hz = reader.announces(source)
    return cast(list[Placement], list(placements)), rate_hz
