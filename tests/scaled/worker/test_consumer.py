"""A full worker refuses new sessions, but never one whose packets were acknowledged."""

import asyncio
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest

from app.errors import Unavailable
from app.network.declaration import Declaration
from app.scaled.wire import HelloEntry, PacketEntry
from app.scaled.worker import consumer as module
from app.scaled.worker.consumer import StreamConsumer
from tests.patience import PATIENCE_S

HELLO = HelloEntry("session", "connection", "edge", {})
PACKET = PacketEntry("session", 0, b"packet")


class Full:
    """Sessions of a worker that has no room."""

    def __init__(self) -> None:
        self.session: Any = None
        self.pooled = MagicMock()

    def find(self, session_id: str) -> Any:
        return self.session

    async def join(self, stored: Any, declaration: Any, *, is_admitted: bool) -> Any:
        if not is_admitted:
            raise Unavailable("full", reason="full")
        self.session = MagicMock(id="session")
        return self.session


@pytest.mark.parametrize(
    ("taken", "is_open", "packets"), [([HELLO], False, 0), ([HELLO, PACKET], True, 1), ([PACKET], True, 1)]
)
def test_only_a_session_without_packets_waits_until_there_is_room(
    monkeypatch: pytest.MonkeyPatch, taken: list[Any], is_open: bool, packets: int
) -> None:
    monkeypatch.setattr(module.repository, "load", lambda *_: SimpleNamespace(hello={}, state="created"))
    monkeypatch.setattr(Declaration, "from_dict", lambda _: None)
    sessions, connections, publisher = Full(), MagicMock(), MagicMock()

    async def story() -> None:
        made: Any = sessions
        entries = StreamConsumer(made, connections, publisher, MagicMock(), MagicMock())
        for sequence, entry in enumerate(taken, 1):
            entries.take(sequence, entry)
        async with asyncio.timeout(PATIENCE_S):
            await asyncio.gather(*entries._openers)
        assert not entries.is_opening
        assert entries.taken(len(taken)) == len(taken)

    asyncio.run(story())
    assert (sessions.session is not None) == is_open
    assert publisher.report.called != is_open
    assert sessions.pooled.offer.call_count == packets
