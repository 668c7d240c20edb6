"""Limits on failed sign-ins."""

import pytest

from app.accounts.credentials.rate_limit import PER_ACCOUNT, PER_ADDRESS, LeakyCounter, Limit, SignInLimits
from app.accounts.models import Account
from app.database.unit_of_work import read_only
from app.errors import TooManyAttempts

PASSWORD = "a long enough password"


class Clock:
    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


def test_levels_fill_leak_and_tell_when_to_come_back():
    clock = Clock()
    counter = LeakyCounter(Limit(capacity=3, recovery_s=10.0), clock=clock)
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


def test_success_takes_its_attempt_back():
    limits = SignInLimits(Limit(2, 1e6), Limit(100, 1e6), clock=Clock())
    for _ in range(50):
        limits.attempt("a@b", "10.0.0.1")
        limits.succeeded("a@b", "10.0.0.1")
    limits.attempt("a@b", "10.0.0.1")
    limits.attempt("a@b", "10.0.0.2")
    with pytest.raises(TooManyAttempts):
        limits.attempt("a@b", "10.0.0.3")


def test_one_household_is_one_address():
    limits = SignInLimits(Limit(1000, 1e6), Limit(2, 1e6), clock=Clock())
    limits.attempt("a@b", "2001:db8:1:2::1")
    limits.attempt("b@b", "2001:db8:1:2:ffff::1")
    with pytest.raises(TooManyAttempts):
        limits.attempt("c@b", "2001:db8:1:2:3:4:5:6")
    limits.attempt("c@b", "2001:db8:1:3::1")
    limits.attempt("a@b", "10.0.0.1")
    limits.attempt("a@b", "::ffff:10.0.0.1")
    with pytest.raises(TooManyAttempts):
        limits.attempt("a@b", "10.0.0.1")


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
