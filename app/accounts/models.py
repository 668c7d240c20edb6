"""Tables of clinics, people, sign-in and audit."""

from datetime import datetime
from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Double,
    ForeignKey,
    Index,
    Integer,
    String,
    UniqueConstraint,
    column,
    false,
    table,
)
from sqlalchemy.orm import Mapped, mapped_column

from app.database.base import Base, Identified, UtcDateTime, utc_now


class Clinic(Identified, Base):
    """A tenant: nothing of one clinic is visible in another."""

    __tablename__ = "clinic"

    name: Mapped[str] = mapped_column(String(200))
    time_zone: Mapped[str | None] = mapped_column(String(64))
    """IANA name, for instance `Europe/Oslo`; None for the setting `time_zone` of the service."""


class Account(Identified, Base):
    """A person or machine that can sign in: administrator, therapist, patient or integrator."""

    __tablename__ = "account"
    __table_args__ = (UniqueConstraint("email"),)

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"), index=True)
    role: Mapped[str] = mapped_column(String(20))
    email: Mapped[str] = mapped_column(String(254))
    display_name: Mapped[str] = mapped_column(String(200))
    password_hash: Mapped[str | None] = mapped_column(String(200))
    patient_id: Mapped[str | None] = mapped_column(ForeignKey("patient.id", use_alter=True))
    """The patient record of an account with the role patient."""
    is_active: Mapped[bool] = mapped_column(Boolean, default=True)
    locale: Mapped[str] = mapped_column(String(10), default="")
    """Language chosen for the account; empty: as the browser asks."""
    must_change_password: Mapped[bool] = mapped_column(Boolean, default=False, server_default=false())
    """An administrator knows the present one: nothing else can be done before it is changed."""
    totp_secret: Mapped[str | None] = mapped_column(String(64))
    """Of the second factor; in force once `totp_since` is set."""
    totp_since: Mapped[datetime | None] = mapped_column(UtcDateTime)
    totp_last_step: Mapped[int] = mapped_column(BigInteger, default=0, server_default="0")
    """The newest step whose code was used: none is good twice."""
    totp_removed_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    """When an administrator took the second factor away; the person is shown a notice until they have read it."""
    recovery_hashes: Mapped[list[str]] = mapped_column(JSON, default=list, server_default="[]")
    """Of the recovery codes that are left."""


PATIENT = table("patient", column("id", String(32)), column("clinic_id", String(32)))
"""What accounts need of the table that `Account.patient_id` refers to; patients are built on accounts, so their
classes are not known here."""


class SignIn(Identified, Base):
    """A browser session; only the hash of its cookie is stored."""

    __tablename__ = "sign_in"

    account_id: Mapped[str] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    token_hash: Mapped[str] = mapped_column(String(64), unique=True)
    csrf_token: Mapped[str] = mapped_column(String(64))
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)
    last_seen_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    user_agent: Mapped[str] = mapped_column(String(200), default="")


class KnownBrowser(Identified, Base):
    """A browser in which an account has signed in; only the hash of its cookie is stored."""

    __tablename__ = "known_browser"
    __table_args__ = (UniqueConstraint("account_id", "token_hash"),)

    account_id: Mapped[str] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"))
    token_hash: Mapped[str] = mapped_column(String(64))
    seen_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class DeviceToken(Identified, Base):
    """A gateway's credential, bound to one patient; the JWT carries this id and can be revoked here."""

    __tablename__ = "device_token"
    __table_args__ = (Index(None, "patient_id", "created_at", "id"),)

    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"), index=True)
    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"))
    label: Mapped[str] = mapped_column(String(100))
    created_by: Mapped[str] = mapped_column(ForeignKey("account.id"))
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


class Ticket(Identified, Base):
    """One-use, 30-second right to open one socket: purpose `ingest`, `live` or `viewer`."""

    __tablename__ = "ticket"

    token_hash: Mapped[str] = mapped_column(String(64), unique=True)
    purpose: Mapped[str] = mapped_column(String(20))
    account_id: Mapped[str | None] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"))
    device_token_id: Mapped[str | None] = mapped_column(ForeignKey("device_token.id", ondelete="CASCADE"))
    sign_in_id: Mapped[str | None] = mapped_column(String(32))
    """The browser session that asked for it: the ticket and the socket it opens are worth nothing after that."""
    session_id: Mapped[str] = mapped_column(String(32))
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)
    used_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


class PairingCode(Identified, Base):
    """One-use, ten-minute right to one device token of a patient; see `app.accounts.pairing`."""

    __tablename__ = "pairing_code"

    code_hash: Mapped[str] = mapped_column(String(64), unique=True)
    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"), index=True)
    account_id: Mapped[str] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"))
    label: Mapped[str] = mapped_column(String(100))
    days: Mapped[int] = mapped_column(Integer)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)


class AttemptCount(Base):
    """How often something failed, counted by all edges; see `app.accounts.credentials.stored_limit`."""

    __tablename__ = "attempt_count"

    key_hash: Mapped[str] = mapped_column(String(64), primary_key=True)
    empty_at: Mapped[float] = mapped_column(Double, index=True)
    """Seconds since the epoch: when the level will be zero."""


class Consent(Identified, Base):
    """A patient's yes or no to one purpose: `treatment`, `research`, `home_streaming`."""

    __tablename__ = "consent"
    __table_args__ = (UniqueConstraint("patient_id", "purpose"),)

    patient_id: Mapped[str] = mapped_column(ForeignKey("patient.id", ondelete="CASCADE"), index=True)
    purpose: Mapped[str] = mapped_column(String(40))
    granted: Mapped[bool] = mapped_column(Boolean)
    changed_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    changed_by: Mapped[str] = mapped_column(ForeignKey("account.id"))


class AuditEvent(Base):
    """One read or write of patient data; append-only, each row carries the hash of the one before."""

    __tablename__ = "audit_event"
    __table_args__ = (
        UniqueConstraint("clinic_id", "number"),
        Index("ix_audit_event_patient_id_at", "patient_id", "at"),
        Index(None, "patient_id", "number"),
    )

    id: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    clinic_id: Mapped[str] = mapped_column(ForeignKey("clinic.id"))
    number: Mapped[int] = mapped_column(Integer)
    """Position in the clinic's chain, from 1."""
    at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    subject_kind: Mapped[str] = mapped_column(String(20))
    subject_id: Mapped[str] = mapped_column(String(32))
    action: Mapped[str] = mapped_column(String(60))
    """Noun and verb: `patient.read`, `session.create`, `template.publish`, `grant.revoke`, ..."""
    patient_id: Mapped[str | None] = mapped_column(String(32))
    resource_id: Mapped[str | None] = mapped_column(String(32))
    details: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    previous_hash: Mapped[str] = mapped_column(String(64))
    hash: Mapped[str] = mapped_column(String(64))
