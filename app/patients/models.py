"""Tables of patients and who may see them."""

from datetime import date, datetime
from typing import Any

from sqlalchemy import JSON, Date, ForeignKey, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from app.database.base import Base, Identified, UtcDateTime, utc_now


class Patient(Identified, Base):
    """A person in treatment. FHIR Patient words where there are any."""

    __tablename__ = "patient"

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"), index=True)
    given_name: Mapped[str] = mapped_column(String(100))
    family_name: Mapped[str] = mapped_column(String(100))
    birth_date: Mapped[date | None] = mapped_column(Date)
    affected_side: Mapped[str | None] = mapped_column(String(10))
    """`left`, `right`, `both` or none."""
    notes: Mapped[str] = mapped_column(String(4000), default="")
    body_dimensions: Mapped[dict[str, float]] = mapped_column(JSON, default=dict)
    """Fields of `estimators.pipelines.BodyDimensions` that were measured."""
    archived_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    merged_into_id: Mapped[str | None] = mapped_column(String(32))
    """The record of the same person that took everything over; this one is empty."""


class Mounting(Identified, Base):
    """The last good calibration of a patient's sensors, offered at the next session."""

    __tablename__ = "mounting"
    __table_args__ = (UniqueConstraint("patient_id"),)

    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"))
    calibration: Mapped[dict[str, Any]] = mapped_column(JSON)
    session_id: Mapped[str] = mapped_column(String(32))
    updated_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class SensorDevice(Identified, Base):
    """What is known of one sensor by its serial number; no patient data."""

    __tablename__ = "sensor_device"
    __table_args__ = (UniqueConstraint("clinic_id", "serial"),)

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"))
    serial: Mapped[str] = mapped_column(String(100))
    calibration: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """`estimators.calibration.DeviceCalibration`, made in the hand; empty when none was made."""
    scores: Mapped[dict[str, float]] = mapped_column(JSON, default=dict)
    """Score of each part of `calibration`."""
    constants: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """`estimators.pipelines.DeviceConstants`, learnt while it was worn; empty when nothing was."""
    session_id: Mapped[str] = mapped_column(String(32))
    """Where the newest of it comes from."""
    updated_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class Grant(Identified, Base):
    """A therapist's right to one patient, until it ends or is revoked."""

    __tablename__ = "grant"

    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"), index=True)
    account_id: Mapped[str] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    level: Mapped[str] = mapped_column(String(10), default="treat")
    """`read` or `treat` (read, record, prescribe)."""
    granted_by: Mapped[str] = mapped_column(ForeignKey("account.id"))
    expires_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
