"""A session goes on from its checkpoint after a restart, with the bits of one that was never interrupted."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.live import manager as live_manager
from app.live import repository
from app.live.manager import LiveManager
from app.live.session import rebuild
from app.live.session.marks import Marks
from app.live.session.runner import LiveSession
from app.network.declaration import Declaration
from app.recordings.analysis.offline import decoded as decoded_packet
from tests.app.live.engine.both_ways import Sender, packets_of, worn
from tests.app.live.engine.test_both_ways import ARM
from tests.app.live.engine.test_checkpoint import FAULTS, give, machine, no_checks, settled
from tests.app.live.live_load import connected, remember, swaying

__all__ = ["machine", "no_checks"]

SECONDS, MARKED_EVERY = 20.0, 50
Found = tuple[int, dict[str, bytes], object, object]


async def restarted(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, patch: Any, *, by: str
) -> list[Found]:
    """Stream with checkpoints; return packets read again and where the session stands, before and after a restart."""
    calibration, whole = swaying(SECONDS)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)
    first, second = machine(), machine()
    decoded: list[object] = []

    def counted(raw: Any) -> Any:
        decoded.append(raw)
        return decoded_packet(raw)

    def found(session: LiveSession) -> Found:
        parts = session.now
        numbers = {name: one.tobytes() for name, one in parts.pipeline.state().items()}
        return len(decoded), numbers, parts.clock.state(), parts.aligner.next_sequence

    try:
        sender = Sender(await connected(first, world.subjects["therapist"], world.patient_id, stream))
        packets, at_s = packets_of(stream, FAULTS, np.random.default_rng(3)), 100.0
        for start in range(0, len(packets), MARKED_EVERY):
            at_s = give(first, sender, packets[start : start + MARKED_EVERY], at_s)
            old = await settled(first.live(sender.intake.session_id))
            if start + MARKED_EVERY < len(packets):
                first._note_where(old)
        if by == "stop":
            await first.stop()
        else:
            await asyncio.wrap_future(first.writer.flush(old.id))
            await old.saved()
        if by == "kill_before_the_epoch_is_stored":
            hello = replace(old.declaration, clock_epochs=()).to_dict()
            await asyncio.to_thread(repository.save_hello, engine, old.id, hello)
        patch.setattr(rebuild, "decoded", counted)
        stored = await asyncio.to_thread(repository.load, engine, old.id)
        new = await second.join(stored, Declaration.from_dict(stored.hello or {}))
        assert new.declaration.clock_epochs == old.declaration.clock_epochs
        return [found(old), found(new)]
    finally:
        for one in (first, second):
            one.end_checks()
            await asyncio.to_thread(one._check_process.close)
            await asyncio.to_thread(one.writer.close)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("by", "fewest", "most"),
    [("kill", 1, 2 * MARKED_EVERY), ("stop", 0, 0), ("kill_before_the_epoch_is_stored", 200, 10_000)],
)
def test_no_bit_differs_and_only_what_came_since_is_read(
    machine: Callable[[], LiveManager],
    world: Any,
    engine: Engine,
    monkeypatch: pytest.MonkeyPatch,
    by: str,
    fewest: int,
    most: int,
) -> None:
    monkeypatch.setattr(live_manager, "MARK_S", 0.0)
    before, after = asyncio.run(restarted(machine, world, engine, monkeypatch, by=by))
    assert fewest <= after[0] <= most
    assert after[1:] == before[1:]


def test_what_the_store_had_no_room_for_is_estimated_again(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def story(manager: LiveManager) -> None:
        calibration, whole = swaying(4.0)
        remember(engine, world.patient_id, calibration)
        stream = worn(whole, ARM)
        sender = Sender(await connected(manager, world.subjects["therapist"], world.patient_id, stream))
        packets = packets_of(stream, FAULTS, np.random.default_rng(3))
        marks, half = Marks(0.0), len(packets) // 2
        with monkeypatch.context() as patch:
            patch.setattr(manager.writer, "append_frames", lambda *_: False)
            at_s = give(manager, sender, packets[:half], 100.0)
            session = await settled(manager.live(sender.intake.session_id))
            assert [marks.due(session, is_forced=True) for _ in range(2)] == [None, None]
        give(manager, sender, packets[half:], at_s)
        assert marks.due(await settled(session), is_forced=True) is not None

    manager = machine()
    try:
        asyncio.run(story(manager))
    finally:
        manager.end_checks()
        manager._check_process.close()
        manager.writer.close()
