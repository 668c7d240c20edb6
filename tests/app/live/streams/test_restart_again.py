"""A service that is killed again and again before it is well takes no longer each time."""

import asyncio
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.live import repository
from app.live.engine.shared import REBUILT_TOGETHER
from app.live.manager import LiveManager
from app.live.session import marks
from app.live.session.marks import Marks
from app.live.session.opening import Opener
from app.network.declaration import Declaration
from tests.app.live.engine.both_ways import Sender, packets_of, worn
from tests.app.live.engine.test_both_ways import ARM
from tests.app.live.engine.test_checkpoint import FAULTS, give, machine, no_checks, settled
from tests.app.live.live_load import connected, remember, swaying

__all__ = ["machine", "no_checks"]

SECONDS, SESSIONS = 3.0, 5


async def restarted(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, patch: Any
) -> tuple[int, float, list[float]]:
    """Return how many sessions were rebuilt together, seconds of each rebuilt, and when marks are due."""
    calibration, whole = swaying(SECONDS)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)
    first, second = machine(), machine()
    together = [0, 0]
    rebuild = Opener._rebuild

    def counted(opener: Opener, *what: Any) -> Any:
        together[0] += 1
        together[1] = max(together)
        time.sleep(0.05)
        try:
            return rebuild(opener, *what)
        finally:
            together[0] -= 1

    try:
        ids = []
        for number in range(SESSIONS):
            sender = Sender(await connected(first, world.subjects["therapist"], world.patient_id, stream))
            give(first, sender, packets_of(stream, FAULTS, np.random.default_rng(number)), 100.0)
            session = await settled(first.live(sender.intake.session_id))
            await asyncio.wrap_future(first.writer.flush(session.id))
            await session.saved()
            ids.append(session.id)
        patch.setattr(Opener, "_rebuild", counted)
        stored = [await asyncio.to_thread(repository.load, engine, one) for one in ids]
        new = await asyncio.gather(
            *(second.join(one, Declaration.from_dict(one.hello or {})) for one in stored)
        )
        # By chance as late as can be.
        patch.setattr(marks.random, "uniform", lambda low, high: low)
        (rebuilt_s,) = {one.rebuilt_ticks * one.declaration.time_step_s for one in new[:1]}
        due = [
            period_s
            for period_s in (0.5 * rebuilt_s, 2.0 * rebuilt_s)
            if Marks(period_s).due(await settled(new[0])) is not None
        ]
        return together[1], rebuilt_s, due
    finally:
        for one in (first, second):
            one.end_checks()
            await asyncio.to_thread(one._check_process.close)
            await asyncio.to_thread(one.writer.close)


def test_few_are_rebuilt_together_and_one_of_far_back_has_its_checkpoint_at_once(
    machine: Callable[[], LiveManager], world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    together, rebuilt_s, due = asyncio.run(restarted(machine, world, engine, monkeypatch))
    assert together == REBUILT_TOGETHER
    assert rebuilt_s == pytest.approx(SECONDS, abs=0.5)
    assert due == [0.5 * rebuilt_s]
