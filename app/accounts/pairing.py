"""Pairing codes: eight characters that a gateway exchanges once, within minutes, for its device token.

They are held in this process (one process writes a database) and only as hashes: a service that is started again
forgets them, and a new one is made.
"""

import math
import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from app.accounts.credentials.rate_limit import LeakyCounter, Limit, network_of
from app.accounts.credentials.tokens import hash_token
from app.accounts.schemas import DeviceTokenIn
from app.accounts.subject import Subject
from app.errors import SignInRequired, TooManyAttempts
from app.sentences import say

ALPHABET: Final = "23456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Without characters that are mistaken for each other."""
LENGTH: Final = 8
LIFE_S: Final = 600.0
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
    per_address : Limit
        Of wrong codes.
    maximum : int
        Codes at once; above it the oldest are forgotten.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self,
        per_address: Limit = PER_ADDRESS,
        maximum: int = 10_000,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._wrong = LeakyCounter(per_address, clock=clock)
        self._maximum = maximum
        self._clock = clock
        self._offers: OrderedDict[str, tuple[float, Offer]] = OrderedDict()
        self._lock = threading.Lock()

    def offer(self, offer: Offer) -> str:
        """Return a new code, valid for ten minutes.

        Parameters
        ----------
        offer : Offer
        """
        code = "".join(secrets.choice(ALPHABET) for _ in range(LENGTH))
        with self._lock:
            self._offers[hash_token(code)] = (self._clock() + LIFE_S, offer)
            while len(self._offers) > self._maximum:
                self._offers.popitem(last=False)
        return code

    def take(self, code: str, address: str) -> Offer:
        """Use a code up.

        Parameters
        ----------
        code : str
            As typed: small letters, blanks and dashes do not matter.
        address : str
            Of the client, for the limit.

        Raises
        ------
        SignInRequired
            Unknown, used or too old.
        TooManyAttempts
            Too many wrong codes from this address.
        """
        key = network_of(address)
        wait_s = self._wrong.take(key)
        if wait_s > 0.0:
            seconds = math.ceil(wait_s)
            raise TooManyAttempts(say("device.too_many_codes", seconds=seconds), retry_after_s=seconds)
        plain = "".join(character for character in code.upper() if character.isalnum())
        with self._lock:
            expires, offer = self._offers.pop(hash_token(plain), (0.0, None))
        if offer is None or expires <= self._clock():
            raise SignInRequired(say("device.code_refused"))
        self._wrong.give_back(key)
        return offer
