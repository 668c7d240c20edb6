"""Limits on failed sign-ins, per address and per account, in bounded memory; many edges count in the database instead
(`app.accounts.credentials.stored_limit`).

A browser that has signed in to the account before has a budget of its own (`app.accounts.credentials.browsers`), so
that the failures of strangers, however many, do not lock its owner out; a stranger cannot have that budget. Who has no
such browser yet has some tries of the own address, which strangers elsewhere cannot use up either.

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
from estimators.sentences import say


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
"""Of a known browser, and of who is signed in."""
OWN_TRIES = Limit(capacity=3, recovery_s=600.0)
"""Of each address for each account, whatever others do: nobody is locked out from elsewhere."""
STRANGERS = Limit(capacity=5, recovery_s=60.0)
"""Of all strangers to an account together, beyond the tries of their own."""
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
    per_account, per_address, own_tries, strangers : Limit
        See above.
    counting : Counting
        By default in this process.
    """

    def __init__(
        self,
        per_account: Limit = PER_ACCOUNT,
        per_address: Limit = PER_ADDRESS,
        counting: Counting = LeakyCounter,
        *,
        own_tries: Limit = OWN_TRIES,
        strangers: Limit = STRANGERS,
    ) -> None:
        self._accounts = counting(per_account)
        self._addresses = counting(per_address)
        self._own_tries = counting(own_tries)
        self._strangers = counting(strangers)

    def attempt(self, email: str, address: str, browser: str | None = None) -> "Attempt":
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
        account, network = hash_token(email), network_of(address)
        if browser is not None:
            # Not by address either: a stranger may sit in the same house.
            return Attempt([self._taken([(self._accounts, f"{account} {browser}")])])
        of_address = self._taken([(self._addresses, network)])
        try:
            of_account = self._taken([(self._own_tries, f"{account} {network}"), (self._strangers, account)])
        except TooManyAttempts:
            Attempt([of_address]).succeeded()
            raise
        return Attempt([of_address, of_account])

    @staticmethod
    def _taken(budgets: "list[Budget]") -> "Budget":
        """Return the first budget that still allowed an attempt, which is counted there; raises without one."""
        waits = []
        for counter, key in budgets:
            waits.append(counter.take(key))
            if waits[-1] <= 0.0:
                return counter, key
        seconds = math.ceil(min(waits))
        raise TooManyAttempts(say("sign_in.too_many", seconds=seconds), retry_after_s=seconds)


Budget = tuple[Counter, str]
"""A counter and the key in it."""


@dataclass(frozen=True)
class Attempt:
    """A counted attempt.

    Attributes
    ----------
    budgets : list of Budget
        Where it was counted.
    """

    budgets: list[Budget]

    def succeeded(self) -> None:
        """Take it back: only failures count; may block."""
        for counter, key in self.budgets:
            counter.give_back(key)


def network_of(address: str) -> str:
    """Return the key of an address: IPv6 by /64, since one household has 2^64 addresses."""
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv6Address):
        if parsed.ipv4_mapped is not None:
            return str(parsed.ipv4_mapped)
        return str(ipaddress.ip_network((parsed, 64), strict=False))
    return str(parsed)
