"""Questions of open sockets are gathered; each socket hears its own answer, and only its own."""

import asyncio
import traceback
from collections.abc import Sequence

import pytest
from sqlalchemy.exc import OperationalError

from app.accounts.subject import Subject
from app.errors import NotFound
from app.live.rights.authorization_checks import AuthorizationCheck
from app.live.rights.batcher import MOST_AT_ONCE, AuthorizationBatcher

SUBJECT = Subject.system("clinic")


def question(number: int) -> AuthorizationCheck:
    return AuthorizationCheck(SUBJECT, str(number), "read")


class Database:
    """Refuses the session `1`; may be silent."""

    def __init__(self) -> None:
        self.asked: list[list[str]] = []
        self.is_silent = False

    async def answer(self, questions: Sequence[AuthorizationCheck]) -> list[Exception | None]:
        self.asked.append([one.session_id for one in questions])
        if self.is_silent:
            raise OperationalError("", {}, Exception())
        return [NotFound("") if one.session_id == "1" else None for one in questions]


def test_sockets_that_ask_soon_are_asked_for_together_and_only_who_lost_the_right_hears_so() -> None:
    async def run() -> None:
        database = Database()
        desk = AuthorizationBatcher(database.answer, lambda: 0.01)
        found = await asyncio.gather(*(desk.check(question(n)) for n in range(5)), return_exceptions=True)
        assert [type(one) for one in found] == [type(None), NotFound, *[type(None)] * 3]
        assert database.asked == [["0", "1", "2", "3", "4"]]
        await desk.check(question(7))
        assert database.asked[1:] == [["7"]]

    asyncio.run(run())


def test_a_crowd_is_asked_for_at_once_in_bounded_sets() -> None:
    async def run() -> None:
        database = Database()
        desk = AuthorizationBatcher(database.answer, lambda: 0.01)
        count = 2 * MOST_AT_ONCE + 3
        await asyncio.gather(*(desk.check(question(n)) for n in range(count)), return_exceptions=True)
        assert [len(one) for one in database.asked] == [MOST_AT_ONCE, MOST_AT_ONCE, 3]

    asyncio.run(run())


def test_a_silent_database_is_told_to_every_socket_and_the_next_question_is_asked_anew() -> None:
    async def run() -> None:
        database = Database()
        desk = AuthorizationBatcher(database.answer, lambda: 0.0)
        database.is_silent = True
        found = await asyncio.gather(*(desk.check(question(n)) for n in range(2, 12)), return_exceptions=True)
        assert [type(one) for one in found] == [OperationalError] * 10
        assert found[0] is found[1]
        assert isinstance(found[0], OperationalError)
        frames = traceback.extract_tb(found[0].__traceback__)
        assert len(frames) < 6, "it does not grow with each socket"
        assert frames[-1].name == "answer", "where it was raised is named"
        database.is_silent = False
        await desk.check(question(2))

    asyncio.run(run())


def test_who_leaves_meanwhile_is_not_asked_for_and_nobody_waits_after_the_end() -> None:
    async def run() -> None:
        database = Database()
        desk = AuthorizationBatcher(database.answer, lambda: 0.01)
        leaving = asyncio.create_task(desk.check(question(4)))
        staying = asyncio.create_task(desk.check(question(5)))
        await asyncio.sleep(0)
        leaving.cancel()
        await staying
        assert database.asked == [["5"]]
        waiting = asyncio.create_task(desk.check(question(6)))
        await asyncio.sleep(0)
        desk.end()
        with pytest.raises(asyncio.CancelledError):
            await waiting

    asyncio.run(run())
