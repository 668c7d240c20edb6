"""Tables of exercises, templates and prescriptions."""

from datetime import datetime
from typing import Any, Literal

from sqlalchemy import JSON, Boolean, Float, ForeignKey, Integer, LargeBinary, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from app.database.base import Base, Identified, UtcDateTime

Posture = Literal["standing", "seated"]
"""How an exercise is done."""


class Exercise(Identified, Base):
    """A movement that a clinic prescribes."""

    __tablename__ = "exercise"

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"), index=True)
    name: Mapped[str] = mapped_column(String(200))
    description: Mapped[str] = mapped_column(String(2000), default="")
    movement: Mapped[str] = mapped_column(String(40))
    """Kind, e.g. `reaching`, `drinking`, `abduction`, `flexion`, `pronation`, `other`, or a walking test."""
    side: Mapped[str] = mapped_column(String(10), default="right")
    primary_angle: Mapped[str] = mapped_column(String(80))
    """Joint angle whose range is the main measure of progress; empty for walks."""
    posture: Mapped[Posture] = mapped_column(String(10), default="standing", server_default="standing")
    """Segments without a sensor are drawn in it."""


class Template(Identified, Base):
    """A therapist's recorded reference for one exercise, for one patient or for the clinic."""

    __tablename__ = "template"

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"), index=True)
    exercise_id: Mapped[str] = mapped_column(ForeignKey("exercise.id"), index=True)
    patient_id: Mapped[str | None] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"), index=True)
    """Set when it was made for one patient; such a template is patient data."""
    name: Mapped[str] = mapped_column(String(200))
    tags: Mapped[list[str]] = mapped_column(JSON, default=list, server_default="[]")
    """Words by which the library is searched."""
    retired_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    """No longer offered for new prescriptions; those that have it go on."""
    created_by: Mapped[str] = mapped_column(ForeignKey("account.id"))


class TemplateVersion(Identified, Base):
    """One immutable version of a template: mean trajectory and band over 101 phases."""

    __tablename__ = "template_version"
    __table_args__ = (UniqueConstraint("template_id", "number"),)

    template_id: Mapped[str] = mapped_column(ForeignKey("template.id", ondelete="CASCADE"), index=True)
    number: Mapped[int] = mapped_column(Integer)
    source_session_id: Mapped[str] = mapped_column(String(32))
    source_result_id: Mapped[str] = mapped_column(String(32))
    repetitions: Mapped[list[dict[str, Any]]] = mapped_column(JSON)
    """Start, end, accepted or dropped with its reason, per repetition."""
    tolerance_scale: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """The therapist's widening of the band when it was recorded, per channel; it is within `content`."""
    content: Mapped[bytes] = mapped_column(LargeBinary)
    """`estimators.comparison.Template` in its own codec: what was recorded, nothing of what was drawn."""
    design: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict, server_default="{}")
    """What the therapist drew on it: `TemplateDesign`; read it by `app.assessment.design`."""
    reason: Mapped[str] = mapped_column(String(500), default="", server_default="")
    """Why this version was made, in the therapist's words."""
    is_published: Mapped[bool] = mapped_column(Boolean, default=True)
    created_by: Mapped[str] = mapped_column(ForeignKey("account.id"))


class Prescription(Identified, Base):
    """An exercise with a template, a dose and a period, for one patient."""

    __tablename__ = "prescription"

    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"), index=True)
    exercise_id: Mapped[str] = mapped_column(ForeignKey("exercise.id"))
    template_id: Mapped[str | None] = mapped_column(ForeignKey("template.id"))
    repetitions: Mapped[int] = mapped_column(Integer, default=10)
    sets: Mapped[int] = mapped_column(Integer, default=1)
    times_per_week: Mapped[int] = mapped_column(Integer, default=5)
    days: Mapped[list[int]] = mapped_column(JSON, default=list, server_default="[]")
    """Days of the week, 1 Monday to 7 Sunday; empty: any day."""
    times: Mapped[list[str]] = mapped_column(JSON, default=list, server_default="[]")
    """Times of these days by the clinic's clocks, `HH:MM`; empty: any time."""
    tolerance_scale: Mapped[float] = mapped_column(Float, default=1.0, server_default="1.0")
    """Factor on the whole band of the template for this patient."""
    stops: Mapped[list[dict[str, Any]]] = mapped_column(JSON, default=list, server_default="[]")
    """Stop rules of this patient besides those of the template: `StopDesign`."""
    question: Mapped[str] = mapped_column(String(200), default="", server_default="")
    """Asked after each session besides pain and effort, answered from 0 to 10; empty: nothing more."""
    prescribed_by: Mapped[str] = mapped_column(ForeignKey("account.id"))
    starts_at: Mapped[datetime] = mapped_column(UtcDateTime)
    ends_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


class PrescriptionChange(Identified, Base):
    """What a prescription was until a therapist changed it, and who did when."""

    __tablename__ = "prescription_change"
    __table_args__ = (UniqueConstraint("prescription_id", "number"),)

    prescription_id: Mapped[str] = mapped_column(ForeignKey("prescription.id", ondelete="CASCADE"))
    number: Mapped[int] = mapped_column(Integer)
    """Of the state that ended, from 1: two changes of one state are refused, not laid over each other."""
    before: Mapped[dict[str, Any]] = mapped_column(JSON)
    """The fields that were changed, as they were."""
    changed_by: Mapped[str] = mapped_column(ForeignKey("account.id"))
