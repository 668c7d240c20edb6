"""All that is in the streams at once, for backup and restore; workers read in order (`app.scaled.worker.reader`)."""

import asyncio
import contextlib
from collections.abc import Callable, Iterable, Sequence
from typing import Final

from nats.js.errors import NotFoundError

from app.database.base import new_id
from app.errors import Conflict
from app.scaled.broker import Broker, connect, stream_name
from app.scaled.wire import NotSealed, subject
from app.settings import Settings
from estimators.sentences import say

ANSWER_S: Final = 10.0


def read_all(settings: Settings) -> list[list[tuple[int, bytes]]]:
    """Return the messages of each partition's stream in order, each with its number.

    Raises
    ------
    InvalidInput
        NATS cannot be reached.
    """

    async def read() -> list[list[tuple[int, bytes]]]:
        broker = await connect(settings, "telemotion backup")
        try:
            return [await _messages(broker, partition) for partition in range(broker.partitions)]
        finally:
            await broker.close()

    return asyncio.run(read())


async def _messages(broker: Broker, partition: int) -> list[tuple[int, bytes]]:
    name, found = stream_name(partition), []
    state = (await broker.streams.stream_info(name)).state
    for number in range(state.first_seq, state.last_seq + 1 if state.messages else 0):
        try:
            message = await broker.streams.get_msg(name, number)
        except NotFoundError:
            # A worker has stored it meanwhile.
            continue
        # The mark is of this service's secret: a backup may be restored under another. What no edge sent is left out.
        with contextlib.suppress(NotSealed):
            found.append((number, broker.seal.open(subject("in", partition), message.data or b"")))
    return found


def fill(
    settings: Settings, contents: Sequence[Iterable[bytes]], prepare: Callable[[Sequence[int]], None]
) -> None:
    """Put messages into empty streams.

    Parameters
    ----------
    contents : sequence of iterable of bytes
        By partition, in order.
    prepare : callable(positions)
        Called once, when all streams were found empty, with the highest number that each had given.

    Raises
    ------
    Conflict
        Something is in them.
    InvalidInput
        NATS cannot be reached.
    """

    async def write() -> None:
        broker = await connect(settings, "telemotion restore")
        try:
            states = [
                (await broker.streams.stream_info(stream_name(partition))).state
                for partition in range(broker.partitions)
            ]
            if any(state.messages for state in states):
                raise Conflict(say("scaled.streams_not_empty"))
            await asyncio.to_thread(prepare, [state.last_seq for state in states])
            for partition, messages in enumerate(contents):
                for data in messages:
                    headers = {"Nats-Msg-Id": new_id()}
                    name = subject("in", partition)
                    sealed = broker.seal.close(name, data)
                    await broker.streams.publish(name, sealed, timeout=ANSWER_S, headers=headers)
        finally:
            await broker.close()

    asyncio.run(write())
