"""How a gateway's conversation is named over MQTT: what gateways and edges must know alike.

A connection has a name, made of its ticket, and four topics below it. Messages are those of the WebSocket. JSON begins
with `{`, a binary packet does not; an empty message says nothing but that its sender is there.
"""

from hashlib import sha256
from typing import Final, Literal

Topic = Literal["hello", "up", "left", "down"]
UP: Final[tuple[Topic, ...]] = ("hello", "up", "left")
"""From a gateway: its hello; packets and goodbye; that it has gone, which is its will too."""
DOWN: Final[Topic] = "down"
"""To a gateway."""
ROOT: Final = "gateway"
LIVES_S: Final = 60.0
"""A gateway from which nothing came for so long is taken for gone; one without packets says that it is there."""
SILENCE_S: Final = 5.0
"""An edge acknowledges every second: a gateway that hears nothing for so long connects again."""
ANSWER_S: Final = 25.0
"""A hello is answered within so long, also while its session moves to another worker."""
WINDOW: Final = 256
"""Packets that may be under way without an acknowledgement: nothing else slows a sender down."""


def connection_name(ticket: str) -> str:
    """Return the name of the connection that a ticket opens: nobody else can guess it.

    Returns
    -------
    str
        The first 32 characters of the ticket's SHA-256 in hexadecimal; also the client identifier of MQTT.
    """
    return sha256(ticket.encode()).hexdigest()[:32]


def topic(name: str, kind: Topic) -> str:
    """Return a topic of a connection, as MQTT spells it."""
    return f"{ROOT}/{name}/{kind}"


def subject(name: str, kind: Topic) -> str:
    """Return the same as NATS spells it; `*` is every connection."""
    return f"{ROOT}.{name}.{kind}"
