"""A patient's devices: their tokens, and the codes that stand for them until a gateway has fetched one.

All of it is for who may manage the patient's data, and for the patient: somebody's own telephone.
"""

from sqlalchemy.orm import Session

from app.accounts.audit import record
from app.accounts.device_tokens import create_device_token, get_device_token, list_device_tokens
from app.accounts.models import DeviceToken
from app.accounts.pairing import Offer, PairingBook
from app.accounts.schemas import DeviceTokenIn, DeviceTokenOut, PairingCodeOut
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import NotFound
from app.pages import Page
from app.patients.access import require_own_or_manage
from app.settings import Settings
from estimators.sentences import say


def device_tokens(session: Session, subject: Subject, patient_id: str, page: Page) -> list[DeviceTokenOut]:
    """Return a page of a patient's device tokens without the tokens themselves."""
    require_own_or_manage(session, subject, patient_id)
    record(session, subject, "device_token.list", patient_id)
    return [_token_out(row) for row in list_device_tokens(session, patient_id, page)]


def add_device_token(
    session: Session, settings: Settings, subject: Subject, patient_id: str, wanted: DeviceTokenIn
) -> DeviceTokenOut:
    """Make a device token; it is shown this once."""
    require_own_or_manage(session, subject, patient_id)
    row, token = create_device_token(session, settings, subject, patient_id, wanted.label, wanted.days)
    record(session, subject, "device_token.create", patient_id, row.id)
    return _token_out(row, token)


def offer_pairing(session: Session, book: PairingBook, offer: Offer) -> PairingCodeOut:
    """Make a code that a gateway exchanges for a device token.

    Parameters
    ----------
    offer : Offer
        The token, and who gives it.
    """
    require_own_or_manage(session, offer.giver, offer.patient_id)
    record(session, offer.giver, "device_token.offer", offer.patient_id)
    code, expires_at = book.offer(session, offer)
    return PairingCodeOut(code=code, expires_at=expires_at)


def pair(session: Session, settings: Settings, offer: Offer) -> DeviceTokenOut:
    """Make the device token that a code stood for; the giver must still have the right to it.

    Parameters
    ----------
    offer : Offer
        From a code that was used up.
    """
    return add_device_token(session, settings, offer.giver, offer.patient_id, offer.wanted)


def revoke_device_token(session: Session, subject: Subject, token_id: str) -> None:
    """End a device token now."""
    row = get_device_token(session, subject, token_id)
    try:
        require_own_or_manage(session, subject, row.patient_id)
    except NotFound:
        raise NotFound(say("device.token_not_found")) from None
    row.revoked_at = row.revoked_at or utc_now()
    record(session, subject, "device_token.revoke", row.patient_id, row.id)


def _token_out(row: DeviceToken, token: str | None = None) -> DeviceTokenOut:
    return DeviceTokenOut(
        id=row.id,
        label=row.label,
        created_at=row.created_at,
        expires_at=row.expires_at,
        revoked_at=row.revoked_at,
        token=token,
    )
