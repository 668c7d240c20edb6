"""What a partition says is stored is stored; and it ends, whatever is away."""

import asyncio
from typing import Any
from unittest.mock import AsyncMock, MagicMock, Mock

import pytest
from sqlalchemy.exc import OperationalError

from app.scaled.worker import partition as module
from app.scaled.worker.partition import Partition

POSITION = 5


@pytest.fixture
def save(monkeypatch: pytest.MonkeyPatch) -> Mock:
    """Stands for the transaction that stores the position."""
    made = Mock()
    monkeypatch.setattr(module, "save", made)
    return made


@pytest.fixture
def partition() -> Partition:
    """One that holds no session and has read a few messages."""
    broker, ask = MagicMock(), AsyncMock()
    broker.streams.purge_stream = AsyncMock()
    made = Partition(3, broker, MagicMock(), MagicMock(), MagicMock(), "own", Mock(), ask)
    parts: Any = made
    parts.sessions, parts.connections = MagicMock(sessions=[], closed=AsyncMock()), MagicMock()
    parts._entries = MagicMock(is_behind=False, taken=lambda position: position)
    parts._publisher, parts._writer, parts._fenced = MagicMock(), MagicMock(), MagicMock()
    parts.position, parts._stored = POSITION, 0
    return made


def test_packets_that_a_session_could_not_take_in_the_last_turn_are_not_said_to_be_stored(
    partition: Any, save: Mock
) -> None:
    def hold() -> None:
        partition._entries.is_behind = True

    partition.sessions.pooled.turn = hold
    asyncio.run(partition._checkpoint())
    save.assert_not_called()
    partition._entries.is_behind, partition.sessions.pooled.turn = False, Mock()
    asyncio.run(partition._checkpoint())
    assert save.call_args.args[2] == POSITION


def test_a_partition_ends_also_while_the_database_is_away(partition: Any, save: Mock) -> None:
    save.side_effect = OperationalError("UPDATE", {}, Exception())
    asyncio.run(partition.give_back())
    partition._publisher.close.assert_called_once()
    partition._writer.close.assert_called_once()


def test_a_late_write_of_a_holding_that_has_ended_says_nothing_of_the_next(partition: Any) -> None:
    async def story() -> None:
        partition._fenced_off()
        partition._end()
        partition._fenced_off()

    asyncio.run(story())
    partition._refused.assert_called_once()
