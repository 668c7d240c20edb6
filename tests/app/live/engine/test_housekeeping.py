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


@pytest.mark.parametrize(
    ("stops_s", "is_behind", "lost"), [(0.0, False, True), (0.3, False, False), (0.0, True, False)]
)
def test_nobody_is_silent_while_the_service_itself_was(
    monkeypatch: pytest.MonkeyPatch, stops_s: float, is_behind: bool, lost: bool
) -> None:
    """What has arrived meanwhile is still to be read."""
    monkeypatch.setattr(housekeeping, "PERIOD_S", 0.0)
    monkeypatch.setattr(housekeeping, "STOOD_STILL_S", 0.2)
    told: list[str] = []
    looked = asyncio.Event()

    class Session:
        id, state = "one", "recording"
        last_arrival_s = time.monotonic() - 60.0
        now = SimpleNamespace(
            ledger=SimpleNamespace(last_sequence=None, is_settled=False),
            clock=SimpleNamespace(session_time_us=0),
        )

        def silent(self) -> None:
            told.append("silent")

        def link_lost(self, _: Any) -> None:
            told.append("link lost")

        def is_being_stored(self) -> None:
            looked.set()

    async def run() -> None:
        keeper = Housekeeping(lambda: [Session()], lambda _: True, lambda *_: None, **FOREVER)  # type: ignore[list-item]
        keeper.is_behind = lambda: is_behind
        task = asyncio.create_task(keeper.run())
        await asyncio.sleep(0)
        time.sleep(stops_s)  # noqa: ASYNC251 - the service stands still
        await looked.wait()
        task.cancel()

    asyncio.run(asyncio.wait_for(run(), 10.0))
    assert told == (["silent", "link lost"] if lost else [])
