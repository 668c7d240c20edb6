"""Refused sign-ins in the audit trail, without what was typed.

For an account that exists, the event names it in its clinic's chain, where its owner can see it too. An unknown
address belongs to no clinic: it goes to the log as a keyed fingerprint, so that repeated attempts differ from many
different ones and nobody can look the address up. Both are done by one thread of their own, after the refusal
was given: the time of the answer must not tell whether the account exists.
"""

import hashlib
import hmac
import logging
import threading
from concurrent.futures import ThreadPoolExecutor

from sqlalchemy import Engine, select

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.database.unit_of_work import read_only, unit_of_work
from app.settings import Settings

logger = logging.getLogger("telemotion.sign_in")

MAXIMUM_WAITING = 200
"""Above it, refusals are only counted: a flood must not fill the memory."""


class RefusedSignIns:
    """Notes refused sign-ins, one after the other.

    Parameters
    ----------
    settings : Settings
        For the key of fingerprints.
    """

    def __init__(self, engine: Engine, settings: Settings) -> None:
        self._engine = engine
        self._key = settings.key_for("refused-sign-in")
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="refused sign-ins")
        self._lock = threading.Lock()
        self._waiting = 0
        self._passed_over = 0
        self.refused = 0

    def note(self, email: str) -> None:
        """Note one refusal soon; returns at once.

        Parameters
        ----------
        email : str
            Normalised.
        """
        with self._lock:
            self.refused += 1
            if self._waiting >= MAXIMUM_WAITING:
                self._passed_over += 1
                return
            self._waiting += 1
        self._pool.submit(self._write, email)

    def settle(self) -> None:
        """Wait until everything noted so far is written."""
        self._pool.submit(lambda: None).result()

    def close(self) -> None:
        """Write what waits and stop."""
        self._pool.shutdown(wait=True)

    def fingerprint(self, email: str) -> str:
        """Return what the log says instead of an address: 64 bits, the same as long as the service's secret is.

        Parameters
        ----------
        email : str
            Normalised.
        """
        return hmac.new(self._key, email.encode(), hashlib.sha256).hexdigest()[:16]

    def _write(self, email: str) -> None:
        with self._lock:
            self._waiting -= 1
            passed_over, self._passed_over = self._passed_over, 0
        try:
            if passed_over:
                logger.warning("%d refused sign-ins were not noted one by one", passed_over)
            self._note(email)
        except Exception:
            logger.exception("a refused sign-in could not be noted")

    def _note(self, email: str) -> None:
        with read_only(self._engine) as session:
            row = session.execute(
                select(Account.id, Account.clinic_id, Account.patient_id, Account.is_active).where(
                    Account.email == email
                )
            ).first()
        if row is None:
            logger.warning("sign-in refused for an unknown address (%s)", self.fingerprint(email))
            return
        details = {"reason": "wrong password" if row.is_active else "switched off"}
        with unit_of_work(self._engine) as session:
            subject = Subject.system(row.clinic_id)
            audit.record(session, subject, "account.sign_in_refused", row.patient_id, row.id, details)
