"""Requests about stored sessions; the edge commits."""

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any, Final, cast

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.database.base import utc_now
from app.database.unit_of_work import read_only
from app.errors import Conflict, InvalidInput, NotFound
from app.network.packet_log import write_log
from app.pages import Page
from app.patients.access import levels
from app.patients.models import Patient
from app.recordings import repository
from app.recordings.analysis.kinds import kind_of, kinds
from app.recordings.models import Job, MotionSession, Result
from app.recordings.schemas import (
    CalibrationOut,
    FrameLayoutOut,
    JobOut,
    ReprocessAllIn,
    ReprocessIn,
    ResultOut,
    SessionDetail,
    SessionEventOut,
    SessionIn,
    SessionOut,
)
from app.recordings.signals.checkpoints import forget_checkpoints
from app.recordings.signals.chunks import layout_from_dict
from app.recordings.signals.store import read_frames, read_packets, stored_ranges
from estimators import orientation, pipelines
from estimators.body import BodyDimensions, body_from_stature
from estimators.errors import EstimationError
from estimators.pipelines import Calibration, FrameLayout, Frames, SessionSetup
from estimators.sentences import CATALOGUE, say

MAX_POINTS: Final = 20_000
"""Most ticks that one answer of `/frames` holds; more is thinned."""


def body_of(patient: Patient) -> BodyDimensions:
    """Return a patient's segment lengths: measured ones as they are, the others scaled from stature."""
    measured = {
        name: float(value)
        for name, value in patient.body_dimensions.items()
        if value is not None and value > 0
    }
    known = {field.name for field in fields(BodyDimensions)}
    stature_m = measured.get("stature_m", BodyDimensions().stature_m)
    return replace(
        body_from_stature(stature_m), **{name: value for name, value in measured.items() if name in known}
    )


def checked(setup: SessionSetup) -> SessionSetup:
    """Return the setup when its pipeline and estimator can be built.

    Raises
    ------
    InvalidInput
        With what cannot work together.
    """
    try:
        pipelines.create(setup)
    except EstimationError as error:
        raise InvalidInput(error.message, field="setup") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(say("session.parameter_type"), field="orientation_parameters") from error
    return setup


def create(session: Session, subject: Subject, wanted: SessionIn) -> SessionDetail:
    """Start a session: its setup is fixed here, the gateway's hello confirms it."""
    level = repository.recording_level(wanted.purpose)
    patient = repository.patient_of(session, subject, wanted.patient_id, level)
    if wanted.orientation in orientation.smoothers():
        live = orientation.smoothers()[wanted.orientation].follows
        raise InvalidInput(
            say("session.offline_estimator", wanted=wanted.orientation, live=live),
            field="orientation",
        )
    kind = kinds()[wanted.pipeline]
    remembers = wanted.use_mounting and kind.pipeline.needs_pose
    calibration = _remembered(session, patient.id, tuple(wanted.placements)) if remembers else None
    setup = checked(
        SessionSetup(
            pipeline=wanted.pipeline,
            placements=tuple(wanted.placements),
            rate_hz=wanted.rate_hz,
            orientation=wanted.orientation,
            orientation_parameters=kind.parameters(session, subject, wanted),
            constrain_joint_headings=wanted.constrain_joint_headings,
            body=body_of(patient),
            calibration=calibration,
            feet_apart_m=wanted.feet_apart_m,
        )
    )
    found = repository.create_session(
        session,
        subject,
        MotionSession(
            patient_id=patient.id,
            exercise_id=wanted.exercise_id,
            prescription_id=wanted.prescription_id,
            purpose=wanted.purpose,
            source="stream",
            setup=setup.to_dict(),
            created_by=subject.id,
        ),
    )
    return describe(session, subject, found)


def _remembered(session: Session, patient_id: str, placements: tuple[str, ...]) -> Calibration | None:
    """Return how the sensors sat when this patient was last calibrated, and nothing else of that day.

    Where the patient faces and how headings lie to each other is another matter in every session, and so is what
    the gyroscopes read at rest.
    """
    mounting = repository.mounting_of(session, patient_id)
    if mounting is None:
        return None
    stored = mounting.calibration
    if stored.get("contradicted"):
        return None
    if not set(placements) <= set(stored["q_sensor_segment"]):
        return None
    return Calibration(
        q_sensor_segment={name: tuple(stored["q_sensor_segment"][name]) for name in placements},  # type: ignore[misc]
        gyroscope_bias_radps={},
        method=stored.get("method", "n_pose").removeprefix("level, "),
        score=stored.get("score", 1.0),
        reasons=tuple(CATALOGUE.restored(stored.get("reasons", []))),
        unknown_headings=placements,  # type: ignore[arg-type]
        mounting_sigma_rad={
            name: tuple(value)
            for name, value in stored.get("mounting_sigma_rad", {}).items()
            if name in placements
        },
    )


def list_of_patient(session: Session, subject: Subject, patient_id: str, page: Page) -> list[SessionOut]:
    """Return a page of a patient's sessions, newest first."""
    return [
        SessionOut(**_row(found, name))
        for found, name in repository.list_sessions(session, subject, patient_id, page)
    ]


def detail(session: Session, subject: Subject, session_id: str) -> SessionDetail:
    """Return a session with results, time line and layout."""
    return describe(session, subject, repository.get_session(session, subject, session_id))


def describe(session: Session, subject: Subject, found: MotionSession) -> SessionDetail:
    """Return the detail of a session whose access was checked."""
    patient = session.get_one(Patient, found.patient_id)
    results = repository.results_of(session, found.id)
    setup = found.setup
    return SessionDetail(
        **_row(found, repository.exercise_name(session, found)),
        placements=list(setup["placements"]),
        rate_hz=setup["rate_hz"],
        orientation=setup["orientation"],
        orientation_parameters=setup.get("orientation_parameters", {}),
        constrain_joint_headings=setup.get("constrain_joint_headings", False),
        calibration=_calibration(setup.get("calibration")),
        recording_start_s=found.recording_start_s,
        recording_end_s=found.recording_end_s,
        results=[result_out(result) for result in results],
        events=[SessionEventOut.model_validate(event) for event in _events(session, found.id)],
        layout=layout_out(layout_of(session, found)),
        may_treat="treat" in levels(session, subject, patient) and patient.archived_at is None,
    )


def _events(session: Session, session_id: str) -> list[dict[str, Any]]:
    return [
        {
            "kind": event.kind,
            "time_s": event.time_s,
            "duration_s": event.duration_s,
            "placement": event.placement,
            "text": event.text,
            "label": event.details.get("label"),
        }
        for event in repository.events_of(session, session_id)
    ]


def _row(found: MotionSession, exercise_name: str | None) -> dict[str, Any]:
    names = (
        "id patient_id exercise_id prescription_id purpose source state state_reason created_at started_at"
        " ended_at duration_s packets_stored packets_missing main_result_id"
    )
    return {
        "exercise_name": exercise_name,
        "pipeline": found.setup["pipeline"],
        **{name: getattr(found, name) for name in names.split()},
    }


def _calibration(stored: dict[str, Any] | None) -> CalibrationOut | None:
    if stored is None:
        return None
    return CalibrationOut(
        method=stored["method"],
        score=stored["score"],
        reasons=CATALOGUE.restored(list(stored["reasons"])),
        needs_headings=bool(stored.get("unknown_headings")),
    )


def result_out(result: Result) -> ResultOut:
    """Return a result as clients see it."""
    return ResultOut(
        id=result.id,
        kind=cast(Any, result.kind),
        pipeline=result.pipeline,
        pipeline_version=result.pipeline_version,
        orientation=result.orientation,
        orientation_version=result.orientation_version,
        orientation_parameters=result.setup.get("orientation_parameters", {}),
        status=cast(Any, result.status),
        progress=result.progress,
        message=result.message,
        created_at=result.created_at,
    )


def layout_of(session: Session, found: MotionSession, result_id: str | None = None) -> FrameLayout:
    """Return the columns of a result, by default of the main one, or those that a first one will have."""
    try:
        return layout_from_dict(repository.result_of(session, found, result_id).layout)
    except NotFound:
        if result_id is not None:
            raise
        return pipelines.create(SessionSetup.from_dict(found.setup)).layout


def layout_out(layout: FrameLayout) -> FrameLayoutOut:
    """Return a layout as clients see it."""
    return FrameLayoutOut(
        segments=list(layout.segments),
        points=list(layout.points),
        angles=list(layout.angles),
        scalars=list(layout.scalars),
    )


def frames(
    session: Session,
    subject: Subject,
    session_id: str,
    result_id: str | None = None,
    start_s: float | None = None,
    end_s: float | None = None,
    max_points: int | None = None,
) -> Frames:
    """Return stored frames of the half-open session time `[start_s, end_s)`, at most `max_points` ticks."""
    found = repository.get_session(
        session, subject, session_id, action="session.frames", details={"result": result_id or "main"}
    )
    result = repository.result_of(session, found, result_id)
    frames_ = read_frames(session, result.id, start_s, end_s)
    most = max(1, min(max_points or MAX_POINTS, MAX_POINTS))
    return frames_.every(-(-frames_.tick_count // most))


def packet_log(engine: Engine, subject: Subject, session_id: str) -> Iterator[bytes]:
    """Return every packet of a session as a packet log; access is decided before the first byte.

    Raises
    ------
    NotFound
        Also when no gateway ever declared itself.
    """
    with read_only(engine) as session:
        found = repository.get_session(session, subject, session_id, action="session.download")
        hello = found.hello
    if hello is None:
        raise NotFound(say("session.no_packets"))
    return write_log(hello, read_packets(engine, session_id))


def queue_reprocess(session: Session, subject: Subject, session_id: str, wanted: ReprocessIn) -> JobOut:
    """Queue another estimate of a stored session; the earlier results stay."""
    asked = {"orientation": wanted.orientation}
    found = repository.get_session(
        session, subject, session_id, "treat", action="session.reprocess", details=asked
    )
    if found.state not in {"analysed", "failed"}:
        raise Conflict(say("session.not_finished"), state=found.state)
    setup = SessionSetup.from_dict(found.setup)
    _require_choice(setup)
    checked(
        replace(
            setup, orientation=wanted.orientation, orientation_parameters=dict(wanted.orientation_parameters)
        )
    )
    return job_out(repository.add_job(session, found, "reprocess", wanted.model_dump(), subject))


def queue_closing(session: Session, session_id: str) -> str | None:
    """Queue the analysis of a session that has just been closed; returns the task's id.

    The live side calls this after its last packet is durable, and again after a restart: while any task of
    the closing is unfinished, that one stays. None for a session that was reopened and to which nothing came: it is
    analysed already.
    """
    queued = _queued_closing(session, session_id)
    # Behind the task: who deletes the session locks it before the checkpoint, too.
    forget_checkpoints(session, [session_id])
    return queued


def _queued_closing(session: Session, session_id: str) -> str | None:
    found = session.get_one(MotionSession, session_id)
    unfinished = select(Job).where(Job.session_id == session_id, Job.status.in_(("queued", "running")))
    for job in session.scalars(unfinished.order_by(Job.created_at)):
        if job.arguments.get("close") or job.kind == "upload":
            return job.id
    packets = len(stored_ranges(session, session_id))
    done = select(Job).where(Job.session_id == session_id, Job.kind == "reprocess", Job.status == "complete")
    if any(job.arguments.get("packets") == packets for job in session.scalars(done)):
        found.state, found.ended_at = "analysed", found.ended_at or utc_now()
        return None
    arguments = {"close": True, "packets": packets}
    job = Job(session_id=session_id, kind="reprocess", arguments=arguments, created_by=found.created_by)
    session.add(job)
    session.flush()
    return job.id


def job_out(job: Job) -> JobOut:
    """Return a task as clients see it."""
    return JobOut(
        id=job.id,
        session_id=job.session_id,
        kind=cast(Any, job.kind),
        status=cast(Any, job.status),
        progress=job.progress,
        message=job.message,
        is_implausible=job.status == "failed" and bool(job.arguments.get("implausible")),
    )


def _require_choice(setup: SessionSetup) -> None:
    """Refuse other orientation estimators for a kind of session that has its own filter."""
    if refused := kind_of(setup).estimator_refused:
        raise Conflict(refused)


def queue_reprocess_all(
    session: Session, subject: Subject, session_id: str, wanted: ReprocessAllIn
) -> list[JobOut]:
    """Queue a task for each estimator; what is there already is not made again unless asked."""
    known = orientation.available(with_offline=True)
    if unknown := [name for name in wanted.orientations if name not in known]:
        raise InvalidInput(
            say("session.no_estimator", unknown=unknown, known=list(known)), field="orientations"
        )
    found = repository.get_session(session, subject, session_id, "treat", action="")
    _require_choice(SessionSetup.from_dict(found.setup))
    present = {
        (result.orientation, result.orientation_version)
        for result in repository.results_of(session, found.id)
        if result.kind == "offline"
        and result.status == "complete"
        and not result.setup.get("orientation_parameters")
    }
    return [
        queue_reprocess(session, subject, session_id, ReprocessIn(orientation=name))
        for name in dict.fromkeys(wanted.orientations or known)
        if not (wanted.skip_present and (name, known[name].version) in present)
    ]
