"""A checkpoint is committed with the packets before it or after them, and harms nothing."""

import time
from collections.abc import Callable

import pytest
from sqlalchemy import Engine, delete, event
from sqlalchemy.exc import OperationalError

from app.database.unit_of_work import unit_of_work
from app.errors import Conflict
from app.live.repository import forget_ended, save_not_closed
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.recordings.models import MotionSession
from app.recordings.service import queue_closing
from app.recordings.signals.checkpoints import Checkpoint, load_checkpoint
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import stored_ranges
from tests.patience import PATIENCE_S

Make = Callable[..., RawPacket]


def standing(sequence: int) -> Callable[[], Checkpoint]:
    return lambda: Checkpoint(2, sequence, bytes([sequence]))


def test_the_newest_is_read_back_and_goes_when_the_session_is_closed(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    for number in range(6):
        writer.append_packet(session_id, packet(number))
        writer.add_checkpoint(session_id, standing(number + 1))
        if number % 2:
            writer.flush(session_id).result(PATIENCE_S)
            assert load_checkpoint(engine, session_id) == Checkpoint(2, number + 1, bytes([number + 1]))
    with unit_of_work(engine) as session:
        queue_closing(session, session_id)
    assert load_checkpoint(engine, session_id) is None


def test_it_waits_for_what_comes_next(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    writer.append_packet(session_id, packet(0))
    writer.flush(session_id).result(PATIENCE_S)
    commits = writer.metrics.commits
    writer.add_checkpoint(session_id, standing(1))
    assert not any(one.is_due(1e12, 0.0, everything=False) for one in writer._sessions.values())
    writer.append_packet(session_id, packet(1))
    writer.flush(session_id).result(PATIENCE_S)
    assert load_checkpoint(engine, session_id) == standing(1)()
    assert writer.metrics.commits == commits + 1


def test_a_commit_that_fails_stores_neither_and_both_are_stored_later(
    engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    is_failing = True

    def fail(connection, cursor, statement, parameters, context, many):  # type: ignore[no-untyped-def]
        if is_failing and "INTO live_checkpoint" in statement:
            raise OperationalError(statement, parameters, Exception("disk I/O error"))

    writer = GroupCommitWriter(engine, commit_interval_s=0.01)
    writer.open_session(session_id)
    writer.append_packet(session_id, packet(0))
    writer.add_checkpoint(session_id, standing(1))
    event.listen(engine, "before_cursor_execute", fail)
    try:
        writer.start()
        future = writer.flush(session_id)
        until_s = time.monotonic() + PATIENCE_S
        while writer.trouble() is None:
            assert time.monotonic() < until_s
            time.sleep(0.01)
        assert load_checkpoint(engine, session_id) is None
        assert stored_ranges(engine, session_id) == SequenceRanges()
        is_failing = False
        assert future.result(PATIENCE_S) == SequenceRanges([(0, 1)])
    finally:
        event.remove(engine, "before_cursor_execute", fail)
        writer.close()
    assert load_checkpoint(engine, session_id) == standing(1)()


def test_one_that_cannot_be_packed_costs_no_packet(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    def broken() -> Checkpoint:
        raise ValueError("unknown type")

    session_id = new_session()
    writer.open_session(session_id)
    writer.append_packet(session_id, packet(0))
    writer.add_checkpoint(session_id, broken)
    assert writer.flush(session_id).result(PATIENCE_S) == SequenceRanges([(0, 1)])
    assert load_checkpoint(engine, session_id) is None


def test_that_of_a_session_that_was_deleted_fails_alone(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    gone, stays = new_session(), new_session()
    for session_id in (gone, stays):
        writer.open_session(session_id)
        writer.append_packet(session_id, packet(0))
        writer.add_checkpoint(session_id, standing(1))
    with unit_of_work(engine) as session:
        session.execute(delete(MotionSession).where(MotionSession.id == gone))
    futures = [writer.flush(session_id) for session_id in (gone, stays)]
    with pytest.raises(Conflict, match="no longer exists"):
        futures[0].result(PATIENCE_S)
    futures[1].result(PATIENCE_S)
    assert load_checkpoint(engine, stays) == standing(1)()


@pytest.mark.parametrize("state", ["recording", "link_lost", "closing", "failed", "analysed"])
def test_those_of_sessions_that_do_not_go_on_are_deleted(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make, state: str
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    writer.append_packet(session_id, packet(0))
    writer.add_checkpoint(session_id, standing(1))
    writer.flush(session_id).result(PATIENCE_S)
    with unit_of_work(engine) as session:
        session.get_one(MotionSession, session_id).state = state
    forget_ended(engine)
    assert (load_checkpoint(engine, session_id) is None) == (state not in {"recording", "link_lost"})


def test_that_of_a_session_that_could_not_be_closed_is_deleted(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    writer.append_packet(session_id, packet(0))
    writer.add_checkpoint(session_id, standing(1))
    writer.flush(session_id).result(PATIENCE_S)
    save_not_closed(engine, session_id, "No room on the disk.")
    assert load_checkpoint(engine, session_id) is None
