"""Reading a partition's stream in order, from a position on, over reconnections and restarts of the server.

An ordered consumer: pushed, in memory, without acknowledgements. Each message carries its number in the consumer; when
one is missing, or the server is silent, the consumer is made again behind the last message that was read. A durable
consumer would deliver again what was not acknowledged behind what came later, which broke the order of sessions.
"""

import asyncio
import contextlib
import logging
import time
from collections import deque
from collections.abc import AsyncIterator
from typing import Final

import nats
from nats.aio.msg import Msg
from nats.js.api import AckPolicy, ConsumerConfig, DeliverPolicy
from nats.js.errors import Error as StreamError

from app.scaled.broker import Broker, stream_name

logger = logging.getLogger(__name__)

HEARTBEAT_S: Final = 0.5
SILENCE_S: Final = 1.6
ANSWER_S: Final = 5.0
"""A server that answers, and a process that has no time to hear it, are not to be taken for one that is away."""
TURN_S: Final = 0.02
"""So long messages that wait are given out before everything else has its turn."""
AGAIN_S: Final = 0.2


async def read(broker: Broker, partition: int, position: int) -> AsyncIterator[tuple[int, bytes, int]]:
    """Yield what lies behind a position, in order, for ever.

    Parameters
    ----------
    position : int
        Number of the last message that was taken before.

    Yields
    ------
    sequence : int
        In the stream.
    data : bytes
    waiting : int
        How many messages are in the stream behind it.
    """
    while True:
        try:
            async for sequence, data, waiting in _read_on(broker, partition, position):
                position = sequence
                yield sequence, data, waiting
        except (nats.errors.Error, StreamError, OSError, TimeoutError) as error:
            logger.warning(
                "partition %d is read again behind %d: %s", partition, position, type(error).__name__
            )
        await asyncio.sleep(AGAIN_S)


async def _read_on(broker: Broker, partition: int, position: int) -> AsyncIterator[tuple[int, bytes, int]]:
    """Yield until a message is missing or the server is silent."""
    client, inbox = broker.client, broker.client.new_inbox()
    messages: deque[Msg] = deque()
    came, name = asyncio.Event(), None

    # The client's own waiting for the next message makes two tasks for each; the server's flow control bounds these.
    async def hear(message: Msg) -> None:
        messages.append(message)
        came.set()

    subscription = await client.subscribe(inbox, cb=hear)
    waking: set[asyncio.Task[None]] = set()

    def wake() -> None:
        # A server that was started again has no such consumer any more: its silence is not waited for.
        waking.add(asyncio.create_task(client.publish(inbox), name="wake reader"))

    forget = broker.on_back(wake)
    try:
        config = ConsumerConfig(
            deliver_subject=inbox,
            deliver_policy=DeliverPolicy.BY_START_SEQUENCE,
            opt_start_seq=position + 1,
            ack_policy=AckPolicy.NONE,
            max_deliver=1,
            flow_control=True,
            idle_heartbeat=HEARTBEAT_S,
            inactive_threshold=5.0,
            num_replicas=1,
            mem_storage=True,
        )
        name, expected = await _add(broker, partition, config), 1
        turn_s = time.monotonic()
        while True:
            if not messages:
                await _more(broker, messages, came)
                turn_s = time.monotonic()
            elif time.monotonic() - turn_s > TURN_S:
                await asyncio.sleep(0)
                turn_s = time.monotonic()
            message = messages.popleft()
            if message.headers and message.headers.get("Status") == "100":
                wanted = message.reply or message.headers.get("Nats-Consumer-Stalled")
                if wanted:
                    # The server goes on once what came before was taken.
                    await client.publish(wanted)
                elif int(message.headers.get("Nats-Last-Consumer") or expected - 1) != expected - 1:
                    return
                continue
            if not message.reply:
                return
            numbers = message.metadata
            if numbers.sequence.consumer != expected:
                return
            expected += 1
            yield numbers.sequence.stream, message.data, numbers.num_pending or 0
    finally:
        forget()
        await _forget(broker, partition, name)
        await subscription.unsubscribe()


async def _add(broker: Broker, partition: int, config: ConsumerConfig) -> str:
    """Make a consumer and return its name."""
    async with asyncio.timeout(ANSWER_S) as patience:
        # A server that was started again does not answer what the one before was asked.
        forget = broker.on_back(lambda: patience.reschedule(asyncio.get_running_loop().time()))
        try:
            made = await broker.streams.add_consumer(stream_name(partition), config)
        finally:
            forget()
    return str(made.name)


async def _more(broker: Broker, messages: deque[Msg], came: asyncio.Event) -> None:
    """Wait until there are messages.

    Raises
    ------
    TimeoutError
        The server is silent.
    """
    came.clear()
    try:
        async with asyncio.timeout(SILENCE_S):
            await came.wait()
    except TimeoutError:
        # This process may have stood still: what the server sent meanwhile comes before its answer.
        with contextlib.suppress(nats.errors.Error):
            async with asyncio.timeout(SILENCE_S):
                await broker.client.flush()
        if not messages:
            raise


async def _forget(broker: Broker, partition: int, name: str | None) -> None:
    if name is None or not broker.client.is_connected:
        # It ends by itself a few seconds after nobody listens.
        return
    began_s = time.monotonic()
    try:
        async with asyncio.timeout(1.0):
            await broker.streams.delete_consumer(stream_name(partition), name)
    except (nats.errors.Error, StreamError, TimeoutError):
        logger.debug("consumer of partition %d not deleted in %.1f s", partition, time.monotonic() - began_s)
