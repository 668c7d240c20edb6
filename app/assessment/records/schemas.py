"""Wire types of putting records right."""

from pydantic import Field

from app.schemas import Schema


class SessionPatch(Schema):
    """Whose session it was, and which exercise; what is absent stays."""

    patient_id: str | None = Field(default=None, max_length=32)
    """The patient who did it: of the same clinic, and the caller may treat both."""
    exercise_id: str | None = Field(default=None, max_length=32)
    reason: str = Field(min_length=1, max_length=300)
    """Why; it stays in the audit trails of both patients, also after an erasure: no names."""


class MergeIn(Schema):
    """Two records of one person made one."""

    other_id: str = Field(max_length=32)
    """The record whose content moves; it stays in the archive, empty."""
    reason: str = Field(min_length=1, max_length=300)
    """Why; it stays in both audit trails: no names."""


class MergeOut(Schema):
    """What moved into the record that stays."""

    patient_id: str
    sessions: int
    prescriptions: int
    templates: int
    notes: int
    revoked_tokens: int
    """Devices of the other record: each is connected again to the one that stays."""
    withdrawn_consents: list[str]
    """Purposes that the patient had agreed to here and refused in the other record: the refusal holds."""
