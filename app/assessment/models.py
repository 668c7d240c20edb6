"""Tables of comparisons."""

from datetime import datetime
from typing import Any, Final

from sqlalchemy import JSON, Boolean, Float, ForeignKey, Index, Integer, LargeBinary, String
from sqlalchemy.orm import Mapped, mapped_column

from app.assessment.worries.compensation import largest_compensation
from app.database.base import Base, Identified, UtcDateTime

ALL_REPETITIONS: Final = 0
"""In the place of a repetition's number: a measure that only all repetitions together have."""


class Comparison(Identified, Base):
    """One result compared with one template version."""

    __tablename__ = "comparison"
    __table_args__ = (Index(None, "session_id", "created_at", "id"),)

    session_id: Mapped[str] = mapped_column(ForeignKey("motion_session.id", ondelete="CASCADE"))
    result_id: Mapped[str] = mapped_column(ForeignKey("result.id", ondelete="CASCADE"), index=True)
    template_version_id: Mapped[str] = mapped_column(ForeignKey("template_version.id"))
    version: Mapped[str] = mapped_column(String(20))
    """Version of the comparison method."""
    repetition_count: Mapped[int] = mapped_column(Integer)
    summary: Mapped[dict[str, Any]] = mapped_column(JSON)
    """`ComparisonSummary` of the schemas: each measure with value, unit, spread and count."""
    content: Mapped[bytes] = mapped_column(LargeBinary)
    """Curves and warping paths, `estimators.comparison` codec."""
    compensation: Mapped[dict[str, Any] | None] = mapped_column(
        JSON(none_as_null=True),
        default=lambda context: largest_compensation(context.get_current_parameters()["summary"]),
    )
    """The largest of the summary that is a reason to look, read from it when it is stored."""


class RepetitionMeasure(Base):
    """One measure of one repetition."""

    __tablename__ = "repetition_measure"

    comparison_id: Mapped[str] = mapped_column(
        ForeignKey("comparison.id", ondelete="CASCADE"), primary_key=True
    )
    repetition: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    measure: Mapped[str] = mapped_column(String(80), primary_key=True)
    value: Mapped[float] = mapped_column(Float)
    uncertainty: Mapped[float | None] = mapped_column(Float)
    unit: Mapped[str] = mapped_column(String(12))


class ComparisonMeasure(Base):
    """One measure of a comparison, drawn together over its repetitions when it is stored: what progress reads."""

    __tablename__ = "comparison_measure"

    comparison_id: Mapped[str] = mapped_column(
        ForeignKey("comparison.id", ondelete="CASCADE"), primary_key=True
    )
    measure: Mapped[str] = mapped_column(String(80), primary_key=True)
    unit: Mapped[str] = mapped_column(String(12))
    mean: Mapped[float] = mapped_column(Float)
    mean_square: Mapped[float] = mapped_column(Float)
    """Mean of the squared values."""
    repetitions: Mapped[int] = mapped_column(Integer)
    """Rows that were drawn together; 1 where only all repetitions together have the measure."""
    is_of_all: Mapped[bool] = mapped_column(Boolean)
    """Whether only all repetitions together have it, `ALL_REPETITIONS`."""
    uncertainty: Mapped[float | None] = mapped_column(Float)
    """The largest of the rows; of all repetitions together, that of the value."""


class WorrySeen(Identified, Base):
    """That somebody has seen a worry; the worries themselves are read from sessions (`app.assessment.worries`)."""

    __tablename__ = "worry_seen"

    session_id: Mapped[str] = mapped_column(ForeignKey("motion_session.id", ondelete="CASCADE"), index=True)
    kind: Mapped[str] = mapped_column(String(20))
    """`WorryKind`."""
    known_until: Mapped[datetime] = mapped_column(UtcDateTime)
    """What of this kind became known later in the session was not seen yet."""
    seen_by: Mapped[str] = mapped_column(String(32))
    """Account; empty for what happened long before such marks were stored."""


class CourseNote(Identified, Base):
    """Words of a therapist about a course of therapy; the newest stand in the report, earlier ones stay."""

    __tablename__ = "course_note"

    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"), index=True)
    exercise_id: Mapped[str] = mapped_column(ForeignKey("exercise.id"))
    text: Mapped[str] = mapped_column(String(4000))
    written_by: Mapped[str] = mapped_column(String(32))
