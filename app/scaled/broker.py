"""The connection to NATS: streams, one a partition, and the bucket of leases."""

import asyncio
import contextlib
import logging
import ssl
from collections.abc import Callable
from typing import Any, Final

import nats
from nats.aio.client import Client
from nats.js import JetStreamContext
from nats.js.api import DiscardPolicy, KeyValueConfig, RetentionPolicy, StorageType, StreamConfig
from nats.js.errors import BadRequestError
from nats.js.kv import KeyValue

from app.errors import InvalidInput
from app.scaled.wire import subject
from app.sentences import say
from app.settings import Settings

logger = logging.getLogger(__name__)

BUCKET: Final = "telemotion"
DUPLICATES_S: Final = 120.0
"""So long a batch that an edge sends again is known to be the same."""
START_S: Final = 15.0
"""A process that cannot connect by then does not start, and says why."""


class Broker:
    """Connected to NATS, with the streams there.

    Parameters
    ----------
    client : Client
    settings : Settings
    """

    def __init__(self, client: Client, settings: Settings) -> None:
        self.client = client
        self.partitions = settings.partitions
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
        # What is not answered within half the length of a lease is tried anew, not waited for.
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


async def connect(settings: Settings, name: str) -> Broker:
    """Return a broker that is connected and prepared; afterwards it reconnects for ever.

    Parameters
    ----------
    settings : Settings
    name : str
        Of this process, as NATS lists it.

    Raises
    ------
    InvalidInput
        No server can be reached, or none is trusted or lets us in.
    """
    reason = ""

    async def broken(error: Exception) -> None:
        nonlocal reason
        reason = str(error) or type(error).__name__
        logger.warning("NATS: %s", type(error).__name__)

    options: dict[str, Any] = {}
    if settings.nats_credentials is not None:
        options["user_credentials"] = str(settings.nats_credentials)
    if settings.nats_ca is not None:
        options["tls"] = ssl.create_default_context(cafile=str(settings.nats_ca))
    found: asyncio.Future[Broker] = asyncio.get_running_loop().create_future()

    async def back() -> None:
        if found.done():
            await found.result().back()

    try:
        # The client would try for ever.
        async with asyncio.timeout(START_S):
            client = await nats.connect(
                settings.nats_url.get_secret_value().split(","),
                name=name,
                max_reconnect_attempts=-1,
                reconnect_time_wait=0.2,
                connect_timeout=3,
                ping_interval=5,
                pending_size=32 << 20,
                error_cb=broken,
                reconnected_cb=back,
                **options,
            )
    except (OSError, nats.errors.Error) as error:
        reason = reason or str(error) or type(error).__name__
        raise InvalidInput(say("scaled.no_broker", reason=reason)) from error
    broker = Broker(client, settings)
    await broker.prepare()
    found.set_result(broker)
    return broker
