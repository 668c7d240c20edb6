"""A simulated patient that streams for days outlives its sign-in."""

import asyncio
from typing import Any

import pytest

from app.commands.simulation import arm
from app.errors import SignInRequired


class EnoughError(Exception):
    """Ends the endless stream."""


def test_a_sign_in_that_has_ended_is_made_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    happened: list[str] = []

    async def sign_in(self: Any, email: str, password: str) -> None:
        happened.append("sign in")

    async def stream(service: Any, options: arm.Options, say: Any) -> Any:
        happened.append("stream")
        if happened.count("stream") == 1:
            raise SignInRequired("Sign in again.")
        raise EnoughError

    monkeypatch.setattr(arm.ServiceClient, "sign_in", sign_in)
    monkeypatch.setattr(arm, "stream", stream)
    monkeypatch.setattr(arm, "RETRY_S", 0.0)
    options = arm.Options(
        server="http://127.0.0.1:1", email="a@b.example", password="secret", patient_id="1", forever=True
    )
    with pytest.raises(EnoughError):
        asyncio.run(arm._simulate(options))
    assert happened == ["sign in", "stream", "sign in", "stream"]
