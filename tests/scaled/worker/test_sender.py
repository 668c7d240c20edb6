"""What partitions have for an edge goes in one message a turn, in order, in pieces that the broker takes."""

import asyncio
from types import SimpleNamespace
from typing import Any

import nats

from app.scaled.wire import Published, Report, decode_to_edge
from app.scaled.worker.sender import MESSAGE_BYTES, EdgeSender


class Client:
    """Takes what is published; what comes for one edge is refused."""

    def __init__(self, refused: str = "") -> None:
        self.sent: list[tuple[str, bytes]] = []
        self._refused = refused

    async def publish(self, subject: str, data: bytes) -> None:
        if self._refused and subject.endswith(self._refused):
            raise nats.errors.OutboundBufferLimitError
        self.sent.append((subject, data))


async def posted(client: Client, *turns: list[tuple[Any, ...]]) -> None:
    broker: Any = SimpleNamespace(client=client)
    post = EdgeSender(broker)
    post.start()
    for turn in turns:
        for given in turn:
            post.put(*given)
        for _ in range(3):
            await asyncio.sleep(0)
    post.stop()


def test_a_turn_is_one_message_an_edge_whatever_the_partitions() -> None:
    client, block = Client(), Published("session/a/blocks", b"block")
    report = Report("connection", "live")
    turn: list[tuple[Any, ...]] = [
        ("one", 0, 7, block),
        ("one", 3, 2, report),
        ("other", 0, 7, block),
        ("one", 0, 7, report),
    ]
    asyncio.run(posted(client, turn, [("one", 3, 2, block)]))
    assert [subject for subject, _ in client.sent] == [
        "telemotion.to.one",
        "telemotion.to.other",
        "telemotion.to.one",
    ]
    first, _, second = (decode_to_edge(data) for _, data in client.sent)
    assert [(part.partition, part.fencing, part.items) for part in first] == [
        (0, 7, [block, report]),
        (3, 2, [report]),
    ]
    assert [(part.partition, part.items) for part in second] == [(3, [block])]


def test_much_goes_in_pieces_in_order() -> None:
    client, count, size = Client(), 9, MESSAGE_BYTES // 4
    blocks = [Published(f"session/{number}/blocks", bytes(size)) for number in range(count)]
    asyncio.run(posted(client, [("one", number % 2, 1, block) for number, block in enumerate(blocks)]))
    # The server takes no message above a million bytes.
    assert max(len(data) for _, data in client.sent) < 1_000_000
    assert len(client.sent) == 3
    for partition in (0, 1):
        topics = [
            item.topic
            for _, data in client.sent
            for part in decode_to_edge(data)
            if part.partition == partition
            for item in part.items
            if isinstance(item, Published)
        ]
        assert topics == [block.topic for block in blocks[partition::2]]


def test_what_cannot_be_sent_to_one_edge_keeps_nothing_from_others() -> None:
    client, report = Client(refused="one"), Report("connection", "live")
    asyncio.run(posted(client, [("one", 0, 1, report), ("other", 0, 1, report)], [("other", 0, 1, report)]))
    assert [subject for subject, _ in client.sent] == ["telemotion.to.other"] * 2
