"""Strangers who guess do not lock the owner out of a browser that has signed in before; guessing stays limited."""

import pytest

from app.accounts.credentials import browsers
from app.accounts.credentials.rate_limit import OWN_TRIES, PER_ACCOUNT, STRANGERS, SignInLimits
from app.accounts.credentials.tokens import hash_token
from app.accounts.models import Account, KnownBrowser
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import TooManyAttempts

PASSWORD = "a long enough password"


@pytest.fixture
def email(world, engine) -> str:
    with read_only(engine) as session:
        return session.get(Account, world.accounts["therapist"]).email


def enter(client, email: str, password: str) -> int:
    return client.post("/api/sign-in", json={"email": email, "password": password}).status_code


def use_up(services, email: str) -> None:
    """A stranger guesses until nothing is left for strangers."""
    limits = services.get(SignInLimits)
    for _ in range(OWN_TRIES.capacity + STRANGERS.capacity):
        limits.attempt(email, "10.0.0.1")
    with pytest.raises(TooManyAttempts):
        limits.attempt(email, "10.0.0.1")


@pytest.mark.parametrize("password", [PASSWORD, "guess"])
def test_a_stranger_elsewhere_keeps_nobody_out_who_signs_in_for_the_first_time(
    new_client, email, services, password
) -> None:
    """New staff, new patients, whoever just got a new password."""
    use_up(services, email)
    statuses = [enter(new_client(), email, password) for _ in range(OWN_TRIES.capacity + 1)]
    assert statuses == ([200] * 4 if password == PASSWORD else [401] * 3 + [429])


def test_eight_wrong_passwords_from_strangers_do_not_lock_a_known_browser_out(
    new_client, email, services
) -> None:
    own, fresh = new_client(), new_client()
    assert enter(own, email, PASSWORD) == 200
    use_up(services, email)
    statuses = [enter(fresh, email, "guess") for _ in range(OWN_TRIES.capacity + 1)]
    assert statuses == [401] * OWN_TRIES.capacity + [429]
    assert enter(fresh, email, PASSWORD) == 429, "who has used up the own tries waits, whatever comes then"
    own.cookies.delete("telemotion_session")
    assert enter(own, email, PASSWORD) == 200


def test_a_known_browser_may_guess_no_more_than_a_stranger(new_client, email) -> None:
    own = new_client()
    assert enter(own, email, PASSWORD) == 200
    statuses = [enter(own, email, "guess") for _ in range(PER_ACCOUNT.capacity + 1)]
    assert statuses == [401] * PER_ACCOUNT.capacity + [429]
    assert enter(new_client(), email, PASSWORD) == 200, "and locks nobody else out"


def test_a_browser_is_known_to_the_accounts_that_signed_in_there(
    new_client, email, world, engine, services
) -> None:
    own = new_client()
    answer = own.post("/api/sign-in", json={"email": email, "password": PASSWORD})
    cookie = next(one for one in answer.headers.get_list("set-cookie") if one.startswith(browsers.COOKIE))
    assert "httponly" in cookie.lower()
    token = own.cookies[browsers.COOKIE]
    with read_only(engine) as session:
        other = session.get(Account, world.accounts["reader"]).email
        assert browsers.known_browser(session, email, token) is not None
        assert browsers.known_browser(session, other, token) is None
        assert session.query(KnownBrowser).filter_by(token_hash=token).count() == 0, "only the hash is stored"
    assert enter(own, other, PASSWORD) == 200
    fresh = own.cookies[browsers.COOKIE]
    with read_only(engine) as session:
        assert browsers.known_browser(session, email, fresh) is not None, (
            "one cookie for all who share the machine"
        )
        assert browsers.known_browser(session, other, fresh) is not None
        assert session.query(KnownBrowser).filter_by(token_hash=hash_token(token)).count() == 0


def test_a_planted_cookie_is_not_taken_over(new_client, email, engine, world) -> None:
    """Neither one that nobody knows nor one by which the attacker's own account is known."""
    with unit_of_work(engine) as session:
        attackers = browsers.remember_browser(session, world.accounts["reader"], None)
    for planted in ("A" * 43, attackers):
        victim = new_client()
        victim.cookies.set(browsers.COOKIE, planted)
        assert enter(victim, email, PASSWORD) == 200
        with read_only(engine) as session:
            assert browsers.known_browser(session, email, planted) is None


def test_a_new_password_forgets_other_browsers_and_an_administrators_all(engine, world, email) -> None:
    account_id = world.accounts["therapist"]
    with unit_of_work(engine) as session:
        here = browsers.remember_browser(session, account_id, None)
        browsers.remember_browser(session, account_id, None)
        browsers.forget_browsers(session, account_id, but=here)
        assert browsers.known_browser(session, email, here) is not None
        assert session.query(KnownBrowser).count() == 1
        for _ in range(browsers.MOST_OF_AN_ACCOUNT + 5):
            browsers.remember_browser(session, account_id, None)
        assert session.query(KnownBrowser).count() == browsers.MOST_OF_AN_ACCOUNT


def test_strangers_do_not_lock_the_own_password_change(sign_in, email, services) -> None:
    use_up(services, email)
    body = {"old_password": PASSWORD, "new_password": "four plain green words"}
    assert sign_in("therapist").post("/api/me/password", json=body).status_code == 204
