"""Tables of sessions, their signals and what was estimated from them."""

from datetime import datetime
from typing import Any, Final

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    String,
    UniqueConstraint,
)
from sqlalchemy.orm import Mapped, mapped_column

from app.database.base import Base, Identified, UtcDateTime, utc_now
from app.database.words import Words

DEAD_LINK: Final = "link_lost"
"""Kind of the event that stands on the time line where nothing came from the sensors for a while."""
WALK_STREAM: Final = "gait/"
"""Before a result's identifier: the stream that holds its walk in numbers, where it is one."""


class MotionSession(Identified, Base):
    """One wearing of the body network, live or uploaded."""

    __tablename__ = "motion_session"
    __table_args__ = (Index(None, "patient_id", "created_at", "id"),)

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"), index=True)
    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"))
    prescription_id: Mapped[str | None] = mapped_column(ForeignKey("prescription.id"))
    exercise_id: Mapped[str | None] = mapped_column(ForeignKey("exercise.id"))
    purpose: Mapped[str] = mapped_column(String(20), default="exercise")
    """`exercise` or `template`."""
    source: Mapped[str] = mapped_column(String(20), default="stream")
    """`stream` or `upload`."""
    state: Mapped[str] = mapped_column(String(20), default="created")
    """created, calibrating, ready, recording, link_lost, closing, analysed, failed."""
    state_reason: Mapped[str] = mapped_column(Words, default="")
    setup: Mapped[dict[str, Any]] = mapped_column(JSON)
    """`estimators.pipelines.SessionSetup` in force."""
    hello: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    """The gateway's declaration: placements, scales, rate, device, firmware."""
    created_by: Mapped[str] = mapped_column(String(32))
    started_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    ended_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    recording_start_s: Mapped[float | None] = mapped_column(Float)
    recording_end_s: Mapped[float | None] = mapped_column(Float)
    """When Record and Stop were pressed, session time; see `recorded_s`."""
    packets_stored: Mapped[int] = mapped_column(Integer, default=0)
    packets_missing: Mapped[int] = mapped_column(Integer, default=0)
    duration_s: Mapped[float] = mapped_column(Float, default=0.0)
    main_result_id: Mapped[str | None] = mapped_column(String(32))
    """The result that views open by default."""
    valid_repetitions: Mapped[int | None] = mapped_column(Integer)
    """Repetitions that were accepted; 0 for walks. None until analysed, and where that was before it was counted."""
    active_s: Mapped[float | None] = mapped_column(Float)
    """How long the exercise was really done; 0 when nothing valid was. None as `valid_repetitions`."""

    @property
    def recorded_s(self) -> tuple[float, float] | None:
        """Half-open session time in which repetitions, strides and sway count; None where nobody pressed Record.

        What is before and after stays stored and is shown, and counts nowhere. Without a Stop it ends with the session.
        """
        if self.recording_start_s is None:
            return None
        return self.recording_start_s, float("inf") if self.recording_end_s is None else self.recording_end_s


class SignalChunk(Base):
    """About one second of one stream. Idempotent on (session, stream, sequence).

    Streams: `raw` (packets as they came) and `frames/<result id>` (derived).
    """

    __tablename__ = "signal_chunk"

    session_id: Mapped[str] = mapped_column(
        ForeignKey("motion_session.id", ondelete="CASCADE"), primary_key=True
    )
    stream: Mapped[str] = mapped_column(String(60), primary_key=True)
    sequence: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    start_ns: Mapped[int] = mapped_column(BigInteger)
    """Session time of the first tick of frames; server time of arrival of the first packet in `raw`."""
    ticks: Mapped[int] = mapped_column(Integer)
    codec: Mapped[str] = mapped_column(String(40))
    scale: Mapped[dict[str, Any]] = mapped_column(JSON)
    """What the decoder needs besides the data: channel scales, packet sequences, column layout."""
    crc: Mapped[int] = mapped_column(BigInteger)
    data: Mapped[bytes] = mapped_column(LargeBinary)


class LiveCheckpoint(Base):
    """Where the estimation of a live session stood, committed with or after all packets and frames before it."""

    __tablename__ = "live_checkpoint"

    session_id: Mapped[str] = mapped_column(
        ForeignKey("motion_session.id", ondelete="CASCADE"), primary_key=True
    )
    layout: Mapped[int] = mapped_column(Integer)
    """Of the data; one that is not that of the reader is left, see `app.live.session.checkpoint`."""
    sequence: Mapped[int] = mapped_column(BigInteger)
    """First packet that is not in it."""
    data: Mapped[bytes] = mapped_column(LargeBinary)
    updated_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now, onupdate=utc_now)


class SessionEvent(Identified, Base):
    """A change of state, a gap, a lost sensor, a mark or a calibration; shown on the time line."""

    __tablename__ = "session_event"
    __table_args__ = (Index(None, "session_id", "kind"),)

    session_id: Mapped[str] = mapped_column(ForeignKey("motion_session.id", ondelete="CASCADE"))
    kind: Mapped[str] = mapped_column(String(40))
    time_s: Mapped[float] = mapped_column(Float)
    """Session time."""
    duration_s: Mapped[float] = mapped_column(Float, default=0.0)
    placement: Mapped[str | None] = mapped_column(String(40))
    text: Mapped[str] = mapped_column(Words, default="")
    details: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)


class SessionAnswers(Base):
    """What the patient said after an exercise; each answer 0 to 10, or none."""

    __tablename__ = "session_answers"

    session_id: Mapped[str] = mapped_column(
        ForeignKey("motion_session.id", ondelete="CASCADE"), primary_key=True
    )
    pain: Mapped[int | None] = mapped_column(Integer)
    most_pain: Mapped[int | None] = mapped_column(Integer)
    """The most that was ever answered: saying it again does not take it back."""
    effort: Mapped[int | None] = mapped_column(Integer)
    third: Mapped[int | None] = mapped_column(Integer)
    question: Mapped[str] = mapped_column(String(200), default="")
    """The therapist's own, which `third` answers, as it was asked."""
    note: Mapped[str] = mapped_column(String(2000), default="")
    answered_at: Mapped[datetime] = mapped_column(UtcDateTime)
    answered_by: Mapped[str] = mapped_column(String(32))


class Result(Identified, Base):
    """One run of a pipeline over a session; every run is stored."""

    __tablename__ = "result"

    session_id: Mapped[str] = mapped_column(ForeignKey("motion_session.id", ondelete="CASCADE"), index=True)
    kind: Mapped[str] = mapped_column(String(20))
    """`live` or `offline`."""
    pipeline: Mapped[str] = mapped_column(String(40))
    pipeline_version: Mapped[str] = mapped_column(String(20))
    orientation: Mapped[str] = mapped_column(String(40))
    orientation_version: Mapped[str] = mapped_column(String(20))
    setup: Mapped[dict[str, Any]] = mapped_column(JSON)
    layout: Mapped[dict[str, Any]] = mapped_column(JSON)
    """`FrameLayout` of the stored frames."""
    stride: Mapped[int] = mapped_column(Integer, default=1)
    """Every so many ticks of the session have a stored frame: those whose number it divides."""
    status: Mapped[str] = mapped_column(String(20), default="running")
    """running, complete, failed."""
    progress: Mapped[float] = mapped_column(Float, default=0.0)
    message: Mapped[str] = mapped_column(Words, default="")
    completed_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    followed: Mapped[list[Any] | None] = mapped_column(JSON(none_as_null=True), deferred=True)
    """Of a walk, the measures that progress follows, `app.kinds.walk.followed`."""


class Job(Identified, Base):
    """A long upload or analysis with its progress; survives a restart and is taken up again."""

    __tablename__ = "job"
    __table_args__ = (Index(None, "session_id", "created_at", "id"),)

    session_id: Mapped[str] = mapped_column(ForeignKey("motion_session.id", ondelete="CASCADE"))
    kind: Mapped[str] = mapped_column(String(20))
    """`upload`, `reprocess`, `compare` or `markers`."""
    arguments: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    status: Mapped[str] = mapped_column(String(20), default="queued")
    """queued, running, complete, failed."""
    progress: Mapped[float] = mapped_column(Float, default=0.0)
    message: Mapped[str] = mapped_column(Words, default="")
    created_by: Mapped[str] = mapped_column(String(32))
    updated_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now, onupdate=utc_now)
    is_retryable: Mapped[bool] = mapped_column(Boolean, default=True)


class MagneticSource(Identified, Base):
    """A worn magnetic source of a clinic whose coils were measured; no patient data."""

    __tablename__ = "magnetic_source"
    __table_args__ = (UniqueConstraint("clinic_id", "serial"),)

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"))
    serial: Mapped[str] = mapped_column(String(100))
    name: Mapped[str] = mapped_column(String(100))
    coils: Mapped[list[dict[str, Any]]] = mapped_column(JSON)
    """`estimators.magnetic.Coil.to_dict`, in the order of their numbers."""
    current_limit_a: Mapped[float] = mapped_column(Float)
    gain_sigma: Mapped[float] = mapped_column(Float)
    """How wrong the field of these coils still is, as a share of it."""
    found: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """What the calibration said: sigmas of each coil, residual, number of places; empty for typed values."""
    method: Mapped[str] = mapped_column(String(20))
    """`session`, `file` or `typed`."""
    session_id: Mapped[str | None] = mapped_column(String(32))
    """The bench session that it was calibrated with."""
    calibrated_at: Mapped[datetime] = mapped_column(UtcDateTime)
    calibrated_by: Mapped[str] = mapped_column(String(32))
    retired_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    """No longer offered; sessions keep the coils that they were recorded with."""
