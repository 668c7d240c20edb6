"""Messages between edges and workers: subjects, entries of the stream, and messages for views.

Everything is MessagePack of typed records; a record of an unknown kind is refused. Subjects begin with `telemotion`:
`in.P` is the stream of partition P, `ask.P` are requests to whoever holds it, `here.P` says what an edge wants of it,
`taken.P` that somebody has taken it, `to.USER.EDGE` is all that an edge receives, `alive.WORKER` is answered by a
worker.

An edge may publish to the first three and hear the fourth and its own (`app.scaled.mqtt.configuration`). What it
publishes is sealed with the service's secret (`Seal`): who has no more than an edge's password for NATS says nothing
that a worker takes.
"""

import hmac
from dataclasses import fields
from hashlib import blake2b
from typing import Any, Final

import msgspec
import numpy as np

from app.errors import TelemotionError, Unavailable
from app.live.blocks import PublishedBlock, PublishedFrames
from app.live.calibration.messages import CalibrationMessage
from app.live.guidance.messages import GuidanceMessage
from app.live.messages import EventMessage, HealthMessage, LayoutMessage, StateMessage
from app.schemas import Schema
from estimators.pipelines import FrameLayout, Frames
from estimators.sentences import CATALOGUE, for_json

ROOT: Final = "telemotion"


def partition_of(session_id: str, partitions: int) -> int:
    """Return the partition of a session, the same on every machine.

    Parameters
    ----------
    partitions : int
        How many there are.
    """
    return int.from_bytes(blake2b(session_id.encode(), digest_size=8).digest(), "big") % partitions


def subject(name: str, of: int | str) -> str:
    """Return a subject of a partition, an edge or a worker: `in`, `ask`, `here`, `taken`, `done`, `to` or `alive`."""
    return f"{ROOT}.{name}.{of}"


class NotSealed(ValueError):
    """A message is not from an edge or worker with this service's secret, or was not for this subject."""


class Seal:
    """Marks what edges send workers, and knows the mark.

    Parameters
    ----------
    key : bytes
        The same in all edges and workers, from the service's secret.
    """

    SIZE: Final = 16

    def __init__(self, key: bytes) -> None:
        self._key = key

    def close(self, name: str, data: bytes) -> bytes:
        """Return a message with its mark before it.

        Parameters
        ----------
        name : str
            Its subject.
        """
        return self._mark(name, data) + data

    def open(self, name: str, sealed: bytes) -> bytes:
        """Return a message without its mark; see `close`.

        Raises
        ------
        NotSealed
            It has none, or another subject's.
        """
        mark, data = sealed[: self.SIZE], sealed[self.SIZE :]
        if not hmac.compare_digest(mark, self._mark(name, data)):
            raise NotSealed(name)
        return data

    def _mark(self, name: str, data: bytes) -> bytes:
        made = blake2b(name.encode() + b"\0", digest_size=self.SIZE, key=self._key)
        made.update(data)
        return made.digest()


class PacketEntry(msgspec.Struct, array_like=True, tag=0):
    """A packet as it came."""

    session_id: str
    arrival_ns: int
    """Since the epoch, by the clock of the edge."""
    data: bytes


class HelloEntry(msgspec.Struct, array_like=True, tag=1):
    """A gateway has connected; its packets follow."""

    session_id: str
    connection: str
    edge: str
    declaration: dict[str, Any]


class GivenUpEntry(msgspec.Struct, array_like=True, tag=2):
    """Packets that were asked for in vain."""

    session_id: str
    ranges: list[tuple[int, int]]


class GoodbyeEntry(msgspec.Struct, array_like=True, tag=3):
    """Nothing above a sequence will come."""

    session_id: str
    connection: str
    last_sequence: int


class LeftEntry(msgspec.Struct, array_like=True, tag=4):
    """A gateway's connection has ended."""

    session_id: str
    connection: str


class StoppedEntry(msgspec.Struct, array_like=True, tag=5):
    """Nothing more of a connection is taken, because its session is being closed: what was, lies before this."""

    session_id: str
    connection: str


Entry = PacketEntry | HelloEntry | GivenUpEntry | GoodbyeEntry | LeftEntry | StoppedEntry


class Published(msgspec.Struct, array_like=True, tag=0):
    """A message of a topic, for views."""

    topic: str
    data: bytes


class Report(msgspec.Struct, array_like=True, tag=1):
    """How a connection's session stands, for its gateway."""

    connection: str
    state: str
    is_finished: bool = False
    received: list[tuple[int, int]] | None = None
    """What of the session is here, for some time after a hello."""
    messages: list[str] = []
    """JSON for the gateway: orders, errors."""
    error: bytes | None = None
    """Why the connection must end."""


class ToEdge(msgspec.Struct, array_like=True):
    """What a worker sends an edge of a partition; what it has of several goes in one message."""

    partition: int
    fencing: int
    """Of the lease under which it was found: what an earlier holder says is left out."""
    items: list[Published | Report]


class Here(msgspec.Struct, array_like=True):
    """What an edge wants of a partition; it says so again and again, and what it does not say any more is over."""

    edge: str
    topics: list[str]
    connections: dict[str, str]
    """By session."""


class Look(msgspec.Struct, array_like=True, tag=0):
    """Asks what a view receives when it connects; answered by `list[Published]`."""

    edge: str
    session_id: str


class Request(msgspec.Struct, array_like=True, tag=1):
    """An HTTP request that the holder of a session answers."""

    method: str
    target: str
    headers: list[tuple[bytes, bytes]]
    body: bytes
    client: tuple[str, int]


class Answer(msgspec.Struct, array_like=True):
    """The answer to a `Request`."""

    status: int
    headers: list[tuple[bytes, bytes]]
    body: bytes


encode: Final = msgspec.msgpack.Encoder().encode
decode_entries: Final = msgspec.msgpack.Decoder(list[Entry]).decode
decode_to_edge: Final = msgspec.msgpack.Decoder(list[ToEdge]).decode
decode_here: Final = msgspec.msgpack.Decoder(Here).decode
decode_question: Final = msgspec.msgpack.Decoder(Look | Request).decode
decode_published: Final = msgspec.msgpack.Decoder(list[Published]).decode
decode_answer: Final = msgspec.msgpack.Decoder(Answer).decode

_SCHEMAS: Final[dict[str, type[Schema]]] = {
    "state": StateMessage,
    "health": HealthMessage,
    "event": EventMessage,
    "layout": LayoutMessage,
    "calibration": CalibrationMessage,
    "guidance": GuidanceMessage,
}


class ReceivedBlock(PublishedBlock):
    """A block in its frame of a WebSocket, as a worker made it."""

    def __init__(self, frame: bytes) -> None:
        self.frame = frame


def pack_message(topic: str, message: Any) -> Published:
    """Return a message of the bus for the way to an edge.

    Parameters
    ----------
    topic : str
        `session/ID/NAME`.
    message : object
        Of a topic named in `app.live.bus`.
    """
    name = topic.rpartition("/")[2]
    if name == "blocks":
        return Published(topic, message.frame)
    if name == "frames":
        return Published(topic, _pack_frames(message))
    return Published(topic, message.model_dump_json().encode())


def unpack_message(one: Published) -> Any:
    """Return what `pack_message` was given."""
    name = one.topic.rpartition("/")[2]
    if name == "blocks":
        return ReceivedBlock(one.data)
    if name == "frames":
        return _unpack_frames(one.data)
    return _SCHEMAS[name].model_validate_json(one.data)


def _pack_frames(published: PublishedFrames) -> bytes:
    values: dict[str, Any] = {}
    for one in fields(Frames):
        value = getattr(published.frames, one.name)
        if isinstance(value, np.ndarray):
            value = [value.dtype.str, value.shape, value.tobytes()]
        elif isinstance(value, FrameLayout):
            value = [value.segments, value.points, value.angles, value.scalars]
        values[one.name] = value
    return encode([published.published_at_s, values])


def _unpack_frames(data: bytes) -> PublishedFrames:
    published_at_s, values = msgspec.msgpack.decode(data)
    values["layout"] = FrameLayout(*map(tuple, values["layout"]))
    for name, value in values.items():
        if isinstance(value, list):
            kind, shape, content = value
            values[name] = np.frombuffer(content, dtype=kind).reshape(shape)
    return PublishedFrames(Frames(**values), published_at_s)


def pack_error(error: TelemotionError) -> bytes:
    """Return a typed error for the way to another process, its sentence whole."""
    return msgspec.json.encode([error.code, for_json(error.message), error.details])


def unpack_error(data: bytes) -> TelemotionError:
    """Return an error of the type that `pack_error` was given; `Unavailable` for one that is not known here."""
    code, message, details = msgspec.json.decode(data)
    kind = next((one for one in _errors(TelemotionError) if one.code == code), Unavailable)
    return kind(CATALOGUE.restored(message), **details)


def _errors(kind: type[TelemotionError]) -> list[type[TelemotionError]]:
    return [kind, *(deeper for one in kind.__subclasses__() for deeper in _errors(one))]
