"""The history of the demonstration is made once, whatever interrupts it."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from app.demo import companion, history
from app.demo.history import History
from app.edge.demonstration import STEPS, HistoryProgress, new_progress
from app.errors import SignInRequired, Unavailable


def test_progress_is_found_again(tmp_path: Path) -> None:
    assert HistoryProgress.of(tmp_path) is None
    progress = new_progress(tmp_path)
    progress.save()
    progress.add("walk 0", "", "abc")
    found = HistoryProgress.of(tmp_path)
    assert found is not None
    assert (found.total, found.done, found.kept_sessions) == (STEPS, {"walk 0": ""}, ["abc"])
    assert not found.is_complete


def test_a_demonstration_of_an_earlier_version_needs_nothing(tmp_path: Path) -> None:
    (tmp_path / "history-complete").touch()
    found = HistoryProgress.of(tmp_path)
    assert found is not None
    assert found.is_complete


def test_an_interrupted_history_goes_on_with_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    trouble = {"walk 0"}

    def steps(self: History) -> Any:
        async def make(name: str) -> tuple[str, str]:
            if name in trouble:
                raise Unavailable("The service is stopping.")
            made.append(name)
            return "", f"session of {name}"

        return [(name, lambda name=name: make(name)) for name in ("template", "walk 0", "walk 1")]

    async def nothing_to_forget(*_: Any) -> None:
        return None

    monkeypatch.setattr(History, "steps", steps)
    monkeypatch.setattr(history, "_forget_half_made", nothing_to_forget)
    progress = HistoryProgress(tmp_path / "history.json", 3)

    def make_all() -> None:
        asyncio.run(history.make_history(None, None, {}, progress, lambda text: None))  # type: ignore[arg-type]

    with pytest.raises(Unavailable):
        make_all()
    assert made == ["template"]
    trouble.clear()
    progress = HistoryProgress.of(tmp_path) or progress
    make_all()
    assert made == ["template", "walk 0", "walk 1"]
    assert progress.is_complete
    make_all()
    assert len(made) == 3


def test_the_steps_are_as_many_as_the_page_is_told() -> None:
    steps = History(None, None, {}, None).steps()  # type: ignore[arg-type]
    assert len(steps) == len({name for name, _ in steps}) == STEPS


class EnoughError(BaseException):
    """Ends the endless stream."""


def test_the_live_patient_comes_back_after_any_trouble(monkeypatch: pytest.MonkeyPatch) -> None:
    """Signed out over night, service restarted, something nobody thought of: it signs in anew each time."""
    happened: list[str] = []
    troubles = [SignInRequired("Sign in again."), Unavailable("Stopping."), ValueError("unforeseen"), None]

    class Service:
        def __init__(self, server: str) -> None:
            happened.append("client")

        async def __aenter__(self) -> "Service":
            return self

        async def __aexit__(self, *_: Any) -> None:
            return None

        async def sign_in(self, email: str, password: str) -> None:
            happened.append("sign in")

    async def perform(service: Any) -> None:
        if not troubles:
            raise EnoughError
        trouble = troubles.pop(0)
        if trouble is not None:
            raise trouble

    async def answers(server: str) -> None:
        happened.append("answers")

    monkeypatch.setattr(companion, "ServiceClient", Service)
    monkeypatch.setattr(companion, "until_it_answers", answers)
    with pytest.raises(EnoughError):
        asyncio.run(companion.for_ever("http://127.0.0.1:1", perform, 0.0))
    assert happened == ["answers", "client", "sign in"] * 5
