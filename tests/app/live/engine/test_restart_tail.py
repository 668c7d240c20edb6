"""After a restart a session with magnetometers goes on from its end, as if every packet had been read again."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.live import repository
from app.live.manager import LiveManager
from app.live.session import rebuild
from app.network.declaration import Declaration
from app.network.raw_packet import RawPacket
from tests.app.live.engine.both_ways import Sender, packets_of, worn
from tests.app.live.engine.test_both_ways import ARM
from tests.app.live.engine.test_checkpoint import FAULTS, give, machine, no_checks, settled
from tests.app.live.live_load import connected, remember, swaying

__all__ = ["machine", "no_checks"]

SECONDS, TAIL_S = 40.0, 8.0
CHUNK_PACKETS = 100

Read = Callable[..., tuple[int, list[RawPacket]]]
READ: Read = rebuild.read_before_ending
DECODED = rebuild.decoded


def every_packet(*_: object) -> tuple[int, list[RawPacket]]:
    return 0, []


def with_a_hole(*what: Any) -> tuple[int, list[RawPacket]]:
    """Heads of which one cannot be placed: more time than a session may be silent lies before it."""
    first, heads = READ(*what)
    return first, [
        heads[0],
        *(replace(one, device_time_us=one.device_time_us + 1_200_000_000) for one in heads[1:]),
    ]


async def taken_up(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, reads: list[Read], patch: Any
) -> list[tuple[int, list[object]]]:
    """Stream once, take the session up by each way of reading; return packets decoded, and where it stands."""
    calibration, whole = swaying(SECONDS)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)
    managers = [machine() for _ in range(1 + len(reads))]
    try:
        old = Sender(await connected(managers[0], world.subjects["therapist"], world.patient_id, stream))
        packets, at_s = packets_of(stream, FAULTS, np.random.default_rng(3)), 100.0
        for piece in range(0, len(packets), CHUNK_PACKETS):
            at_s = give(managers[0], old, packets[piece : piece + CHUNK_PACKETS], at_s)
            session = await settled(managers[0].live(old.intake.session_id))
            await asyncio.wrap_future(managers[0].writer.flush(session.id))
        await session.saved()
        stored = await asyncio.to_thread(repository.load, engine, session.id)
        found: list[tuple[int, list[object]]] = []
        for manager, read in zip(managers[1:], reads, strict=True):
            decoded: list[RawPacket] = []
            patch.setattr(rebuild, "read_before_ending", read)
            patch.setattr(rebuild, "decoded", lambda raw, seen=decoded: seen.append(raw) or DECODED(raw))
            new = await manager.join(stored, Declaration.from_dict(stored.hello or {}))
            parts = new.now
            numbers = {name: one.tobytes() for name, one in parts.pipeline.state().items()}
            found.append((len(decoded), [numbers, parts.clock.state(), parts.aligner.next_sequence]))
        return found
    finally:
        for one in managers:
            one.end_checks()
            await asyncio.to_thread(one._check_process.close)
            await asyncio.to_thread(one.writer.close)


@pytest.mark.slow
def test_no_bit_differs_from_reading_every_packet(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rebuild, "TAIL_S", TAIL_S)
    ways = [READ, every_packet, with_a_hole]
    by_end, by_all, after_a_hole = asyncio.run(taken_up(machine, world, engine, ways, monkeypatch))
    assert by_end[0] < 0.5 * by_all[0]
    assert after_a_hole[0] == by_all[0]
    assert by_end[1] == by_all[1] == after_a_hole[1]
