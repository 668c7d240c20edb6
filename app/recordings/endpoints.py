"""HTTP of stored sessions. Their frames are served by `app.live.replay`, in the blocks of the live view."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import StreamingResponse

from app.accounts.dependencies import CurrentSubject
from app.database.dependencies import ReadSession, WriteSession
from app.pages import WantedPage
from app.recordings import repository, service
from app.recordings.analysis.differences import MAX_CURVE_POINTS, differences
from app.recordings.analysis.estimator_choice import estimators_out
from app.recordings.analysis.jobs import JobRunner
from app.recordings.analysis.sequences import in_sequence
from app.recordings.schemas import (
    DifferencesOut,
    EstimatorOut,
    JobOut,
    ReprocessAllIn,
    ReprocessIn,
    SequenceOut,
    SessionDetail,
    SessionIn,
    SessionOut,
)
from app.recordings.signals.disk import DiskUse
from app.schemas import SessionTime
from app.services import services_of
from estimators.arm import Joint, Sequence
from estimators.conventions import Side

router = APIRouter(prefix="/api", tags=["sessions"])


@router.post("/sessions", status_code=201)
def create_session(
    wanted: SessionIn, request: Request, session: WriteSession, subject: CurrentSubject
) -> SessionDetail:
    """Start a session; a gateway then streams to it.

    Errors: `quota_reached` when the clinic has stored as much as it may.
    """
    services_of(request).get(DiskUse).check(subject.clinic_id)
    return service.create(session, subject, wanted)


@router.get("/patients/{patient_id}/sessions")
def list_sessions(
    patient_id: str, session: ReadSession, subject: CurrentSubject, page: WantedPage
) -> list[SessionOut]:
    """Return a patient's sessions, newest first."""
    return service.list_of_patient(session, subject, patient_id, page)


@router.get("/sessions/{session_id}")
def get_session(session_id: str, session: ReadSession, subject: CurrentSubject) -> SessionDetail:
    """Return a session with its results, time line and column names."""
    return service.detail(session, subject, session_id)


@router.delete("/sessions/{session_id}", status_code=204)
def delete_session(
    session_id: str, request: Request, session: WriteSession, subject: CurrentSubject
) -> Response:
    """Erase a session with all its signals, results and comparisons."""
    repository.delete_session(session, services_of(request).settings, subject, session_id)
    return Response(status_code=204)


@router.get("/sessions/{session_id}/raw", response_class=StreamingResponse)
def download_raw(session_id: str, request: Request, subject: CurrentSubject) -> StreamingResponse:
    """Return every packet as it came, as a packet log that can be uploaded again."""
    pieces = service.packet_log(services_of(request).engine, subject, session_id)
    return StreamingResponse(
        pieces,
        media_type="application/octet-stream",
        headers={
            "Content-Disposition": f'attachment; filename="session-{session_id[:8]}.tmlog"',
            "Cache-Control": "no-store",
        },
    )


@router.post("/sessions/{session_id}/reprocess", status_code=202)
def reprocess(
    session_id: str, wanted: ReprocessIn, request: Request, session: WriteSession, subject: CurrentSubject
) -> JobOut:
    """Estimate a stored session again with another estimator; earlier results stay."""
    job = service.queue_reprocess(session, subject, session_id, wanted)
    services_of(request).get(JobRunner).wake()
    return job


@router.post("/sessions/{session_id}/reprocess-all", status_code=202)
def reprocess_all(
    session_id: str, wanted: ReprocessAllIn, request: Request, session: WriteSession, subject: CurrentSubject
) -> list[JobOut]:
    """Estimate a stored session with every estimator (or those named), a task each; earlier results stay."""
    jobs = service.queue_reprocess_all(session, subject, session_id, wanted)
    services_of(request).get(JobRunner).wake()
    return jobs


@router.get("/sessions/{session_id}/results/differences")
def get_differences(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    result_a: str,
    result_b: str,
    max_points: Annotated[int, Query(ge=2, le=MAX_CURVE_POINTS)] = 1000,
) -> DifferencesOut:
    """Return how far two results are apart: RMS and maximum of every joint angle, and both curves."""
    return differences(session, subject, session_id, result_a, result_b, max_points)


@router.get("/sessions/{session_id}/sequences")
def get_sequence(
    session_id: str,
    session: ReadSession,
    subject: CurrentSubject,
    joint: Joint,
    side: Side,
    sequence: Sequence,
    result_id: str | None = None,
    start_s: SessionTime | None = None,
    end_s: SessionTime | None = None,
    max_points: Annotated[int, Query(ge=2, le=MAX_CURVE_POINTS)] = 1000,
) -> SequenceOut:
    """Return a joint in another rotation sequence, with its distance to the singularity."""
    return in_sequence(
        session, subject, session_id, joint, side, sequence, result_id, start_s, end_s, max_points
    )


@router.get("/sessions/{session_id}/jobs")
def list_jobs(
    session_id: str, session: ReadSession, subject: CurrentSubject, page: WantedPage
) -> list[JobOut]:
    """Return the long tasks of a session, newest first."""
    return [service.job_out(job) for job in repository.jobs_of(session, subject, session_id, page)]


@router.get("/jobs/{job_id}")
def get_job(job_id: str, session: ReadSession, subject: CurrentSubject) -> JobOut:
    """Return a long task with its progress."""
    return service.job_out(repository.get_job(session, subject, job_id))


@router.get("/estimators")
def list_estimators(subject: CurrentSubject) -> list[EstimatorOut]:
    """Return the orientation estimators that a session can run with."""
    return estimators_out()
