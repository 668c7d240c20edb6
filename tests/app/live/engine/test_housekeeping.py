"""Looking after the live sessions: what goes wrong with one is not felt by the others."""

import asyncio
import time
from types import SimpleNamespace
from typing import Any

import pytest

from app.live import housekeeping
from app.live.housekeeping import Housekeeping

FOREVER: Any = {"idle_close_s": 600.0, "goodbye_close_s": 60.0, "longest_s": 3600.0}


def test_a_session_that_fails_leaves_those_behind_it_looked_after(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(housekeeping, "PERIOD_S", 0.001)
    settled: list[str] = []
    enough = asyncio.Event()

    def session(name: str) -> Any:
        def settle() -> None:
            settled.append(name)
            if len(settled) >= 12:
                enough.set()
            raise RuntimeError(name)

        return SimpleNamespace(id=name, settle=settle)

    async def run() -> None:
        keeper = Housekeeping(
            lambda: [session("one"), session("two"), session("three")],
            lambda _: True,
            lambda *_: None,
            **FOREVER,
        )
        task = asyncio.create_task(keeper.run())
        await enough.wait()
        task.cancel()

    asyncio.run(asyncio.wait_for(run(), 10.0))
    assert {"one", "two", "three"} <= set(settled)


def test_sessions_are_settled_between_turns_and_a_few_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(housekeeping, "PERIOD_S", 0.0)
    monkeypatch.setattr(housekeeping, "THOROUGH_EVERY_TURNS", 1)
    monkeypatch.setattr(housekeeping, "AT_ONCE_S", 0.0)
    events: list[str] = []
    enough = asyncio.Event()

    def settle() -> None:
        events.append("settled")
        if len(events) >= 12:
            enough.set()
        time.sleep(1e-4)
        raise RuntimeError

    async def between_turns() -> None:
        events.append("between")

    async def run() -> None:
        sessions: Any = [SimpleNamespace(id="one", settle=settle)] * 3
        keeper = Housekeeping(
            lambda: sessions, lambda _: True, lambda *_: None, between_turns=between_turns, **FOREVER
        )
        task = asyncio.create_task(keeper.run())
        await enough.wait()
        task.cancel()

    asyncio.run(asyncio.wait_for(run(), 10.0))
    assert events[:12] == ["between", "settled"] * 6
