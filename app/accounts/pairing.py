"""Pairing codes: eight characters that a gateway exchanges once, within minutes, for its device token.

They wait in the database, so every edge redeems what another one gave. Only a hash with a key of the service is stored:
who reads the table could try all 30^8 codes, but not without that key.
"""

import hmac
import math
import secrets
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from app.accounts.credentials.rate_limit import Counting, LeakyCounter, Limit, network_of
from app.accounts.credentials.tickets import account_subject
from app.accounts.models import Account, PairingCode
from app.accounts.schemas import DeviceTokenIn
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import SignInRequired, TooManyAttempts
from app.settings import Settings
from estimators.sentences import say

ALPHABET: Final = "23456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Without characters that are mistaken for each other."""
LENGTH: Final = 8
LIFE: Final = timedelta(minutes=10)
PER_PATIENT: Final = 20
"""Codes that wait at once; the oldest are deleted."""
PER_ADDRESS: Final = Limit(capacity=10, recovery_s=30.0)
"""Wrong codes: with 30^8 codes and ten minutes, guessing one of a thousand takes an address 600 years."""


@dataclass(frozen=True)
class Offer:
    """What a code stands for: a device token of a patient, given by an account."""

    giver: Subject
    patient_id: str
    wanted: DeviceTokenIn


class PairingBook:
    """The codes that wait for their gateways.

    Parameters
    ----------
    settings : Settings
        For the key of the hashes.
    per_address : Limit
        Of wrong codes.
    counting : Counting
        Of them; by default in this process.
    """

    def __init__(
        self,
        settings: Settings,
        per_address: Limit = PER_ADDRESS,
        counting: Counting = LeakyCounter,
    ) -> None:
        self._key = settings.key_for("pairing-code")
        self._wrong = counting(per_address)

    def offer(self, session: Session, offer: Offer) -> tuple[str, datetime]:
        """Return a new code and when it expires; the caller has checked the right to the patient.

        Parameters
        ----------
        session : Session
            Writing.
        offer : Offer
            Its giver is an account.
        """
        now = utc_now()
        code = "".join(secrets.choice(ALPHABET) for _ in range(LENGTH))
        too_many = (
            select(PairingCode.id)
            .where(PairingCode.patient_id == offer.patient_id)
            .order_by(PairingCode.expires_at.desc(), PairingCode.id)
            .offset(PER_PATIENT - 1)
        )
        for old in (PairingCode.expires_at <= now, PairingCode.id.in_(session.scalars(too_many).all())):
            session.execute(delete(PairingCode).where(old))
        row = PairingCode(
            code_hash=self._hash(code),
            patient_id=offer.patient_id,
            account_id=offer.giver.account_id or offer.giver.id,
            label=offer.wanted.label,
            days=offer.wanted.days,
            expires_at=now + LIFE,
        )
        session.add(row)
        session.flush()
        return code, row.expires_at

    def take(self, session: Session, code: str, address: str) -> Offer:
        """Use a code up.

        Parameters
        ----------
        session : Session
            Writing, nothing done yet; the code is used up when it commits.
        code : str
            As typed: small letters, blanks and dashes do not matter.
        address : str
            Of the client, for the limit.

        Raises
        ------
        SignInRequired
            Unknown, used or too old, or its giver is no longer active.
        TooManyAttempts
            Too many wrong codes from this address.
        """
        key = f"pairing {network_of(address)}"
        # Before the session has a connection: nobody holds two.
        wait_s = self._wrong.take(key)
        if wait_s > 0.0:
            seconds = math.ceil(wait_s)
            raise TooManyAttempts(say("device.too_many_codes", seconds=seconds), retry_after_s=seconds)
        plain = "".join(character for character in code.upper() if character.isalnum())
        # One statement decides who was first, on every database.
        row = session.execute(
            delete(PairingCode)
            .where(PairingCode.code_hash == self._hash(plain), PairingCode.expires_at > utc_now())
            .returning(PairingCode.account_id, PairingCode.patient_id, PairingCode.label, PairingCode.days)
            .execution_options(synchronize_session=False)
        ).one_or_none()
        giver = None if row is None else session.get(Account, row.account_id)
        if row is None or giver is None or not giver.is_active:
            raise SignInRequired(say("device.code_refused"))
        self._wrong.give_back(key, session)
        return Offer(account_subject(giver), row.patient_id, DeviceTokenIn(label=row.label, days=row.days))

    def _hash(self, code: str) -> str:
        return hmac.digest(self._key, code.encode(), "sha256").hex()
