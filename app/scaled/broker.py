"""The connection to NATS: streams, one a partition, and the bucket of leases."""

import asyncio
import contextlib
import logging
import re
import ssl
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

import nats
from nats.aio.client import Client
from nats.js import JetStreamContext
from nats.js.api import DiscardPolicy, KeyValueConfig, RetentionPolicy, StorageType, StreamConfig
from nats.js.errors import BadRequestError
from nats.js.kv import KeyValue
from nats.protocol.parser import PERMISSIONS_ERR

from app.errors import InvalidInput
from app.scaled.credentials import read_credentials
from app.scaled.wire import Seal, subject
from app.settings import Settings
from estimators.sentences import say

logger = logging.getLogger(__name__)

BUCKET: Final = "telemotion"
DUPLICATES_S: Final = 120.0
"""So long a batch that an edge sends again is known to be the same."""
START_S: Final = 15.0
"""A process that cannot connect by then does not start, and says why."""
_REFUSAL: Final = re.compile("authorization|authentication|permissions", re.IGNORECASE)
"""In what a server says when it does not let somebody in, or do something."""


class _Client(Client):
    """The client, with a file of credentials; an error of the server ends a connection, never the client.

    It would give up when credentials expire or are refused later on: the file has newer ones by then, or soon.
    """

    def __init__(self, credentials: Path | None) -> None:
        super().__init__()
        self._file = credentials

    async def _connect_to_server(self, s: Any) -> None:
        if self._transport is not None:
            # An attempt that failed leaves its connection open.
            self._transport.close()  # type: ignore[no-untyped-call]
        await super()._connect_to_server(s)

    def _connect_command(self) -> bytes:
        if self._file is not None:
            try:
                found = read_credentials(self._file)
            except InvalidInput as error:
                # Of another kind the client would not try again.
                raise nats.errors.Error(str(error.message)) from error
            self._signature_cb = found.sign
            if found.token:
                self._user_jwt_cb = lambda: bytearray(found.token.encode())
            else:
                self._user_jwt_cb, self._public_nkey = None, found.public
        command: bytes = super()._connect_command()
        return command

    async def _process_err(self, err_msg: str) -> None:
        if PERMISSIONS_ERR in err_msg:
            await super()._process_err(err_msg)
        else:
            await self._process_op_err(nats.errors.Error(f"nats: {err_msg}"))


class Broker:
    """Connected to NATS, with the streams there."""

    def __init__(self, client: Client, settings: Settings) -> None:
        self.client = client
        self.partitions = settings.partitions
        self.seal = Seal(settings.key_for("edge-to-worker"))
        self.streams: JetStreamContext = client.jetstream()
        self._settings = settings
        self.leases: KeyValue
        self._on_back: list[Callable[[], None]] = []

    async def prepare(self) -> None:
        """Make streams and bucket where they are not there yet."""
        for partition in range(self.partitions):
            config = StreamConfig(
                name=stream_name(partition),
                subjects=[subject("in", partition)],
                retention=RetentionPolicy.LIMITS,
                storage=StorageType.FILE,
                # What does not fit is not acknowledged, and gateways hold it: nothing is dropped for it.
                discard=DiscardPolicy.NEW,
                max_bytes=self._settings.stream_bytes,
                num_replicas=self._settings.stream_replicas,
                duplicate_window=DUPLICATES_S,
            )
            try:
                await self.streams.add_stream(config)
            except BadRequestError as error:
                # It is there with other settings: they are brought to these.
                if error.err_code != _IN_USE:
                    raise
                await self.streams.update_stream(config)
        # What is not answered within half the length of a lease is tried again, not waited for.
        quick = self.client.jetstream(timeout=max(0.5, self._settings.lease_seconds / 2.0))
        self.leases = await quick.create_key_value(
            KeyValueConfig(bucket=BUCKET, history=1, replicas=self._settings.stream_replicas)
        )

    def on_back(self, call: Callable[[], None]) -> Callable[[], None]:
        """Have a function called whenever the connection is there again; returns what ends that.

        A server that was started again has lost what lives in its memory: consumers, subscriptions of others, answers.
        """
        self._on_back.append(call)
        return lambda: self._on_back.remove(call)

    async def back(self) -> None:
        """Note that the connection is there again."""
        logger.warning("NATS is there again")
        for call in list(self._on_back):
            call()

    def trouble(self) -> str | None:
        """Return in words why the broker cannot be used; None while it can."""
        return None if self.client.is_connected else "The connection to NATS is broken; it is tried again."

    async def close(self) -> None:
        """Send what waits, then end the connection."""
        # Away already, it has nothing to be sent.
        with contextlib.suppress(RuntimeError, OSError, nats.errors.Error):
            await self.client.close()


_IN_USE: Final = 10058
"""JetStream's number for a stream that exists with another configuration."""


def stream_name(partition: int) -> str:
    """Return the name of a partition's stream."""
    return f"telemotion-in-{partition}"


def user_of(settings: Settings) -> str:
    """Return the name by which a process shows NATS who it is, as its address has it; `edge` where it has none."""
    return urlsplit(settings.nats_url.get_secret_value().split(",")[0]).username or "edge"


def inbox_of(user: str) -> str:
    """Return below which subject answers come to an edge: no other edge may listen there."""
    return f"_INBOX.{user}"


async def connect(settings: Settings, name: str, *, is_edge: bool = False) -> Broker:
    """Return a broker that is connected; afterwards it reconnects for ever.

    Parameters
    ----------
    name : str
        Of this process, as NATS lists it.
    is_edge : bool
        It makes no streams, which an edge may not; a worker has made them, or will.

    Raises
    ------
    InvalidInput
        No server can be reached, or none is trusted or lets us in, or the file of credentials is none.
    """
    reason = refusal = ""

    async def broken(error: Exception) -> None:
        nonlocal reason, refusal
        reason = str(error) or type(error).__name__
        if _REFUSAL.search(reason):
            # The connection that ends with it may be reset later.
            refusal = reason
        logger.warning("NATS: %s", reason)

    if settings.nats_credentials is not None:
        # A file that is none is not tried for long.
        read_credentials(settings.nats_credentials)
    options: dict[str, Any] = {}
    if settings.nats_ca is not None:
        options["tls"] = ssl.create_default_context(cafile=str(settings.nats_ca))
    if is_edge:
        options["inbox_prefix"] = inbox_of(user_of(settings))
    client = _Client(settings.nats_credentials)
    found: asyncio.Future[Broker] = asyncio.get_running_loop().create_future()

    async def back() -> None:
        if found.done():
            await found.result().back()

    try:
        # The client would try for ever.
        async with asyncio.timeout(START_S):
            await client.connect(
                settings.nats_url.get_secret_value().split(","),
                name=name,
                max_reconnect_attempts=-1,
                reconnect_time_wait=0.2,  # type: ignore[arg-type]
                connect_timeout=3,
                ping_interval=5,
                pending_size=32 << 20,
                error_cb=broken,
                reconnected_cb=back,
                **options,
            )
        broker = Broker(client, settings)
        if not is_edge:
            await broker.prepare()
    except (OSError, nats.errors.Error) as error:
        await client.close()
        if refusal:
            raise InvalidInput(say("scaled.no_broker_right", reason=refusal)) from error
        reason = reason or str(error) or type(error).__name__
        raise InvalidInput(say("scaled.no_broker", reason=reason)) from error
    found.set_result(broker)
    return broker
