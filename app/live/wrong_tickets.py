"""How many wrong tickets an address may show: who has none is not to cost the database much.

A socket is opened without a sign-in; only its first message says whose it is. Whoever shows tickets that are none is
refused without the database, once there were many. A right one gives its attempt back.
"""

import contextlib
from collections.abc import Iterator
from typing import Final

from app.accounts.credentials.rate_limit import LeakyCounter, Limit, network_of
from app.errors import SignInRequired, TooManyAttempts
from app.ingest.contract import Intake, PacketSink
from app.network.declaration import Declaration
from app.network.messages import HelloMessage
from estimators.sentences import say

WRONG: Final = Limit(capacity=60, recovery_s=1.0)
"""Of an address, which a whole clinic may share."""


class WrongTickets:
    """Counts them by address, in this process."""

    def __init__(self, limit: Limit = WRONG) -> None:
        self._counter = LeakyCounter(limit)

    @contextlib.contextmanager
    def counted(self, address: str) -> Iterator[None]:
        """Look at a ticket in this context; it stays counted where it was refused.

        Parameters
        ----------
        address : str
            Of the client.

        Raises
        ------
        TooManyAttempts
            There were too many; with the time after which one is looked at again.
        """
        key = network_of(address)
        wait_s = self._counter.take(key)
        if wait_s:
            seconds = max(1, round(wait_s))
            raise TooManyAttempts(say("hello.too_many", seconds=seconds), retry_after_s=seconds)
        try:
            yield
        except SignInRequired:
            raise
        except BaseException:
            self._counter.give_back(key)
            raise
        self._counter.give_back(key)


class CountedSink:
    """Opens sessions for one address; implements `PacketSink`."""

    def __init__(self, sink: PacketSink, wrong: WrongTickets, address: str) -> None:
        self._sink, self._wrong, self._address = sink, wrong, address

    @property
    def check_every_s(self) -> float:
        """How often the right of a connection is checked again."""
        return self._sink.check_every_s

    async def open(self, hello: HelloMessage, declaration: Declaration) -> Intake:
        """Open the session of the hello's ticket. Raises typed errors."""
        with self._wrong.counted(self._address):
            return await self._sink.open(hello, declaration)
