"""Whoever holds a partition may write for it, and nobody who held it before."""

from collections.abc import Callable, Iterator

import pytest
from sqlalchemy import Engine, make_url, text
from sqlalchemy.exc import OperationalError

from app.accounts.credentials.passwords import Passwords
from app.database import migrate
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.recordings.models import MotionSession
from app.recordings.signals.checkpoints import Checkpoint, load_checkpoint
from app.scaled import fencing
from app.scaled.checkpoints import save
from app.scaled.fencing import Fence, FencedError, fenced, take_over
from tests.app.conftest import build_world

pytestmark = pytest.mark.postgres

PARTITION = 3
POSITION = text("SELECT position FROM partition_hold WHERE partition = 3")


@pytest.fixture
def named(postgresql_database: Callable[[], str]) -> Iterator[Callable[[str], Engine]]:
    """Engines of one database, each with the name of a worker."""
    url = postgresql_database()
    migrate.upgrade(url)
    made: list[Engine] = []

    def make(name: str) -> Engine:
        of = make_url(url).update_query_dict({"application_name": name, "options": "-c lock_timeout=5000"})
        made.append(create_from_url(of.render_as_string(hide_password=False)))
        fencing.install(made[-1])
        return made[-1]

    yield make
    for one in made:
        one.dispose()


def held(engine: Engine, name: str, refusals: list[str]) -> Engine:
    number, _ = take_over(engine, PARTITION, name)
    return fenced(engine, Fence(PARTITION, number, lambda: refusals.append(name)))


def test_an_earlier_holder_is_refused_and_its_write_is_not_there(named: Callable[[str], Engine]) -> None:
    refusals: list[str] = []
    first, second = named("first"), named("second")
    of_first = held(first, "first", refusals)
    save(of_first, PARTITION, 10, {})
    of_second = held(second, "second", refusals)
    with pytest.raises(FencedError):
        save(of_first, PARTITION, 11, {})
    assert refusals == ["first"]
    save(of_second, PARTITION, 20, {})
    with second.connect() as connection:
        assert connection.scalar(POSITION) == 20


def test_who_takes_over_reads_on_from_what_is_stored(named: Callable[[str], Engine]) -> None:
    first, second = named("first"), named("second")
    save(held(first, "first", []), PARTITION, 10, {})
    assert take_over(second, PARTITION, "second") == (2, 10)


def test_a_transaction_that_a_paused_holder_left_open_is_ended(named: Callable[[str], Engine]) -> None:
    first, second = named("first"), named("second")
    of_first = held(first, "first", [])
    left_open = of_first.connect()
    left_open.execute(text("UPDATE partition_hold SET position = 99 WHERE partition = 3"))
    assert take_over(second, PARTITION, "second") == (2, 0)
    with pytest.raises(OperationalError):
        left_open.commit()
    left_open.invalidate()
    with second.connect() as connection:
        assert connection.scalar(POSITION) == 0


def test_only_sessions_that_are_open_have_a_checkpoint(
    named: Callable[[str], Engine], cheap_passwords: Passwords
) -> None:
    engine = named("first")
    world = build_world(engine, cheap_passwords)
    with unit_of_work(engine) as session:
        for state in ("recording", "closing"):
            fields = {
                "clinic_id": world.clinic_id,
                "patient_id": world.patient_id,
                "setup": {},
                "created_by": "x",
            }
            session.add(MotionSession(id=state, state=state, **fields))
    given = dict.fromkeys(("recording", "closing", "gone"), Checkpoint(1, 7, b"data"))
    # Whoever writes a session's row at this moment is not waited for.
    with engine.begin() as other:
        other.execute(text("UPDATE motion_session SET packets_stored = 1"))
        save(held(engine, "first", []), PARTITION, 10, given)
    assert [load_checkpoint(engine, name) for name in given] == [given["recording"], None, None]


def test_reading_needs_no_right(named: Callable[[str], Engine]) -> None:
    first, second = named("first"), named("second")
    of_first = held(first, "first", [])
    take_over(second, PARTITION, "second")
    with of_first.execution_options(read_only=True).connect() as connection:
        assert connection.scalar(POSITION) == 0
