"""Wire types of sessions with a magnetic source: safety, and what the source did."""

from datetime import datetime
from typing import Literal

from app.schemas import Schema, Spoken


class MagneticSafetyIn(Schema):
    """The therapist's word; both must be said."""

    patient_has_no_implant: Literal[True]
    """The patient wears no pacemaker, defibrillator, nerve stimulator, cochlear implant or medicine pump."""
    people_nearby_have_none: Literal[True]
    """Nor does anybody within `keep_away_m` of the source while it is worn."""


class MagneticSafetyOut(Spoken):
    """Whether a session may let its source fire."""

    required: bool
    """The session has a magnetic source."""
    confirmed: bool
    confirmed_at: datetime | None
    confirmed_by: str | None
    """Name of the therapist, for those who work in the clinic; else None."""
    expires_at: datetime | None
    """Asked again from then on; of a confirmation that has ended, when it ended by itself."""
    withdrawn_at: datetime | None
    """When the newest confirmation was revoked."""
    withdrawn_by: str | None
    source: str | None
    """Where the source is worn."""
    keep_away_m: float | None
    """Farther from the source than this its field is below the limit of pacemakers."""
    source_name: str
    source_serial: str
    """Of a source whose coils were measured; empty for typed coils."""
    calibrated_on: str
    gain_sigma: float | None
    """How well the field of the coils is known, as a share of it."""
    limit_t: float
    warning: str


class SourceUseOut(Schema):
    """What the source of a session did: its pulses in order, and their sum."""

    result_id: str
    duration_s: float
    pulse_count: int
    on_time_s: float
    charge_as: float
    current_squared_a2s: float
    """Times the resistance of a coil this is the heat in it, in joule."""
    asked_count: int
    """Pulses that the service asked for."""
    start_s: list[float]
    """Of each pulse; likewise below. At most 5000, of longer sessions the newest."""
    length_s: list[float]
    coil: list[int]
    current_a: list[float]
    time_s: list[float]
    """Of the curves below, at most 600 points."""
    charge_curve_as: list[float]
    sigma_m: dict[str, list[float | None]]
    """By sensor: one sigma of its distance from the source."""
    distance_m: dict[str, list[float | None]]
    state: dict[str, list[int]]
    """By sensor: `estimators.magnetic.RelativeFlag` bits."""
    inertial_only_s: dict[str, float]
    """By sensor: how long it went without the source."""
