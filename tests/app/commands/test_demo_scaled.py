"""The demonstration on many parts waits for their first start as long as it lasts, and for none that has ended."""

from typing import Any

import pytest

from app.commands import demo_scaled
from app.errors import Unavailable


class Process:
    def __init__(self, status: int | None) -> None:
        self._status = status

    def poll(self) -> int | None:
        return self._status


def waited(monkeypatch: pytest.MonkeyPatch, answers: dict[int, int], *status: int | None) -> int:
    """How often was looked, where each port answers from that look on."""
    looks = 0

    def look(_: float) -> None:
        nonlocal looks
        looks += 1

    monkeypatch.setattr(demo_scaled.time, "sleep", look)
    monkeypatch.setattr(demo_scaled, "answers", lambda port: looks >= answers[port])
    running: Any = dict(zip(answers, map(Process, status), strict=True))
    demo_scaled._until_ready(running)
    return looks


def test_it_waits_until_all_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    assert waited(monkeypatch, {8000: 3, 8001: 2000}, None, None) == 2000


def test_it_waits_for_none_that_has_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(Unavailable, match="see what they wrote above"):
        waited(monkeypatch, {8000: 3, 8001: 2000}, None, 1)
