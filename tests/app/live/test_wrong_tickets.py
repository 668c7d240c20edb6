"""Whoever shows tickets that are none is refused, soon without the database; a right one always costs as before."""

import asyncio
from typing import Any

import pytest
from sqlalchemy import Engine, event

from app.accounts.credentials.rate_limit import Limit
from app.database.unit_of_work import read_only
from app.errors import Conflict, SignInRequired, TooManyAttempts
from app.live import repository
from app.live.wrong_tickets import CountedSink, WrongTickets


class Sink:
    """Refuses a hello by an error of its own; counts what reaches it."""

    check_every_s = 1.0

    def __init__(self, error: Exception | None) -> None:
        self.error, self.asked = error, 0

    async def open(self, hello: Any, declaration: Any) -> Any:
        self.asked += 1
        if self.error is not None:
            raise self.error
        return "an intake"


def opened(sink: Sink, wrong: WrongTickets, address: str) -> Any:
    return asyncio.run(CountedSink(sink, wrong, address).open(None, None))  # type: ignore[arg-type]


def test_many_wrong_tickets_of_an_address_do_not_reach_the_database() -> None:
    wrong, sink = WrongTickets(Limit(5, 60.0)), Sink(SignInRequired(""))
    for _ in range(5):
        with pytest.raises(SignInRequired):
            opened(sink, wrong, "192.0.2.1")
    with pytest.raises(TooManyAttempts) as refused:
        opened(sink, wrong, "192.0.2.1")
    assert sink.asked == 5
    assert 0 < refused.value.details["retry_after_s"] <= 60
    with pytest.raises(SignInRequired):
        opened(sink, wrong, "192.0.2.2")


def test_right_tickets_and_what_is_wrong_with_a_session_count_nothing() -> None:
    wrong = WrongTickets(Limit(2, 60.0))
    for _ in range(10):
        assert opened(Sink(None), wrong, "192.0.2.1") == "an intake"
        with pytest.raises(Conflict):
            opened(Sink(Conflict("")), wrong, "192.0.2.1")


def test_a_ticket_that_is_none_writes_nothing(engine: Engine) -> None:
    written: list[str] = []

    def note(*given: Any) -> None:
        if not given[2].startswith("SELECT"):
            written.append(given[2])

    with read_only(engine):
        pass
    event.listen(engine, "before_cursor_execute", note)
    try:
        with pytest.raises(SignInRequired):
            repository.open_by_ticket(engine, "none")
        with pytest.raises(SignInRequired):
            repository.watch_by_ticket(engine, "none", "0" * 32)
    finally:
        event.remove(engine, "before_cursor_execute", note)
    assert not [one for one in written if one.split()[0] in {"UPDATE", "INSERT", "DELETE"}]
