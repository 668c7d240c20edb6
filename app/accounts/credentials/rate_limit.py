"""Limits on failed sign-ins, per address and per account, in bounded memory; many edges count in the database instead
(`app.accounts.credentials.stored_limit`).

A browser that has signed in to the account before has a budget of its own (`app.accounts.credentials.browsers`), so
that the failures of strangers, however many, do not lock its owner out; a stranger cannot have that budget.

Each key has a level that every attempt raises by one and that time lowers steadily; above the capacity an
attempt is refused with the time after which the next one is allowed. An attempt is counted before its
password is checked (so many at once cannot slip past) and refunded when it succeeds. Accounts are limited
whether they exist or not, so the limit says nothing about them.
"""

import ipaddress
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from sqlalchemy.orm import Session

from app.accounts.credentials.tokens import hash_token
from app.errors import TooManyAttempts
from app.sentences import say


@dataclass(frozen=True)
class Limit:
    """How much a key may do.

    Attributes
    ----------
    capacity : int
        Attempts in one burst.
    recovery_s : float
        Time that gives one attempt back.
    """

    capacity: int
    recovery_s: float


PER_ACCOUNT = Limit(capacity=8, recovery_s=60.0)
PER_ADDRESS = Limit(capacity=30, recovery_s=20.0)
"""Wider: a whole clinic may share one address."""


class Counter(Protocol):
    """Counts attempts per key; both may block."""

    def take(self, key: str) -> float:
        """Count an attempt; see `LeakyCounter.take`."""

    def give_back(self, key: str, session: Session | None = None) -> None:
        """Take one counted attempt back, where it is counted in the database in the transaction of a session."""


Counting = Callable[[Limit], Counter]
"""Makes a counter. All that are made may share their keys."""


class LeakyCounter:
    """Counts attempts per key; levels leak away with time.

    Parameters
    ----------
    limit : Limit
    maximum_keys : int
        Above it the keys that were quiet longest are forgotten.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self, limit: Limit, maximum_keys: int = 20_000, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._limit = limit
        self._maximum_keys = maximum_keys
        self._clock = clock
        self._levels: OrderedDict[str, tuple[float, float]] = OrderedDict()
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._levels)

    def take(self, key: str) -> float:
        """Count an attempt.

        Parameters
        ----------
        key : str

        Returns
        -------
        float
            0 when allowed; otherwise the seconds until one is, and nothing is counted.
        """
        with self._lock:
            level = self._level(key)
            if level + 1.0 > self._limit.capacity + 1e-9:
                return (level + 1.0 - self._limit.capacity) * self._limit.recovery_s
            self._set(key, level + 1.0)
            return 0.0

    def give_back(self, key: str, session: Session | None = None) -> None:
        """Take one counted attempt back.

        Parameters
        ----------
        key : str
        session : Session, optional
            Of no use here.
        """
        with self._lock:
            self._set(key, self._level(key) - 1.0)

    def _level(self, key: str) -> float:
        level, at = self._levels.get(key, (0.0, 0.0))
        return max(0.0, level - (self._clock() - at) / self._limit.recovery_s) if level else 0.0

    def _set(self, key: str, level: float) -> None:
        if level <= 0.0:
            self._levels.pop(key, None)
            return
        self._levels[key] = (level, self._clock())
        self._levels.move_to_end(key)
        while len(self._levels) > self._maximum_keys:
            self._levels.popitem(last=False)


class SignInLimits:
    """The limits of a sign-in.

    Parameters
    ----------
    per_account, per_address : Limit
        `per_account` holds for all strangers together, and for each known browser.
    counting : Counting
        By default in this process.
    """

    def __init__(
        self,
        per_account: Limit = PER_ACCOUNT,
        per_address: Limit = PER_ADDRESS,
        counting: Counting = LeakyCounter,
    ) -> None:
        self._accounts = counting(per_account)
        self._addresses = counting(per_address)

    def attempt(self, email: str, address: str, browser: str | None = None) -> None:
        """Count an attempt before its password is checked; may block.

        Parameters
        ----------
        email : str
            Already in lower case.
        address : str
            Of the client.
        browser : str, optional
            Key of a browser that has signed in to this account before.

        Raises
        ------
        TooManyAttempts
            With `retry_after_s`.
        """
        counters = self._counters(email, address, browser)
        for number, (counter, key) in enumerate(counters):
            wait = counter.take(key)
            if wait > 0.0:
                for taken, its_key in counters[:number]:
                    taken.give_back(its_key)
                seconds = math.ceil(wait)
                raise TooManyAttempts(say("sign_in.too_many", seconds=seconds), retry_after_s=seconds)

    def succeeded(self, email: str, address: str, browser: str | None = None) -> None:
        """Take the attempt back: only failures count; may block.

        Parameters
        ----------
        email, address, browser : str
            As for `attempt`.
        """
        for counter, key in self._counters(email, address, browser):
            counter.give_back(key)

    def _counters(self, email: str, address: str, browser: str | None) -> list[tuple[Counter, str]]:
        account = hash_token(email)
        if browser is not None:
            # Not by address either: a stranger may sit in the same house.
            return [(self._accounts, f"{account} {browser}")]
        return [(self._addresses, network_of(address)), (self._accounts, account)]


def network_of(address: str) -> str:
    """Return the key of an address: IPv6 by /64, since one household has 2^64 addresses.

    Parameters
    ----------
    address : str
    """
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv6Address):
        if parsed.ipv4_mapped is not None:
            return str(parsed.ipv4_mapped)
        return str(ipaddress.ip_network((parsed, 64), strict=False))
    return str(parsed)
