"""Wire types of worries."""

from datetime import datetime
from typing import Final, Literal, get_args

from pydantic import Field

from app.schemas import Moment, Schema, Spoken

WorryKind = Literal["pain", "stop", "link_lost", "compensation"]
"""The gravest first."""
KINDS: Final[tuple[WorryKind, ...]] = get_args(WorryKind)


class WorryOut(Spoken):
    """What happened in a session that a therapist must have seen."""

    session_id: str
    kind: WorryKind
    """`pain`: stopped because it hurt, or much pain afterwards. `stop`: a stop rule of the template or prescription.
    `link_lost`: nothing came from the sensors. `compensation`: trunk or shoulder did more than in the template."""
    at: datetime
    """When it happened; where that is not known, when the session began."""
    known_at: datetime
    """When the newest of it became known: to be sent back with a mark, which covers nothing that came later."""
    text: str
    words: str
    """What the patient wrote after the session; empty where nothing was."""
    exercise_name: str | None
    seen_at: datetime | None = None
    """When it was marked as seen; null while it waits for somebody."""
    seen_by: str | None = None
    """Who marked it; null while it waits, and of what happened before such marks were stored."""


class SeenWorry(Schema):
    """A worry as it was shown to who has seen it."""

    session_id: str = Field(max_length=32)
    kind: WorryKind
    known_at: Moment


class SeenIn(Schema):
    """Worries that were looked at."""

    worries: list[SeenWorry] = Field(min_length=1, max_length=200)
