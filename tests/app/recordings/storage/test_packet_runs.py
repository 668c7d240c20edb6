"""Packets that came one after the other are stored as the same bytes as the same packets given one by one."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.network.packet import decode_packet, encode_packet
from app.network.packet_run import PacketRun, runs_of
from app.network.raw_packet import RawPacket
from app.recordings.signals.buffers import Batch
from app.recordings.signals.chunks import encode_packets, encode_runs
from app.recordings.signals.group_commit import CHUNK_S, GroupCommitWriter
from app.recordings.signals.store import read_packets
from estimators.channels import Channel
from tests.app.recordings.storage.test_writer_counts import calls_of

RUNS_CALLS = 125
"""Of one chunk of 20 runs of one packet."""
MOTION = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER


def messages(count: int, *, ticks: int = 5, is_float: bool = False, first: int = 0) -> list[bytes]:
    random = np.random.default_rng(first)
    found = []
    for number in range(first, first + count):
        values: Any = random.integers(-900, 900, (ticks, 4, 9)).astype("<f4" if is_float else "<i2")
        found.append(
            encode_packet(
                values,
                sequence=number,
                device_time_us=2**64 - 20_000 + 10_000 * number if number < 2 else 10_000 * number,
                tick_interval_us=10_000,
                channels=MOTION,
                flags=number % 2,
            )
        )
    return found


def arrivals(count: int) -> list[int]:
    return [1_700_000_000_000_000_000 + 49_000_000 * n for n in range(count)]


def raw(packets: list[bytes], first: int = 0) -> list[RawPacket]:
    """The packets one by one, as the general way hands them over."""
    each = zip(packets, arrivals(len(packets)), strict=True)
    return [
        RawPacket.from_packet(decode_packet(data), at_ns, first + n) for n, (data, at_ns) in enumerate(each)
    ]


@pytest.mark.parametrize("is_float", [False, True])
def test_runs_and_packets_give_the_same_chunk(is_float: bool) -> None:
    sent = messages(20, is_float=is_float)
    parts = [PacketRun(n, sent[n : n + 4], arrivals(20)[n : n + 4]) for n in range(0, 20, 4)]
    assert [packet for run in parts for packet in run.packets()] == raw(sent)
    assert encode_runs(parts) == encode_packets(raw(sent))


@pytest.mark.parametrize(
    "cuts", [[(n, n + 1) for n in range(20)], [(0, 3), (5, 6), (6, 20)], [(9, 20), (2, 5), (5, 6)]]
)
def test_runs_of_any_length_with_gaps_and_out_of_order_are_one_chunk(cuts: list[tuple[int, int]]) -> None:
    sent, came = messages(20), arrivals(20)
    parts = [PacketRun(n, sent[n:stop], came[n:stop]) for n, stop in cuts]
    assert encode_runs(parts) == encode_packets([packet for run in parts for packet in run.packets()])


def test_a_second_of_single_packets_calls_little() -> None:
    """Most runs are of one packet: heads are read at once, not run by run."""
    sent, came = messages(20), arrivals(20)
    parts = [PacketRun(n, sent[n : n + 1], came[n : n + 1]) for n in range(20)]
    assert calls_of(lambda: encode_runs(parts)) < 1.1 * RUNS_CALLS


def test_a_run_has_one_shape() -> None:
    sent = [*messages(3), *messages(2, ticks=6, first=3), *messages(1, is_float=True, ticks=5, first=5)]
    found = runs_of(70, sent, arrivals(6))
    assert [(one.first_sequence, len(one.messages)) for one in found] == [(70, 3), (73, 2), (75, 1)]
    batch, alone = Batch([*found], [], [], [], 0), Batch([*raw(sent, 70)], [], [], [], 0)
    assert batch.encode(0) == alone.encode(0) == 2
    assert batch.raw == alone.raw


def test_a_run_that_overlaps_what_is_here_adds_only_the_rest(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    session_id = new_session()
    writer = GroupCommitWriter(engine)
    writer.start()
    try:
        writer.open_session(session_id)
        sent = messages(6)
        assert writer.append_run(session_id, PacketRun(0, sent[:4], arrivals(4)), time.monotonic()) == 4
        assert writer.append_run(session_id, PacketRun(2, sent[2:], arrivals(4)), time.monotonic()) == 2
        durable = writer.flush(session_id).result(20)
        assert list(durable) == [(0, 6)]
        assert [one.sequence for one in read_packets(engine, session_id)] == list(range(6))
        assert writer.metrics.packets_stored == 6
        assert writer.metrics.packets_duplicate == 2
    finally:
        writer.close()


def test_a_run_is_due_when_its_first_packet_is_old_enough(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    session_id = new_session()
    writer = GroupCommitWriter(engine)
    writer.open_session(session_id)
    open_session = writer._sessions[session_id]
    open_session.head_start = 0.0
    writer.append_run(session_id, PacketRun(0, messages(4), arrivals(4)), time.monotonic() - 0.9 * CHUNK_S)
    assert not open_session.is_due(time.monotonic(), CHUNK_S, everything=False)
    assert open_session.is_due(time.monotonic() + 0.11 * CHUNK_S, CHUNK_S, everything=False)
