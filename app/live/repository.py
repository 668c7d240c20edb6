"""Reads and writes of the live side in the database, with the access decision of every request.

All functions block; the live side calls them in a thread.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts.audit import record
from app.accounts.credentials.tickets import (
    TICKET_REFUSED,
    Purpose,
    Redeemed,
    is_open,
    issue_ticket,
    redeem_ticket,
)
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, NotFound, SafetyUnconfirmed, SignInRequired, Unavailable
from app.kinds.magnetic.safety import CONFIRMATION_HOURS, withdraw
from app.kinds.magnetic.schemas import MagneticSafetyOut
from app.live.session.states import OPEN
from app.patients.access import Level, require_patient
from app.patients.models import Mounting
from app.recordings.analysis.kinds import kind_of
from app.recordings.analysis.result_rows import filter_of, layout_dict
from app.recordings.models import DEAD_LINK, LiveCheckpoint, MotionSession, Result, SessionEvent, SignalChunk
from app.recordings.signals.checkpoints import forget_checkpoints
from app.recordings.signals.chunks import frames_stream
from app.schemas import SessionState
from estimators.pipelines import Calibration, Pipeline, SessionSetup
from estimators.sentences import say

NO_SUCH_SESSION = say("session.not_found")
MOST_MISSING = (1 << 31) - 1
RECORDED_TO_THE_END_S = 1.0
"""A recording whose end is nearer to the session's was ended by it."""


@dataclass(frozen=True)
class StoredSession:
    """What the database knows of a session that the live side needs."""

    id: str
    clinic_id: str
    patient_id: str
    state: SessionState
    state_reason: str
    setup: dict[str, Any]
    hello: dict[str, Any] | None
    recording_start_s: float | None
    recording_end_s: float | None
    is_ended: bool
    """Closed once: it takes no more packets, whatever became of its analysis."""


def authorise(
    engine: Engine, subject: Subject, session_id: str, level: Level, action: str | None = None
) -> StoredSession:
    """Return the session when the subject has the level for its patient.

    Parameters
    ----------
    action : str, optional
        Written to the audit trail, e.g. `session.calibrate`.

    Raises
    ------
    NotFound, NotAllowed
        See `app.patients.access`.
    """
    with read_only(engine) as session:
        row = _row(session, session_id)
        try:
            require_patient(session, subject, row.patient_id, level)
        except NotFound as error:
            raise NotFound(NO_SUCH_SESSION) from error
        if action is not None:
            record(session, subject, action, row.patient_id, session_id)
        return _stored(row)


def open_by_ticket(
    engine: Engine, ticket: str, confirmation_hours: float = CONFIRMATION_HOURS
) -> tuple[Subject, StoredSession]:
    """Use an ingest ticket up and return whose it was and the session it opens.

    Raises
    ------
    SignInRequired
        The ticket is not valid.
    NotFound, NotAllowed
        The right to the patient was lost since it was issued.
    SafetyUnconfirmed
        The session has a magnetic source that nobody has confirmed to be safe.
    """
    _look_first(engine, ticket, "ingest")
    with unit_of_work(engine) as session:
        redeemed: Redeemed = redeem_ticket(session, ticket, "ingest")
        _require_safe(session, _row(session, redeemed.session_id), confirmation_hours)
    return redeemed.subject, authorise(
        engine, redeemed.subject, redeemed.session_id, "record", "session.stream"
    )


def _look_first(engine: Engine, ticket: str, purpose: Purpose) -> None:
    """Raise `SignInRequired` for a ticket that is none: strangers do not hold the lock of those who write."""
    with read_only(engine) as session:
        if not is_open(session, ticket, purpose):
            raise SignInRequired(TICKET_REFUSED)


def watch_by_ticket(engine: Engine, ticket: str, session_id: str) -> Subject:
    """Use a live ticket up and return whose it was; the caller then calls `authorise`."""
    _look_first(engine, ticket, "live")
    with unit_of_work(engine) as session:
        return redeem_ticket(session, ticket, "live", session_id).subject


def give_ticket(
    engine: Engine,
    subject: Subject,
    session_id: str,
    purpose: str,
    confirmation_hours: float = CONFIRMATION_HOURS,
) -> tuple[str, datetime]:
    """Issue a one-use ticket for `ingest` or `live` to a subject who has the right to it."""
    # After a restart all gateways and views ask at once: the lock of those who write is held for the ticket alone.
    # Rights are checked again when it is used.
    with read_only(engine) as session:
        row = _row(session, session_id)
        try:
            require_patient(session, subject, row.patient_id, "record" if purpose == "ingest" else "read")
        except NotFound as error:
            raise NotFound(NO_SUCH_SESSION) from error
        if purpose == "ingest":
            _require_safe(session, row, confirmation_hours)
    with unit_of_work(engine) as session:
        record(session, subject, "session.ticket", row.patient_id, session_id, {"purpose": purpose})
        token, ticket = issue_ticket(
            session, subject, "ingest" if purpose == "ingest" else "live", session_id
        )
        return token, ticket.expires_at


def _require_safe(session: Session, row: MotionSession, hours: float) -> None:
    kind_of(row.setup).require_safe(session, row, hours)


def source_refusal(engine: Engine, session_id: str, confirmation_hours: float) -> str | None:
    """Return why the source of a session may not fire any more; None while it may."""
    with read_only(engine) as session:
        try:
            _require_safe(session, _row(session, session_id), confirmation_hours)
        except SafetyUnconfirmed as error:
            return error.message
    return None


def withdraw_safety(
    engine: Engine, subject: Subject, session_id: str, confirmation_hours: float
) -> MagneticSafetyOut:
    """Note that a therapist takes the word back that a source is safe; see `app.kinds.magnetic.safety.withdraw`."""
    with unit_of_work(engine) as session:
        return withdraw(session, subject, session_id, confirmation_hours)


def load(engine: Engine, session_id: str) -> StoredSession:
    """Return a session for the service's own work; requests use `authorise`."""
    with read_only(engine) as session:
        return _stored(_row(session, session_id))


def begin_stream(
    engine: Engine, session_id: str, hello: dict[str, Any], pipeline: Pipeline
) -> tuple[str, int]:
    """Store the hello and find or make the live result.

    Returns
    -------
    str
        Identifier of the live result.
    int
        First tick of which no frame is stored.
    """
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        row.hello = hello
        row.setup = pipeline.setup.to_dict()
        row.started_at = row.started_at or utc_now()
        result = session.scalars(
            select(Result).where(Result.session_id == session_id, Result.kind == "live")
        ).first()
        if result is None:
            estimator, version = filter_of(pipeline)
            result = Result(
                session_id=session_id,
                kind="live",
                pipeline=pipeline.name,
                pipeline_version=pipeline.version,
                orientation=estimator,
                orientation_version=version,
                setup=pipeline.setup.to_dict(),
                layout=layout_dict(pipeline.layout),
                stride=kind_of(pipeline.setup).live_stride(pipeline.setup.rate_hz),
                status="running",
            )
            session.add(result)
            session.flush()
            row.main_result_id = row.main_result_id or result.id
        last = session.execute(
            select(SignalChunk.sequence + SignalChunk.ticks)
            .where(SignalChunk.session_id == session_id, SignalChunk.stream == frames_stream(result.id))
            .order_by(SignalChunk.sequence.desc())
            .limit(1)
        ).scalar()
        return result.id, int(last or 0)


def save_hello(engine: Engine, session_id: str, hello: dict[str, Any]) -> None:
    """Store the hello again: its clock epochs or the clip levels found have grown."""
    with unit_of_work(engine) as session:
        _row(session, session_id).hello = hello


def save_state(engine: Engine, session_id: str, state: SessionState, reason: str) -> None:
    """Store a change of state."""
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        row.state, row.state_reason = state, reason


def close_absent(engine: Engine, session_id: str, reason: str) -> None:
    """Store that a session is closed that is not live here: one whose link was lost never got it back."""
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        if row.state == "link_lost":
            text = say("caseload.dead_to_the_end")
            time_s = row.duration_s or 0.0
            session.add(SessionEvent(session_id=row.id, kind=DEAD_LINK, time_s=time_s, text=text))
        row.state, row.state_reason = "closing", reason


def save_not_closed(engine: Engine, session_id: str, reason: str) -> None:
    """Store that a session could not be closed; it does not go on."""
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        row.state, row.state_reason = "failed", reason
        forget_checkpoints(session, [session_id])


def forget_ended(engine: Engine) -> None:
    """Delete checkpoints of sessions that do not go on; where a service ended while it closed one, it lies there."""
    going_on = [state for state in OPEN if state != "failed"]
    with unit_of_work(engine) as session:
        ended = MotionSession.state.not_in(going_on) | MotionSession.ended_at.is_not(None)
        forget_checkpoints(
            session, session.scalars(select(MotionSession.id).join(LiveCheckpoint).where(ended)).all()
        )


def reopen(engine: Engine, session_id: str) -> bool:
    """Let a streamed session that has ended take packets again; False for one that is open, which stays as it is.

    What the analysis has found stays, until the next end has it found again.

    Raises
    ------
    NotFound
        There is no such session.
    Conflict
        It was not streamed.
    Unavailable
        It is being analysed.
    """
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        if row.state in OPEN and row.ended_at is None:
            return False
        if row.source != "stream":
            raise Conflict(say("live.closed"), state=row.state)
        if row.state == "closing":
            raise Unavailable(say("live.being_analysed"), retry_after_s=5)
        end_s, duration_s = row.recording_end_s, row.duration_s or 0.0
        if end_s is not None and end_s > duration_s - RECORDED_TO_THE_END_S:
            # Nobody has stopped the recording: the end of the session has, and more may come.
            row.recording_end_s = None
        row.ended_at = None
        row.state, row.state_reason = "created" if row.hello is None else "link_lost", say("live.reopened")
        session.add(SessionEvent(session_id=row.id, kind="state", time_s=duration_s, text=row.state_reason))
        return True


def save_recording(engine: Engine, session_id: str, start_s: float | None, end_s: float | None) -> None:
    """Store the interval in which repetitions count, and, once it has an end, how the sensors sat in it."""
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        row.recording_start_s, row.recording_end_s = start_s, end_s
        if start_s is not None and end_s is not None and end_s > start_s:
            _remember_mounting(session, row)


def _remember_mounting(session: Session, row: MotionSession) -> None:
    """Offer the calibration in force at the patient's next session; what is known of sensors not worn today stays."""
    found = row.setup.get("calibration") or {}
    if not found.get("q_sensor_segment"):
        return
    mounting = session.scalars(select(Mounting).where(Mounting.patient_id == row.patient_id)).first()
    if mounting is None:
        mounting = Mounting(patient_id=row.patient_id, calibration={})
        session.add(mounting)
    by_placement = ("q_sensor_segment", "mounting_sigma_rad")
    merged = {key: {**mounting.calibration.get(key, {}), **found.get(key, {})} for key in by_placement}
    mounting.calibration = {**found, **merged}
    mounting.session_id = row.id
    mounting.updated_at = utc_now()


def save_calibration(engine: Engine, session_id: str, result_id: str, setup: SessionSetup) -> None:
    """Store a calibration with the session and its live result; `save_recording` remembers it for the patient."""
    stored = setup.to_dict()
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        row.setup = stored
        result = session.get(Result, result_id)
        if result is not None:
            result.setup = stored


def finish_stream(
    engine: Engine, session_id: str, result_id: str | None, duration_s: float, packets_missing: int
) -> None:
    """Store what is known at the end of a stream and mark its live result complete."""
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        row.ended_at = utc_now()
        row.duration_s = max(row.duration_s or 0.0, duration_s)
        # What a gateway says was its last sequence may be anything; the column is not as wide.
        row.packets_missing = min(packets_missing, MOST_MISSING)
        result = session.get(Result, result_id) if result_id else None
        if result is not None:
            result.status, result.progress, result.completed_at = "complete", 1.0, utc_now()


def end_abandoned(engine: Engine, session_id: str) -> None:
    """Note the end of a session that is not live here: no gateway came, or none came back."""
    with unit_of_work(engine) as session:
        row = _row(session, session_id)
        row.ended_at = row.ended_at or utc_now()
        for result in session.scalars(
            select(Result).where(
                Result.session_id == session_id, Result.kind == "live", Result.status == "running"
            )
        ):
            result.status, result.progress, result.completed_at = "complete", 1.0, utc_now()


def interrupted(engine: Engine) -> list[StoredSession]:
    """Return streamed sessions that were open or closing when the service last stopped."""
    states = [state for state in OPEN if state not in {"created", "failed"}] + ["closing"]
    with read_only(engine) as session:
        rows = session.scalars(
            select(MotionSession).where(MotionSession.state.in_(states), MotionSession.source == "stream")
        )
        return [_stored(row) for row in rows]


def unfinished(
    engine: Engine, is_own: Callable[[str], bool]
) -> tuple[Sequence[StoredSession], Sequence[str]]:
    """Return streamed sessions that are open, and the identifiers of those that wait to be analysed.

    Parameters
    ----------
    is_own : callable(session_id)
        Whose are wanted.
    """
    with read_only(engine) as session:
        rows = session.execute(
            select(MotionSession.id, MotionSession.state).where(
                MotionSession.state.in_([*OPEN - {"created"}, "closing"]),
                MotionSession.source == "stream",
                MotionSession.hello.is_not(None),
            )
        ).all()
        own = [(str(row.id), row.state) for row in rows if is_own(row.id)]
        open_ones = [one for one, state in own if state != "closing"]
        found = session.scalars(
            select(MotionSession).where(MotionSession.id.in_(open_ones), MotionSession.ended_at.is_(None))
        )
        stored = [_stored(row) for row in found]
    return stored, [one for one, state in own if state == "closing"]


def of_other_layouts(engine: Engine, layout: int) -> Sequence[tuple[str, int]]:
    """Return which streamed sessions are open and have a checkpoint that is not of this layout, and where it stands."""
    with read_only(engine) as session:
        found = session.execute(
            select(MotionSession.id, LiveCheckpoint.sequence)
            .join(LiveCheckpoint, LiveCheckpoint.session_id == MotionSession.id)
            .where(
                LiveCheckpoint.layout != layout,
                MotionSession.state.in_(OPEN - {"created"}),
                MotionSession.ended_at.is_(None),
                MotionSession.hello.is_not(None),
            )
            .order_by(MotionSession.id)
        )
        return [(str(session_id), sequence) for session_id, sequence in found]


def calibration_of(setup: dict[str, Any]) -> Calibration | None:
    """Return the calibration in a stored setup."""
    return SessionSetup.from_dict(setup).calibration


def _row(session: Session, session_id: str) -> MotionSession:
    row = session.get(MotionSession, session_id)
    if row is None:
        raise NotFound(NO_SUCH_SESSION)
    return row


def _stored(row: MotionSession) -> StoredSession:
    return StoredSession(
        id=row.id,
        clinic_id=row.clinic_id,
        patient_id=row.patient_id,
        state=row.state,  # type: ignore[arg-type]
        state_reason=row.state_reason,
        setup=dict(row.setup),
        hello=None if row.hello is None else dict(row.hello),
        recording_start_s=row.recording_start_s,
        recording_end_s=row.recording_end_s,
        is_ended=row.ended_at is not None,
    )
