"""Answers the NATS servers when somebody connects by MQTT: a ticket is a right to four topics and to nothing else."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Any, Final

from nats.aio.msg import Msg
from sqlalchemy import Engine

from app.accounts.credentials import tickets
from app.database.unit_of_work import read_only
from app.network.mqtt import DOWN, UP, connection_name, subject
from app.scaled.broker import Broker
from app.scaled.mqtt.configuration import GATEWAYS, issuer_of
from app.scaled.mqtt.issuer import Issuer, claims_of
from app.settings import Settings

logger = logging.getLogger(__name__)

SUBJECT: Final = "$SYS.REQ.USER.AUTH"
WORKERS: Final = "workers"
"""Of those that listen, one is asked."""
MOST_BYTES: Final = 256 << 10
"""Of a message; a longer one ends the connection."""
PATIENCE_S: Final = 2.0
"""The server waits little longer."""


class Callout:
    """Says who may connect by MQTT.

    Parameters
    ----------
    is_open : async callable(ticket) -> bool
        Whether a ticket could be used now; it is used with the hello.
    longest_s : float
        A connection is ended by the server after so long.
    """

    def __init__(
        self, broker: Broker, issuer: Issuer, is_open: Callable[[str], Awaitable[bool]], longest_s: float
    ) -> None:
        self._broker, self._issuer = broker, issuer
        self._is_open, self._longest_s = is_open, longest_s
        self._subscription: Any = None

    async def start(self) -> None:
        """Begin to answer."""
        self._subscription = await self._broker.client.subscribe(SUBJECT, queue=WORKERS, cb=self._asked)

    async def stop(self) -> None:
        """Leave it to other workers."""
        if self._subscription is not None:
            await self._subscription.unsubscribe()

    async def _asked(self, message: Msg) -> None:
        try:
            asked = claims_of(message.data)["nats"]
            user, server = str(asked["user_nkey"]), str(asked["server_id"]["id"])
            found = await self._right(asked, user)
            answer = {
                "sub": user,
                "aud": server,
                "nats": {"type": "authorization_response", "version": 2} | found,
            }
            await self._broker.client.publish(message.reply, self._issuer.sign(answer).encode())
        except Exception:
            # Unanswered the server refuses whoever it is.
            logger.exception("a request to connect by MQTT was not answered")

    async def _right(self, asked: dict[str, Any], user: str) -> dict[str, str]:
        """Return a signed right, or why there is none."""
        who, shown = asked["client_info"], asked["connect_opts"]
        ticket = str(shown.get("pass", ""))
        name = connection_name(ticket)
        # The same identifier would end somebody else's connection: only who has the ticket knows this one.
        if who.get("type") != "mqtt" or who.get("mqtt_id") != name:
            return {"error": "not a gateway with a ticket"}
        try:
            async with asyncio.timeout(PATIENCE_S):
                if not await self._is_open(ticket):
                    return {"error": "the ticket is not valid"}
        except TimeoutError:
            return {"error": "the database does not answer"}
        right = {
            "sub": user,
            "aud": GATEWAYS,
            "name": name,
            "exp": int(time.time() + self._longest_s),
            "nats": {
                "type": "user",
                "version": 2,
                "allowed_connection_types": ["MQTT"],
                "pub": {"allow": [subject(name, kind) for kind in UP], "deny": ["$MQTT.msgs.>"]},
                "sub": {"allow": [subject(name, DOWN)]},
                "subs": 2,
                "data": -1,
                "payload": MOST_BYTES,
            },
        }
        return {"jwt": self._issuer.sign(right)}


def callout_of(settings: Settings, engine: Engine, broker: Broker) -> Callout:
    """Return the callout of a worker; it answers nobody before its start.

    An edge does not answer: whoever does may sign a right to anything.

    Parameters
    ----------
    engine : Engine
        Where tickets are.
    """

    def look(ticket: str) -> bool:
        with read_only(engine) as session:
            return tickets.is_open(session, ticket, "ingest")

    async def is_open(ticket: str) -> bool:
        return await asyncio.to_thread(look, ticket)

    return Callout(broker, issuer_of(settings), is_open, settings.session_limit_hours * 3600.0)
