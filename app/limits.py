"""How much of the service one account and one clinic may use at once: one counter for every kind of resource.

What is counted is a row of `RESOURCES`; how much is allowed is a setting of each, `account/clinic/service`. Who wants
more than the own share gets `LimitReached` (429), who comes when the whole service is full `Unavailable` (503); both
say what to do and when to come back.
"""

import threading
from collections import Counter
from collections.abc import Mapping
from types import TracebackType
from typing import Final, Literal, Protocol

from app.errors import LimitReached, Unavailable
from app.settings import Allowance
from estimators.sentences import Sentence, say

Resource = Literal["views", "streams", "sockets", "uploads", "exports"]

RESOURCES: Final[dict[Resource, tuple[Sentence, int]]] = {
    "views": (say("limit.views"), 60),
    "streams": (say("limit.streams"), 30),
    "sockets": (say("limit.sockets"), 30),
    "uploads": (say("limit.uploads"), 15),
    "exports": (say("limit.exports"), 30),
}
"""What is counted: what to do when there are too many, and when to come back, s."""


class Holder(Protocol):
    """Who holds something: a subject of `app.accounts`."""

    @property
    def id(self) -> str:
        """Account or device token."""

    @property
    def clinic_id(self) -> str:
        """The tenant."""


class Limits:
    """Counts what is held; from any thread."""

    def __init__(self, allowances: Mapping[Resource, Allowance]) -> None:
        self._allowances = dict(allowances)
        self._held: Counter[tuple[Resource, str]] = Counter()
        self._lock = threading.Lock()

    def take(self, resource: Resource, holder: Holder) -> "Hold":
        """Hold one; give it back with `Hold.release`, or use it in a `with` statement.

        Raises
        ------
        LimitReached
            The account or the clinic has as many as it may.
        Unavailable
            The whole service is full.
        """
        allowed = self._allowances[resource]
        advice, retry_after_s = RESOURCES[resource]
        scopes = (
            ("account", holder.id, allowed.account),
            ("clinic", holder.clinic_id, allowed.clinic),
            ("service", "", allowed.service),
        )
        keys = [(resource, f"{scope} {key}") for scope, key, _ in scopes]
        with self._lock:
            for (scope, _, most), counted in zip(scopes, keys, strict=True):
                if self._held[counted] >= most:
                    kind = Unavailable if scope == "service" else LimitReached
                    raise kind(
                        say("limit.reached", most=most, what=resource, scope=scope, advice=advice),
                        resource=resource,
                        scope=scope,
                        limit=most,
                        retry_after_s=retry_after_s,
                    )
            self._held.update(keys)
        return Hold(self, keys)

    def held(self, resource: Resource, scope: Literal["account", "clinic", "service"], key: str = "") -> int:
        """Return how many somebody holds.

        Parameters
        ----------
        key : str
            Of the account or clinic.
        """
        return self._held[(resource, f"{scope} {key}")]

    def _give_back(self, keys: list[tuple[Resource, str]]) -> None:
        with self._lock:
            self._held.subtract(keys)
            for key in keys:
                if self._held[key] <= 0:
                    del self._held[key]


class Hold:
    """One thing that somebody holds; releasing twice is releasing once."""

    def __init__(self, limits: Limits, keys: list[tuple[Resource, str]]) -> None:
        self._limits = limits
        self._keys = keys

    def release(self) -> None:
        """Give it back."""
        keys, self._keys = self._keys, []
        if keys:
            self._limits._give_back(keys)

    def __enter__(self) -> "Hold":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()
