"""Wire types of what a patient says after an exercise."""

from datetime import datetime
from typing import Annotated

from pydantic import Field

from app.schemas import Schema

Mark = Annotated[int, Field(ge=0, le=10)]
"""0 none at all, 10 the most that can be thought of."""


class AnswersIn(Schema):
    """What a patient says; each may be left out."""

    pain: Mark | None = None
    effort: Mark | None = None
    third: Mark | None = None
    """Answer to the question that the therapist chose; 0 no, 10 yes, very much."""
    note: str = Field(default="", max_length=2000)


class AnswersOut(AnswersIn):
    """The same as stored; all empty before it was said."""

    question: str
    """The therapist's own; as it was when it was answered. Empty where there is none."""
    answered_at: datetime | None = None
