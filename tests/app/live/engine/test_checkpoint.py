"""A session that moves to another machine goes on from its checkpoint with the bits of one that stayed."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.limits import Limits
from app.live import repository
from app.live.bus import MemoryBus, topic
from app.live.manager import LiveManager
from app.live.session.checkpoint import Checkpoint, capture, pack
from app.live.session.runner import LiveSession
from app.live.warmup import FIRST, warm_up
from app.network.declaration import Declaration
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Allowance, Settings
from tests.app.live.engine.both_ways import Faults, Sender, offer, packets_of, worn
from tests.app.live.engine.test_both_ways import ARM, seen
from tests.app.live.live_load import connected, remember, swaying

SECONDS = 75.0
"""Longer than the tail from which a restart of a service in one process goes on."""
MARKED, MOVED = 0.8, 0.9
"""Shares of the stream: when the checkpoint is made, and when the session moves."""
FAULTS = Faults(0.01, 0.0, 0.0, 0.0, 0.0, 0.0, False, (5,), 0.002, ((1, 2000, 2030), (2, 5000, 5120)), ())


@pytest.fixture(autouse=True)
def no_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks of the first seconds run in a process of their own, whenever it has time."""
    monkeypatch.setattr("app.live.checks.first_seconds.CheckTurns.begin", lambda _: False)


@pytest.fixture
def machine(engine: Engine, settings: Settings) -> Callable[[], LiveManager]:
    warm_up(FIRST)

    def make() -> LiveManager:
        limits = Limits({"streams": Allowance(1000, 1000, 1000)})
        writer = GroupCommitWriter(engine)
        writer.start()
        return LiveManager(engine, writer, MemoryBus(), lambda _: None, limits=limits)

    return make


def give(manager: LiveManager, sender: Sender, packets: list[bytes], at_s: float) -> float:
    for number, data in enumerate(packets):
        at_s += 0.05
        offer(manager.pooled, sender, data, 0, at_s)
        if number % 3 == 0:
            manager.pooled.turn()
    manager.pooled.turn()
    return at_s


async def settled(session: LiveSession) -> LiveSession:
    await session.line.drained()
    session.settle()
    return session


Choose = Callable[[Checkpoint], Checkpoint | None]


async def moved_and_not(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, choose: Choose
) -> Any:
    """Give one stream to a session that stays and to one that moves; return what both showed since, and the states."""
    calibration, whole = swaying(SECONDS)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)
    packets = packets_of(stream, FAULTS, np.random.default_rng(3))
    marked, moved = (int(share * len(packets)) for share in (MARKED, MOVED))
    first, second = machine(), machine()
    try:
        stays, moves = [
            Sender(await connected(first, world.subjects["therapist"], world.patient_id, stream))
            for _ in range(2)
        ]
        for sender in (stays, moves):
            at_s = give(first, sender, packets[:marked], 100.0)
        old = await settled(first.live(moves.intake.session_id))
        state = capture(old)
        assert state is not None
        checkpoint = pack(state)
        for sender in (stays, moves):
            at_s = give(first, sender, packets[marked:moved], 100.0 + 0.05 * marked)
        await settled(old)
        await asyncio.wrap_future(first.writer.flush(old.id))
        await old.saved()

        second._opener = replace(second._opener, checkpoint=lambda _: choose(checkpoint))
        stored = await asyncio.to_thread(repository.load, engine, old.id)
        new = await second.join(stored, Declaration.from_dict(stored.hello or {}))
        listeners = [
            (first.bus.subscribe(topic(stays.intake.session_id, "frames"), size=100_000)),
            (second.bus.subscribe(topic(old.id, "frames"), size=100_000)),
        ]
        goes_on = Sender(second.attach(new, lambda: asyncio.sleep(0)))
        give(first, stays, packets[moved:], at_s)
        give(second, goes_on, packets[moved:], at_s)
        sessions = [await settled(first.live(stays.intake.session_id)), await settled(new)]
        return [seen(one) for one in listeners], [one.pipeline.state() for one in sessions]
    finally:
        for one in (first, second):
            one.end_checks()
            await asyncio.to_thread(one._check_process.close)
            await asyncio.to_thread(one.writer.close)


@pytest.mark.slow
@pytest.mark.parametrize(
    "choose",
    [
        lambda made: made,
        lambda made: None,
        lambda made: replace(made, layout=made.layout + 1, data=b"of a layout that nobody here knows"),
    ],
    ids=["checkpoint", "no_checkpoint", "other_layout"],
)
def test_no_bit_differs_after_a_move(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, choose: Choose
) -> None:
    shown, states = asyncio.run(moved_and_not(machine, world, engine, choose))
    assert len(shown[0]["ticks"]) > 500
    assert shown[0] == shown[1]
    assert states[0].keys() == states[1].keys()
    for name, values in states[0].items():
        assert values.tobytes() == states[1][name].tobytes(), name
