"""A session that moves to another machine goes on from its checkpoint with the bits of one that stayed."""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.limits import Limits
from app.live import repository
from app.live.bus import MemoryBus, topic
from app.live.manager import LiveManager
from app.live.session import opening, rebuild
from app.live.session.checkpoint import State, capture, pack, resume
from app.live.session.runner import LiveSession
from app.live.warmup import FIRST, warm_up
from app.network.declaration import Declaration
from app.recordings.signals.checkpoints import Checkpoint
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


Choose = Callable[[State], Checkpoint | None]


async def moved_and_not(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, choose: Choose, patch: Any
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
        for sender in (stays, moves):
            at_s = give(first, sender, packets[marked:moved], 100.0 + 0.05 * marked)
        await settled(old)
        await asyncio.wrap_future(first.writer.flush(old.id))
        await old.saved()

        second._opener = replace(second._opener, is_exact=True)
        patch.setattr(opening, "load_checkpoint", lambda *_: choose(state))
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


def other_layout(state: State) -> Checkpoint:
    made = pack(state)
    return replace(made, layout=made.layout + 1, data=b"of an unknown layout")


def damaged(state: State) -> Checkpoint:
    made = pack(state)
    middle = len(made.data) // 2
    return replace(made, data=made.data[:middle] + bytes([made.data[middle] ^ 1]) + made.data[middle + 1 :])


def without(state: State, begin: str) -> Checkpoint:
    arrays = {name: one for name, one in state.arrays.items() if not name.startswith(begin)}
    assert len(arrays) < len(state.arrays)
    return pack(replace(state, arrays=arrays))


UNFIT: Mapping[str, Choose] = {
    "damaged": damaged,
    "cut_off": lambda state: replace(pack(state), data=pack(state).data[:-100]),
    "not_compressed": lambda state: replace(pack(state), data=b"not a checkpoint"),
    "no_pipeline": lambda state: without(state, "pipeline."),
    "no_rows": lambda state: without(state, "aligner.rows"),
    "other_version": lambda state: pack(replace(state, key=bytes(16))),
    "other_layout": other_layout,
    "another_epoch": lambda state: pack(
        replace(state, met=((replace(state.met[0][0], first_sequence=1),), ()))
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("choose", "goes_on"),
    [(pack, True), (lambda _: None, False), (damaged, False), (other_layout, False)],
    ids=["checkpoint", "no_checkpoint", "damaged", "other_layout"],
)
def test_no_bit_differs_after_a_move(
    machine: Callable[[], LiveManager],
    world: Any,
    engine: Engine,
    choose: Choose,
    goes_on: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    resumed: list[bool] = []

    def noted(session: LiveSession, checkpoint: Checkpoint | None) -> bool:
        resumed.append(resume(session, checkpoint))
        return resumed[-1]

    monkeypatch.setattr(rebuild, "resume", noted)
    shown, states = asyncio.run(moved_and_not(machine, world, engine, choose, monkeypatch))
    assert resumed == [goes_on]
    assert len(shown[0]["ticks"]) > 500
    assert shown[0] == shown[1]
    assert states[0].keys() == states[1].keys()
    for name, values in states[0].items():
        assert values.tobytes() == states[1][name].tobytes(), name


@pytest.mark.slow
def test_a_checkpoint_that_does_not_fit_is_left_without_a_trace(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    calibration, whole = swaying(6.0)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)

    def traces(session: LiveSession) -> list[object]:
        parts = session.now
        found = {name: one.tobytes() for name, one in parts.pipeline.state().items()}
        return [found, parts.clock.state(), parts.aligner.next_sequence]

    async def story(manager: LiveManager) -> None:
        old, new = [
            manager.live(
                (await connected(manager, world.subjects["therapist"], world.patient_id, stream)).session_id
            )
            for _ in range(2)
        ]
        give(
            manager,
            Sender(manager._intakes[old.id]),
            packets_of(stream, FAULTS, np.random.default_rng(3)),
            100.0,
        )
        state = capture(await settled(old))
        assert state is not None
        # The clock epoch of the first packets is not stored yet.
        assert not resume(new, pack(state))
        new.now.clock.declaration = old.declaration
        before = traces(new)
        for name, choose in UNFIT.items():
            assert not resume(new, choose(state)), name
            assert traces(new) == before, name
        with monkeypatch.context() as patch:
            patch.setattr(type(new.now.pipeline), "version", "another")
            assert not resume(new, pack(state))
        assert resume(new, pack(state))
        gone_on = capture(new)
        assert gone_on is not None
        assert pack(gone_on) == pack(state)

    manager = machine()
    try:
        asyncio.run(story(manager))
    finally:
        manager.end_checks()
        manager._check_process.close()
        manager.writer.close()
