"""Wire types of patients."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from app.schemas import Day, Flag, Schema, may_be_absent

Side = Literal["left", "right", "both"]


class BodyDimensionsIn(Schema):
    """Measured lengths between joint centres, in metres; what is absent is scaled from stature."""

    stature_m: float | None = Field(default=None, gt=0.5, lt=2.6)
    upper_arm_m: float | None = Field(default=None, gt=0.1, lt=0.6)
    forearm_m: float | None = Field(default=None, gt=0.1, lt=0.5)
    hand_m: float | None = Field(default=None, gt=0.05, lt=0.35)
    shoulder_width_m: float | None = Field(default=None, gt=0.1, lt=0.7)
    trunk_m: float | None = Field(default=None, gt=0.2, lt=0.9)


class PatientIn(Schema):
    """What is written down about a patient."""

    given_name: str = Field(min_length=1, max_length=100)
    family_name: str = Field(min_length=1, max_length=100)
    birth_date: Day | None = None
    affected_side: Side | None = None
    notes: str = Field(default="", max_length=4000)
    body_dimensions: BodyDimensionsIn = BodyDimensionsIn()


class NewPatientIn(PatientIn):
    """A new patient."""

    agrees_to_treatment: Flag = False
    """The patient was asked and agrees to the purpose `treatment`. When false, nothing is noted, and nothing can be
    recorded before somebody asks."""


class PatientPatch(Schema):
    """Only the fields to change."""

    given_name: str = may_be_absent(min_length=1, max_length=100)
    family_name: str = may_be_absent(min_length=1, max_length=100)
    birth_date: Day | None = None
    affected_side: Side | None = None
    notes: str = may_be_absent(max_length=4000)
    body_dimensions: BodyDimensionsIn | None = None
    is_archived: Flag | None = None
    """True takes the patient off the caseload and lets nothing be added; everything can still be read."""


class ErasureIn(Schema):
    """Erase a patient for good; the word shows that this is meant."""

    confirmation: Literal["ERASE"]


class MountingOut(Schema):
    """How the sensors sat when they were last calibrated on this patient."""

    placements: list[str]
    method: str
    score: float
    updated_at: datetime


class PatientOut(PatientIn):
    """A patient."""

    id: str
    created_at: datetime
    archived_at: datetime | None
    merged_into_id: str | None = None
    """The record of the same person that took everything over; this one is empty and archived."""
    has_mounting: bool
    mounting: MountingOut | None = None
    """The remembered one; only where a single patient is asked for."""
    may_treat: bool
    """The caller may record and prescribe, not only read; never of an archived patient."""
    may_manage: bool
    """The caller may share, take consents, archive and restore."""
