"""What the writer asks of the interpreter, counted: calls, memory, statements; no times.

The figures are what was counted when they were written; a tenth more fails. Such a change takes the interpreter
away from the live frames of every session: mend it, or say in the commit why it is worth that.
"""

import sys
import tracemalloc
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, event, select

from app.database.engine import create_from_url
from app.live.session.ledger import NOT_STORED_AFTER_S
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.recordings.models import MotionSession, SignalChunk
from app.recordings.signals.buffers import Batch
from app.recordings.signals.group_commit import LONGEST_CHUNK_S, SESSIONS_A_SECOND, GroupCommitWriter
from app.recordings.signals.rows import write_batches
from app.recordings.signals.store import Standing, read_packets
from estimators.pipelines import FrameLayout, Frames

APPEND_CALLS = 471
"""Of 20 packets and their frames, taken."""
PACK_CALLS = 121
"""Of one session second, packed."""
PACK_PEAK_BYTES = 367_000
STATEMENTS = 3
"""Of a commit, however many sessions: packets, frames, and the count of packets."""

LAYOUT = FrameLayout(
    segments=tuple(f"segment_{n}" for n in range(17)),
    points=tuple(f"point_{n}" for n in range(12)),
    angles=tuple(f"angle_{n}" for n in range(18)),
    scalars=tuple(f"scalar_{n}_m" for n in range(13)),
)


def counts_packet(number: int) -> RawPacket:
    rng = np.random.default_rng(number)
    return RawPacket(
        sequence=number,
        device_time_us=number * 50_000,
        tick_interval_us=10_000,
        sensor_count=17,
        tick_count=5,
        channel_mask=7,
        encoding=1,
        flags=0,
        payload=rng.normal(0.0, 30.0, (5, 153)).astype("<i2").tobytes(),
        arrival_ns=1_700_000_000_000_000_000 + number * 50_000_000 + number % 7 * 1000,
    )


def live_frames(number: int) -> Frames:
    rng = np.random.default_rng(number)
    return Frames(
        layout=LAYOUT,
        first_tick=5 * number,
        time_step_s=0.01,
        q_room_segment=0.5 + rng.normal(0.0, 1e-4, (5, 17, 4)),
        point_room_m=rng.normal(0.0, 1e-3, (5, 12, 3)),
        angle_rad=rng.normal(0.0, 1e-3, (5, 18)),
        angle_sigma_rad=np.full((5, 18), 0.02),
        scalar=rng.normal(0.0, 1e-3, (5, 13)),
        segment_flags=np.zeros((5, 17), np.uint8),
        angle_flags=np.zeros((5, 18), np.uint8),
    )


def calls_of(work: Callable[[], object]) -> int:
    """Calls of Python and compiled functions from Python's code."""
    found = 0

    def note(_frame: Any, kind: str, _argument: Any) -> None:
        nonlocal found
        found += kind in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(before)
    return found


def session_second() -> Batch:
    packets = [counts_packet(n) for n in range(20)]
    return Batch(packets, [("result", live_frames(n)) for n in range(20)], [], [], 0)


def test_packing_a_session_second_calls_little() -> None:
    session_second().encode(0)
    batch = session_second()
    calls = calls_of(lambda: batch.encode(0))
    assert [len(batch.raw), len(batch.frames)] == [1, 1]
    assert calls < 1.1 * PACK_CALLS, calls


def test_packing_a_session_second_takes_little_memory() -> None:
    session_second().encode(0)
    batch = session_second()
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        batch.encode(0)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak - before < 1.1 * PACK_PEAK_BYTES, peak - before


def test_taking_a_session_second_calls_little(engine: Engine, new_session: Callable[..., str]) -> None:
    session_id = new_session()
    writer = GroupCommitWriter(engine)
    writer.open_session(session_id)
    packets, frames = [counts_packet(n) for n in range(40)], [live_frames(n) for n in range(40)]

    def take(numbers: range) -> None:
        for number in numbers:
            writer.append_packet(session_id, packets[number])
            writer.append_frames(session_id, "result", frames[number])

    take(range(20))
    calls = calls_of(lambda: take(range(20, 40)))
    assert calls < 1.1 * APPEND_CALLS, calls


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.postgres)])
def engine(request: pytest.FixtureRequest, settings: Any) -> Iterator[Engine]:
    from app.database import migrate

    url = settings.database_url
    if request.param == "postgresql":
        url = request.getfixturevalue("postgresql_database")()
    migrate.upgrade(url)
    engine = create_from_url(url)
    yield engine
    engine.dispose()


def statements_of(engine: Engine, work: Callable[[], object]) -> int:
    found = 0

    def note(_connection: Any, _cursor: Any, statement: str, *_: Any) -> None:
        nonlocal found
        found += statement.startswith(("INSERT", "UPDATE", "SELECT", "DELETE"))

    event.listen(engine, "before_cursor_execute", note)
    try:
        work()
    finally:
        event.remove(engine, "before_cursor_execute", note)
    return found


def test_a_commit_of_many_sessions_takes_as_many_statements_as_of_one(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    def commit(sessions: int) -> int:
        batches = [(new_session(), session_second()) for _ in range(sessions)]
        for _, batch in batches:
            batch.encode(0)

        def work() -> None:
            with engine.begin() as connection:
                write_batches(connection, batches)

        return statements_of(engine, work)

    assert commit(1) == STATEMENTS
    assert commit(7) == STATEMENTS
    with engine.connect() as connection:
        assert connection.scalars(select(MotionSession.packets_stored)).all() == [20] * 8


def test_a_commit_whose_answer_was_lost_is_repeated_without_harm(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    lost, other = new_session(), new_session()
    writer = GroupCommitWriter(engine)
    for session_id in (lost, other):
        writer.open_session(session_id)
        for number in range(20):
            writer.append_packet(session_id, counts_packet(number))
            writer.append_frames(session_id, "result", live_frames(number))
    batches = writer._take_due(everything=True)
    for session, batch in batches:
        batch.encode(0)
        if session.session_id == lost:
            # Committed, but the writer was never told.
            with engine.begin() as connection:
                write_batches(connection, [(lost, batch)])
    writer._commit(batches)
    for session_id in (lost, other):
        assert writer.stored_ranges(session_id) == SequenceRanges([(0, 20)])
        assert [p.sequence for p in read_packets(engine, session_id)] == list(range(20))
    with engine.connect() as connection:
        assert connection.scalars(select(MotionSession.packets_stored)).all() == [20, 20]
        assert len(connection.scalars(select(SignalChunk.sequence)).all()) == 4
    assert writer.metrics.sessions_failed == 0
    assert writer.metrics.commit_failures == 0


def test_another_writer_of_one_session_harms_only_that_one(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    shared, other = new_session(), new_session()
    foreign = Batch([counts_packet(n) for n in range(90, 95)], [], [], [], 0)
    writer = GroupCommitWriter(engine)
    for session_id in (shared, other):
        writer.open_session(session_id)
        for number in range(5):
            writer.append_packet(session_id, counts_packet(number))
    foreign.encode(0)
    with engine.begin() as connection:
        write_batches(connection, [(shared, foreign)])
    writer._commit(writer._take_due(everything=True))
    assert writer.metrics.sessions_failed == 1
    assert writer.stored_ranges(other) == SequenceRanges([(0, 5)])
    assert [p.sequence for p in read_packets(engine, shared)] == list(range(90, 95))


def test_sessions_that_begin_together_are_not_due_together(
    engine: Engine, new_session: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = 1000.0
    monkeypatch.setattr("time.monotonic", lambda: now_s)
    writer = GroupCommitWriter(engine)
    sessions = [new_session() for _ in range(20)]
    for session_id in sessions:
        writer.open_session(session_id)
        writer.append_packet(session_id, counts_packet(0))
    due = []
    for turn in range(11):
        now_s = 1000.0 + 0.1 * turn
        due.append(len(writer._take_due(everything=False)))
    assert sum(due) == 20
    assert max(due) <= 4, due


@pytest.mark.parametrize(
    ("sessions", "longest_s"), [(50, 1.0), (250, 250 / SESSIONS_A_SECOND), (500, LONGEST_CHUNK_S)]
)
def test_chunks_of_many_sessions_are_longer_but_not_too_long(
    engine: Engine, monkeypatch: pytest.MonkeyPatch, sessions: int, longest_s: float
) -> None:
    now_s = 1000.0
    monkeypatch.setattr("time.monotonic", lambda: now_s)
    writer = GroupCommitWriter(engine)
    nothing = Standing(SequenceRanges(), 0, {})
    for number in range(sessions):
        writer.open_session(str(number), standing=nothing)
        writer.append_packet(str(number), counts_packet(0))
    # The first chunks are shorter, so that not all end together.
    writer._take_due(everything=True)
    for number in range(sessions):
        writer.append_packet(str(number), counts_packet(1))
    now_s = 1000.0 + 0.99 * longest_s
    assert not writer._take_due(everything=False)
    now_s = 1000.0 + 1.01 * longest_s
    assert len(writer._take_due(everything=False)) == sessions


def test_a_chunk_of_many_sessions_is_stored_before_anybody_is_told_that_none_is() -> None:
    assert LONGEST_CHUNK_S + 0.9 < NOT_STORED_AFTER_S


def test_where_too_much_waits_the_largest_are_stored_early_and_not_all_at_once(engine: Engine) -> None:
    writer = GroupCommitWriter(engine, commit_bytes=200_000, chunk_s=60.0)
    nothing = Standing(SequenceRanges(), 0, {})
    for number in range(40):
        writer.open_session(str(number), standing=nothing)
        for sequence in range(number // 4 + 1):
            writer.append_packet(str(number), counts_packet(sequence))
    total = writer.metrics.queued_bytes
    assert total > 200_000
    taken = writer._take_due(everything=False)
    left = [one.size for one in writer._sessions.values() if not one.is_empty]
    assert 0 < len(taken) < 40
    assert 100_000 - max(left) < sum(left) <= 100_000
    assert min(batch.size for _, batch in taken) >= max(left)
    assert not writer._take_due(everything=False), "what is left is not too much"
