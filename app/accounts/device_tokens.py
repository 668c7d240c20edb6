"""Device tokens: JWTs of gateways and phones, each bound to one patient and revocable."""

from datetime import UTC, datetime, timedelta
from typing import Any

import jwt
from sqlalchemy import Row, select
from sqlalchemy.orm import Session

from app.accounts.models import DeviceToken
from app.accounts.subject import Subject
from app.database.base import new_id, utc_now
from app.errors import NotFound, SignInRequired
from app.pages import Page, rows_of
from app.settings import Settings
from estimators.sentences import say

ALGORITHM = "HS256"
AUDIENCE = "telemotion:device"
_REFUSED = say("device.token_refused")


def create_device_token(
    session: Session, settings: Settings, subject: Subject, patient_id: str, label: str, days: int
) -> tuple[DeviceToken, str]:
    """Make a credential for one device of one patient; the caller has checked the right to the patient.

    Parameters
    ----------
    settings : Settings
        For the signing secret.
    subject : Subject
        An account.
    patient_id : str
        The only patient whose sessions the device may feed.
    label : str
        So that a person can tell the devices apart.
    days : int
        Life time.

    Returns
    -------
    DeviceToken
        The row that can be revoked.
    str
        The JWT; it is not stored and cannot be shown again.
    """
    now = utc_now().replace(microsecond=0)
    row = DeviceToken(
        id=new_id(),
        clinic_id=subject.clinic_id,
        patient_id=patient_id,
        label=label,
        created_by=subject.account_id or subject.id,
        created_at=now,
        expires_at=now + timedelta(days=days),
        revoked_at=None,
    )
    session.add(row)
    session.flush()
    claims = {
        "sub": row.id,
        "aud": AUDIENCE,
        "patient": patient_id,
        "clinic": subject.clinic_id,
        "iat": now,
        "exp": row.expires_at,
    }
    return row, jwt.encode(claims, settings.key_for("device-token"), algorithm=ALGORITHM)


def subject_of_device_token(session: Session, settings: Settings, token: str) -> Subject:
    """Return the subject behind a JWT.

    Parameters
    ----------
    token : str
        From `Authorization: Bearer`.

    Raises
    ------
    SignInRequired
        Forged, expired, revoked, or for another service.
    """
    try:
        claims = jwt.decode(
            token,
            settings.key_for("device-token"),
            algorithms=[ALGORITHM],
            audience=AUDIENCE,
            options={"require": ["sub", "aud", "exp", "iat"]},
        )
    except jwt.InvalidTokenError as error:
        raise SignInRequired(_REFUSED) from error
    row = session.get(DeviceToken, str(claims["sub"]))
    if row is None or not is_valid(row) or row.patient_id != claims.get("patient"):
        raise SignInRequired(_REFUSED)
    return device_subject(row)


def device_subject(row: DeviceToken) -> Subject:
    """Return the subject of a device token's row."""
    return Subject("device", row.id, None, row.clinic_id, "device", row.patient_id)


def is_valid(row: DeviceToken | Row[*tuple[Any, ...]], at: datetime | None = None) -> bool:
    """Return whether a token is neither revoked nor expired.

    Parameters
    ----------
    row : DeviceToken or Row
        The row has `revoked_at` and `expires_at`.
    at : datetime, optional
        Now when absent.
    """
    return row.revoked_at is None and bool(row.expires_at > (at or datetime.now(UTC)))


def list_device_tokens(session: Session, patient_id: str, page: Page) -> list[DeviceToken]:
    """Return a page of the credentials of a patient's devices, newest first; the caller has checked the right."""
    query = select(DeviceToken).where(DeviceToken.patient_id == patient_id)
    order = (DeviceToken.created_at, DeviceToken.id)
    return [row for (row,) in rows_of(session, query, order, page, newest_first=True)]


def get_device_token(session: Session, subject: Subject, token_id: str) -> DeviceToken:
    """Return a credential of the subject's clinic; the caller then checks the right to its patient.

    Raises
    ------
    NotFound
        No such token in this clinic.
    """
    row = session.get(DeviceToken, token_id)
    if row is None or row.clinic_id != subject.clinic_id:
        raise NotFound(say("device.token_not_found"))
    return row
