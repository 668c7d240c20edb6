"""The clock of a session that is taken up from its end stands where it stood, without every packet being read."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.network.clock import PacketClock
from app.network.declaration import Declaration
from app.network.raw_packet import RawPacket
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import read_before_ending, read_packets_in_order
from estimators.channels import Channel
from tests.patience import PATIENCE_S

PACKETS, CHUNK, TICKS, INTERVAL_US = 1800, 60, 5, 1_000_000
START_US = 2**32 - 10_000_000
"""A counter of 32 bits that begins anew 10 s later, and 71 minutes after that."""


def at(packet: RawPacket, number: int) -> RawPacket:
    """Ticks of a second each: hours in few packets."""
    device_time_us = (START_US + number * TICKS * INTERVAL_US) % 2**32
    return replace(packet, device_time_us=device_time_us, tick_interval_us=INTERVAL_US)


@pytest.mark.parametrize("is_shuffled", [False, True])
def test_the_clock_stands_where_all_packets_put_it(
    writer: GroupCommitWriter,
    engine: Engine,
    new_session: Callable[..., str],
    packet: Callable[..., RawPacket],
    is_shuffled: bool,
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    sent = [at(packet(n, ticks=TICKS), n) for n in range(PACKETS)]
    order = np.arange(PACKETS)
    if is_shuffled:
        # Packets of the eighth and the ninth chunk come in each other's.
        late = slice(7 * CHUNK, 9 * CHUNK)
        order[late] = np.random.default_rng(1).permutation(order[late])
    for start in range(0, PACKETS, CHUNK):
        for number in order[start : start + CHUNK]:
            assert writer.append_packet(session_id, sent[number])
        writer.flush(session_id).result(PATIENCE_S)
    whole = PacketClock(Declaration(("sternum", "upper_arm_right", "forearm_right"), 100.0))
    for one in read_packets_in_order(engine, session_id):
        whole.admit(one)

    ticks = sum(one.tick_count for one in sent[-2 * CHUNK :])
    first, heads = read_before_ending(engine, session_id, ticks, Channel(sent[0].channel_mask))
    assert first == PACKETS - 2 * CHUNK
    assert len(heads) == 2 * (PACKETS // CHUNK - 2)
    ending = PacketClock(whole.declaration)
    for one in heads:
        ending.admit(one)
    assert ending.session_time_us < whole.session_time_us
    for one in read_packets_in_order(engine, session_id, first):
        ending.admit(one)
    assert ending.state() == whole.state()
    assert whole.session_time_us > 2 * 2**32
    # Without those before it the counter's turns are not known.
    without = PacketClock(whole.declaration)
    for one in read_packets_in_order(engine, session_id, first):
        without.admit(one)
    assert without.state() != whole.state()


def test_where_a_channel_is_missing_it_begins_with_the_first_packet(
    writer: GroupCommitWriter, engine: Engine, new_session: Callable[..., str], packet: Callable[..., Any]
) -> None:
    session_id = new_session()
    writer.open_session(session_id)
    for number in range(3):
        writer.append_packet(session_id, packet(number))
        writer.flush(session_id).result(PATIENCE_S)
    has = packet(0).channel_mask
    assert read_before_ending(engine, session_id, 1, has)[0] == 2
    assert read_before_ending(engine, session_id, 1, has | Channel.FORCE) == (0, [])
