"""Limits on failed sign-ins, counted in a process and, for many edges, in the database."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest
from sqlalchemy import func, select

from app.accounts.credentials.rate_limit import PER_ACCOUNT, PER_ADDRESS, LeakyCounter, Limit, SignInLimits
from app.accounts.credentials.stored_limit import CLEANED_EVERY_S, StoredCounter
from app.accounts.models import Account, AttemptCount
from app.database import migrate
from app.database.engine import create_from_url
from app.database.unit_of_work import read_only
from app.errors import TooManyAttempts

PASSWORD = "a long enough password"


class Clock:
    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


IN_DATABASES = ["sqlite", pytest.param("postgresql", marks=pytest.mark.postgres)]


@pytest.fixture
def counting(request, settings):
    """What makes counters, by the kind that the test names."""
    if request.param == "process":
        yield LeakyCounter
        return
    url = settings.database_url
    if request.param == "postgresql":
        url = request.getfixturevalue("postgresql_database")()
        migrate.upgrade(url)
    engine = create_from_url(url)
    yield partial(StoredCounter, engine=engine, settings=settings)
    engine.dispose()


everywhere = pytest.mark.parametrize("counting", ["process", *IN_DATABASES], indirect=True)
in_databases = pytest.mark.parametrize("counting", IN_DATABASES, indirect=True)


@everywhere
def test_levels_fill_leak_and_tell_when_to_come_back(counting):
    clock = Clock()
    counter = counting(Limit(capacity=3, recovery_s=10.0), clock=clock)
    assert [counter.take("a") for _ in range(3)] == [0.0, 0.0, 0.0]
    assert counter.take("a") == pytest.approx(10.0)
    assert counter.take("a") == pytest.approx(10.0), "a refused attempt does not make it worse"
    assert counter.take("b") == 0.0
    clock.now += 4.0
    assert counter.take("a") == pytest.approx(6.0)
    clock.now += 6.0
    assert counter.take("a") == 0.0
    clock.now += 1000.0
    assert [counter.take("a") for _ in range(3)] == [0.0, 0.0, 0.0]


def test_memory_is_bounded_and_the_quiet_are_forgotten_first():
    counter = LeakyCounter(Limit(capacity=1, recovery_s=1e6), maximum_keys=100, clock=Clock())
    for number in range(1000):
        counter.take(str(number))
    assert len(counter) == 100
    assert counter.take("999") > 0.0
    assert counter.take("0") == 0.0


@in_databases
def test_edges_count_together_also_at_once_and_what_is_over_is_deleted(counting):
    clock = Clock()
    edges = [counting(Limit(capacity=8, recovery_s=10.0), clock=clock) for _ in range(2)]
    with ThreadPoolExecutor(8) as threads:
        waits = list(threads.map(lambda number: edges[number % 2].take("a"), range(40)))
    assert waits.count(0.0) == 8
    assert min(wait for wait in waits if wait) == pytest.approx(10.0)
    edges[0].give_back("a")
    assert edges[1].take("a") == 0.0
    assert edges[0].take("a") == pytest.approx(10.0)
    engine = counting.keywords["engine"]
    with read_only(engine) as session:
        assert session.scalars(select(AttemptCount.key_hash)).one() != "a", "only a hash is stored"
    clock.now += 80.0 + CLEANED_EVERY_S
    assert edges[1].take("b") == 0.0
    with read_only(engine) as session:
        assert session.scalar(select(func.count()).select_from(AttemptCount)) == 1


@in_databases
def test_failed_sign_ins_count_at_every_edge(counting):
    own, strangers = Limit(1, 1e6), Limit(3, 1e6)
    edges = [limits(partial(counting, clock=Clock()), 6, own=own, strangers=strangers) for _ in range(2)]
    for number in range(4):
        edges[number % 2].attempt("a@b", "10.0.0.1")
    for number, edge in enumerate(edges):
        with pytest.raises(TooManyAttempts):
            edge.attempt("a@b", "10.0.0.1")
        edge.attempt("a@b", f"10.0.{number}.2")
        with pytest.raises(TooManyAttempts):
            edges[1 - number].attempt("a@b", f"10.0.{number}.2")
    edges[0].attempt("a@b", "10.0.0.2", "a browser that is known")
    tried = [edges[number].attempt(f"{number}@c", "10.0.0.1") for number in range(2)]
    with pytest.raises(TooManyAttempts):
        edges[0].attempt("another@c", "10.0.0.1")
    tried[1].succeeded()
    edges[0].attempt("another@c", "10.0.0.1")


TWO, ONE = Limit(2, 1e6), Limit(1, 1e6)


def limits(counting, address, own=TWO, strangers=ONE):
    return SignInLimits(Limit(4, 1e6), Limit(address, 1e6), counting, own_tries=own, strangers=strangers)


@everywhere
def test_success_takes_its_attempt_back(counting):
    one = limits(partial(counting, clock=Clock()), 100)
    for _ in range(50):
        one.attempt("a@b", "10.0.0.1").succeeded()
    for _ in range(2):
        one.attempt("a@b", "10.0.0.1")
        one.attempt("a@b", "10.0.0.2")
    one.attempt("a@b", "10.0.0.1")
    for address in ("10.0.0.1", "10.0.0.2"):
        with pytest.raises(TooManyAttempts):
            one.attempt("a@b", address)


def test_one_household_is_one_address():
    one = limits(partial(LeakyCounter, clock=Clock()), 2, own=Limit(1000, 1e6))
    one.attempt("a@b", "2001:db8:1:2::1")
    one.attempt("b@b", "2001:db8:1:2:ffff::1")
    with pytest.raises(TooManyAttempts):
        one.attempt("c@b", "2001:db8:1:2:3:4:5:6")
    one.attempt("c@b", "2001:db8:1:3::1")
    one.attempt("a@b", "10.0.0.1")
    one.attempt("a@b", "::ffff:10.0.0.1")
    with pytest.raises(TooManyAttempts):
        one.attempt("a@b", "10.0.0.1")


def test_an_account_is_protected_and_the_right_password_waits_too(nobody, world, engine):
    with read_only(engine) as session:
        email = session.get(Account, world.accounts["therapist"]).email
    for _ in range(PER_ACCOUNT.capacity):
        assert nobody.post("/api/sign-in", json={"email": email, "password": "guess"}).status_code == 401
    for password in ("guess", PASSWORD):
        answer = nobody.post("/api/sign-in", json={"email": email, "password": password})
        assert (answer.status_code, answer.json()["code"]) == (429, "too_many_attempts")
        assert 0 < int(answer.headers["retry-after"]) <= PER_ACCOUNT.recovery_s
    other = nobody.post("/api/sign-in", json={"email": "someone@else.example", "password": "guess"})
    assert other.status_code == 401


def test_an_unknown_account_is_limited_alike(nobody, world):
    statuses = [
        nobody.post("/api/sign-in", json={"email": "no@body.example", "password": "x"}).status_code
        for _ in range(PER_ACCOUNT.capacity + 1)
    ]
    assert statuses == [401] * PER_ACCOUNT.capacity + [429]


def test_an_address_that_tries_many_accounts_is_stopped(nobody, world):
    statuses = [
        nobody.post("/api/sign-in", json={"email": f"{n}@body.example", "password": "x"}).status_code
        for n in range(PER_ADDRESS.capacity + 1)
    ]
    assert statuses == [401] * PER_ADDRESS.capacity + [429]
