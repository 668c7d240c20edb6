"""Wire types of the report of a course of therapy."""

from datetime import datetime

from pydantic import Field

from app.schemas import Schema, Spoken


class CourseNoteIn(Schema):
    """Words of the therapist for the report; they take the place of earlier ones, which stay stored."""

    exercise_id: str
    text: str = Field(max_length=4000)
    """Empty takes them out of the report."""


class CourseNoteOut(Schema):
    """The words, who wrote them and when."""

    id: str
    exercise_id: str
    text: str
    written_by: str
    created_at: datetime


class CourseOut(Spoken):
    """What a course of therapy in one exercise was; its measures are those of progress."""

    exercise_id: str
    exercise_name: str
    session_count: int
    """Sessions in which something valid was done."""
    first_at: datetime | None
    last_at: datetime | None
    valid_repetitions: int
    active_s: float
    prescribed: list[str]
    """Each dose in words, oldest first."""
    adherence_percent: float | None
    """Over the last four weeks."""
    pain_stops: int = 0
    """Sessions of the last four weeks that ended because it hurt."""
    first_comparison_id: str | None
    last_comparison_id: str | None
    """Of the first and of the newest compared session, by their main results."""
    note: CourseNoteOut | None
    service_version: str
    """Of the software that made the report."""
