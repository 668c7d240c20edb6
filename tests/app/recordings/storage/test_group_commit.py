"""The writer of signals: exactly once, durable before told, one failing session alone, bounded."""

import random
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import Engine, delete, event, func, select
from sqlalchemy.exc import OperationalError

from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.errors import Conflict, InvalidInput, Unavailable
from app.network.packet import decode_packet
from app.network.packet_log import packet_message
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.recordings.models import MotionSession, SessionEvent, SignalChunk
from app.recordings.signals.chunks import decode_packets, encode_packets, outermost_heads
from app.recordings.signals.codecs import DamagedChunkError
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import Standing, read_packets, read_packets_in_order, stored_ranges
from tests.patience import PATIENCE_S

Make = Callable[..., RawPacket]


@given(
    data=st.data(),
    ticks=st.lists(st.integers(1, 8), min_size=1, max_size=10),
    sensors=st.integers(1, 4),
    encoding=st.sampled_from([0, 1]),
)
@settings(max_examples=80, deadline=None)
def test_any_packets_survive_a_chunk(
    data: st.DataObject, ticks: list[int], sensors: int, encoding: int
) -> None:
    packets = [
        RawPacket(
            sequence=data.draw(st.integers(0, 2**33)) * len(ticks) + number,
            device_time_us=data.draw(st.integers(0, 2**64 - 1)),
            tick_interval_us=data.draw(st.integers(500, 1_000_000)),
            sensor_count=sensors,
            tick_count=count,
            channel_mask=3,
            encoding=encoding,
            flags=data.draw(st.integers(0, 3)),
            payload=data.draw(st.binary(min_size=1, max_size=1)) * (count * sensors * 6 * (4, 2)[encoding]),
            arrival_ns=data.draw(st.integers(0, 2**62)),
        )
        for number, count in enumerate(ticks)
    ]
    chunk = encode_packets(packets)
    assert decode_packets(chunk) == packets
    ordered = sorted(packets, key=lambda one: one.sequence)
    outermost = ordered if len(ordered) == 1 else [ordered[0], ordered[-1]]
    assert outermost_heads(chunk) == [replace(one, payload=b"") for one in outermost]


def test_a_packet_is_made_again_as_it_came(packet: Make) -> None:
    for counts in (True, False):
        original = packet(5, counts=counts)
        message = packet_message(original)
        again = RawPacket.from_packet(decode_packet(message), original.arrival_ns)
        assert again == original
        assert packet_message(again) == message


def test_packets_come_back_in_the_order_of_arrival(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    order = list(range(60))
    random.Random(3).shuffle(order)
    sent = [packet(n) for n in order]
    writer.open_session(session_id)
    for one in sent:
        assert writer.append_packet(session_id, one)
    assert writer.flush(session_id).result(PATIENCE_S) == SequenceRanges([(0, 60)])
    assert list(read_packets(engine, session_id)) == sent
    assert [p.sequence for p in read_packets_in_order(engine, session_id)] == list(range(60))
    with engine.connect() as connection:
        assert connection.scalar(select(MotionSession.packets_stored)) == 60


def test_a_duplicate_is_not_stored_twice_while_waiting_nor_later(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    assert writer.append_packet(session_id, packet(1))
    assert not writer.append_packet(session_id, packet(1))
    writer.flush(session_id).result(PATIENCE_S)
    assert not writer.append_packet(session_id, packet(1))
    assert writer.append_packet(session_id, packet(0))
    writer.flush(session_id).result(PATIENCE_S)
    assert [p.sequence for p in read_packets(engine, session_id)] == [1, 0]
    assert writer.metrics.packets_duplicate == 2


def test_only_what_is_committed_is_called_durable(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    told: list[tuple[SequenceRanges, SequenceRanges]] = []
    enough = threading.Event()

    def on_durable(durable: SequenceRanges) -> None:
        # Read by another connection at the moment of the call.
        told.append((durable, stored_ranges(engine, session_id)))
        if len(durable) == 40:
            enough.set()

    writer.open_session(session_id, on_durable)
    for n in range(40):
        writer.append_packet(session_id, packet(n))
        if n % 7 == 0:
            wait([writer.flush(session_id)], 10)
    writer.flush(session_id)
    assert enough.wait(PATIENCE_S)
    assert len(told) > 3
    assert all(said == stored for said, stored in told)


def test_the_ledger_is_read_back_after_a_restart(
    engine: Engine, settings: object, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    first = GroupCommitWriter(engine, commit_interval_s=0.01)
    first.start()
    first.open_session(session_id)
    for n in (0, 1, 2, 5, 6, 9):
        first.append_packet(session_id, packet(n))
    first.flush(session_id).result(PATIENCE_S)
    first.append_packet(session_id, packet(7))
    # No close: like a killed process, what waited is lost and was never acknowledged.
    reopened = create_from_url(str(engine.url))
    second = GroupCommitWriter(reopened, commit_interval_s=0.01)
    second.start()
    assert second.open_session(session_id) == SequenceRanges([(0, 3), (5, 7), (9, 10)])
    sent_again = [n for n in range(10) if second.append_packet(session_id, packet(n))]
    assert sent_again == [3, 4, 7, 8]
    second.flush(session_id).result(PATIENCE_S)
    stored = list(read_packets(reopened, session_id))
    assert sorted(p.sequence for p in stored) == list(range(10))
    assert all(p == packet(p.sequence) for p in stored)
    second.close()
    first._sessions.clear()
    first.close()
    reopened.dispose()


def test_a_deleted_session_fails_alone(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    gone, good = new_session(), new_session()
    failures: list[str] = []
    writer.open_session(gone, on_failure=lambda error: failures.append(error.message))
    writer.open_session(good)
    with unit_of_work(engine) as session:
        session.execute(delete(MotionSession).where(MotionSession.id == gone))
    writer.append_packet(gone, packet(0))
    writer.append_packet(good, packet(0))
    lost, kept = writer.flush(gone), writer.flush(good)
    assert kept.result(PATIENCE_S) == SequenceRanges([(0, 1)])
    with pytest.raises(Conflict, match="session no longer exists"):
        lost.result(PATIENCE_S)
    assert failures == ["The session no longer exists."]
    with pytest.raises(Conflict):
        writer.append_packet(gone, packet(1))
    assert writer.append_packet(good, packet(1))
    assert writer.flush(good).result(PATIENCE_S) == SequenceRanges([(0, 2)])
    assert writer.metrics.queued_bytes == 0


def test_a_failing_disk_loses_nothing(engine: Engine, new_session: Callable[..., str], packet: Make) -> None:
    session_id = new_session()
    broken = threading.Event()
    broken.set()

    @event.listens_for(engine, "before_cursor_execute")
    def fail(connection, cursor, statement, parameters, context, many):  # type: ignore[no-untyped-def]
        if broken.is_set() and statement.startswith("INSERT INTO signal_chunk"):
            raise OperationalError(statement, {}, Exception("disk is full"))

    writer = GroupCommitWriter(engine, commit_interval_s=0.01)
    writer.start()
    writer.open_session(session_id)
    for n in range(10):
        writer.append_packet(session_id, packet(n))
    future = writer.flush(session_id)
    assert not wait([future], 0.15).done
    assert stored_ranges(engine, session_id) == SequenceRanges()
    assert writer.metrics.commit_failures > 0
    # What comes meanwhile waits its turn, and a duplicate is still one.
    assert writer.append_packet(session_id, packet(10))
    assert not writer.append_packet(session_id, packet(3))
    broken.clear()
    assert future.result(PATIENCE_S) == SequenceRanges([(0, 10)])
    assert writer.flush(session_id).result(PATIENCE_S) == SequenceRanges([(0, 11)])
    assert [p.sequence for p in read_packets(engine, session_id)] == list(range(11))
    writer.close()


def test_a_full_queue_refuses_and_takes_again_later(
    engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id, other = new_session(), new_session()
    size = len(packet(0).payload) + 128
    writer = GroupCommitWriter(engine, commit_interval_s=0.01, session_bytes=3 * size, queue_bytes=5 * size)
    writer.open_session(session_id)
    writer.open_session(other)
    for n in range(3):
        writer.append_packet(session_id, packet(n))
    with pytest.raises(Unavailable) as refused:
        writer.append_packet(session_id, packet(3))
    assert refused.value.details["reason"] == "store_behind"
    # One session's backlog leaves room for another's.
    assert writer.append_packet(other, packet(0))
    assert writer.metrics.packets_refused == 1
    writer.start()
    writer.flush(session_id).result(PATIENCE_S)
    assert writer.append_packet(session_id, packet(3))
    writer.close()
    assert stored_ranges(engine, session_id) == SequenceRanges([(0, 4)])


def test_a_session_faster_than_life_is_stored_before_its_second_is_over(
    engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    fast, slow = new_session(), new_session()
    size = len(packet(0).payload) + 128
    fast_is_stored = threading.Event()
    writer = GroupCommitWriter(engine, commit_interval_s=0.01, chunk_s=60.0, session_bytes=80 * size)
    writer.open_session(fast, lambda _: fast_is_stored.set())
    writer.open_session(slow)
    for n in range(10):
        writer.append_packet(fast, packet(n))
    writer.append_packet(slow, packet(0))
    writer.start()
    assert fast_is_stored.wait(PATIENCE_S)
    assert stored_ranges(engine, fast) == SequenceRanges([(0, 10)])
    # The others wait for their own time.
    assert stored_ranges(engine, slow) == SequenceRanges()
    writer.close()


def test_closing_the_writer_commits_what_waits(
    engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer = GroupCommitWriter(engine, commit_interval_s=5.0, chunk_s=60.0)
    writer.start()
    writer.open_session(session_id)
    for n in range(4):
        writer.append_packet(session_id, packet(n))
    writer.add_event(session_id, "mark", 1.5, text="looked up")
    writer.close()
    assert stored_ranges(engine, session_id) == SequenceRanges([(0, 4)])
    with engine.connect() as connection:
        assert connection.execute(select(SessionEvent.kind, SessionEvent.time_s)).all() == [("mark", 1.5)]
    with pytest.raises(Unavailable):
        writer.append_packet(session_id, packet(9))


def test_a_closed_session_is_forgotten_when_all_is_stored(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    writer.append_packet(session_id, packet(0))
    future = writer.flush(session_id)
    writer.close_session(session_id)
    assert future.result(PATIENCE_S) == SequenceRanges([(0, 1)])
    writer.close_session(session_id)
    with pytest.raises(Conflict, match="not open"):
        writer.append_packet(session_id, packet(1))


def test_many_sessions_share_commits(engine: Engine, new_session: Callable[..., str], packet: Make) -> None:
    sessions = [new_session() for _ in range(8)]
    writer = GroupCommitWriter(engine, commit_interval_s=0.05, chunk_s=0.05)
    writer.start()
    for session_id in sessions:
        writer.open_session(session_id)

    def feed(session_id: str) -> None:
        for n in range(50):
            writer.append_packet(session_id, packet(n))

    threads = [threading.Thread(target=feed, args=(session_id,)) for session_id in sessions]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for future in [writer.flush(session_id) for session_id in sessions]:
        assert future.result(PATIENCE_S) == SequenceRanges([(0, 50)])
    # Far fewer transactions than chunks or sessions times packets.
    assert writer.metrics.commits <= 20
    assert writer.metrics.packets_stored == 400
    writer.close()


def test_a_damaged_chunk_is_noticed_when_read(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    writer.append_packet(session_id, packet(0))
    writer.flush(session_id).result(PATIENCE_S)
    with unit_of_work(engine) as session:
        chunk = session.scalars(select(SignalChunk)).one()
        chunk.data = chunk.data[:-1] + bytes([chunk.data[-1] ^ 1])
    with pytest.raises(DamagedChunkError, match="checksum"):
        list(read_packets(engine, session_id))


def test_changing_shapes_start_new_chunks(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Make
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    sent = [packet(0), packet(1), packet(2, counts=False), packet(3, ticks=2), packet(4, sensors=2)]
    for one in sent:
        writer.append_packet(session_id, one)
    writer.flush(session_id).result(PATIENCE_S)
    assert list(read_packets(engine, session_id)) == sent
    with engine.connect() as connection:
        assert connection.scalar(select(func.count()).select_from(SignalChunk)) == 4


@pytest.mark.parametrize(
    "change",
    [{"payload": b"\x00" * 7}, {"payload": b""}, {"tick_count": 0}, {"encoding": 9}, {"sequence": -1}],
)
def test_an_impossible_packet_is_refused_before_it_can_harm(
    writer: GroupCommitWriter, new_session: Callable[..., str], packet: Make, change: dict[str, object]
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    with pytest.raises(InvalidInput):
        writer.append_packet(session_id, replace(packet(0), **change))
    assert writer.append_packet(session_id, packet(0))


def test_sessions_that_threads_open_together_share_the_disk_evenly(engine: Engine) -> None:
    writer, standing = GroupCommitWriter(engine), Standing(SequenceRanges(), 0, {})
    usual_s = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as threads:
            opened = [
                threads.submit(writer.open_session, f"{number:032x}", standing=standing)
                for number in range(4000)
            ]
            assert all(not one.result(PATIENCE_S) for one in opened)
    finally:
        sys.setswitchinterval(usual_s)
    shares = sorted(one.head_start for one in writer._sessions.values())
    assert len(shares) == 4000
    # They lie evenly: no two ask for the disk at the same moment.
    assert max(np.diff(shares)) < 2.0 / 4000
