"""Wire types of patients."""

import re
import unicodedata
from datetime import UTC, date, datetime, timedelta
from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, Field, model_validator

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


OLDEST_YEARS: Final = 125
_TURNS: Final = re.compile("[\u200b\u200e\u200f\u202a-\u202e\u2060-\u2069\ufeff\u061c]")
"""Characters without a width that turn the direction of writing or hide in a name."""


def _name(value: str) -> str:
    """Return a name without blanks around it, and refuse what nobody's name has."""
    if _TURNS.search(value) or any(unicodedata.category(letter) in {"Cc", "Zl", "Zp"} for letter in value):
        raise ValueError("a name must not hold line breaks or characters that turn the direction of writing")
    return " ".join(value.split())


def _born(value: date | None) -> date | None:
    """Refuse a birth that nobody living has."""
    if value is None:
        return None
    # Somewhere it is tomorrow already.
    today = datetime.now(UTC).date() + timedelta(days=1)
    if value > today:
        raise ValueError(f"{value.isoformat()} is in the future (year {value.year}); check the year of birth")
    if value.year < today.year - OLDEST_YEARS:
        raise ValueError(
            f"{value.isoformat()} is more than {OLDEST_YEARS} years ago (year {value.year}); check the year of birth"
        )
    return value


Name = Annotated[str, Field(max_length=100), AfterValidator(_name)]
Birth = Annotated[Day, AfterValidator(_born)]


class PatientIn(Schema):
    """What is written down about a patient: at least one name; some people have one only."""

    given_name: Name
    family_name: Name
    birth_date: Birth | None = None
    affected_side: Side | None = None
    notes: str = Field(default="", max_length=4000)
    body_dimensions: BodyDimensionsIn = BodyDimensionsIn()


class NewPatientIn(PatientIn):
    """A new patient."""

    is_another_person: Flag = False
    """Somebody looked: the patient of the same name and date of birth who is there already is another person."""

    agrees_to_treatment: Flag = False
    """The patient was asked and agrees to the purpose `treatment`. When false, nothing is noted, and nothing can be
    recorded before somebody asks."""

    @model_validator(mode="after")
    def _has_a_name(self) -> Self:
        if not self.given_name and not self.family_name:
            raise ValueError("given_name, family_name: write at least one name")
        return self


class PatientPatch(Schema):
    """Only the fields to change."""

    given_name: Name = may_be_absent()
    family_name: Name = may_be_absent()
    birth_date: Birth | None = None
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

    given_name: str
    family_name: str
    birth_date: date | None = None
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
