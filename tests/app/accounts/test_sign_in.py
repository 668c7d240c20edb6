"""Signing in, staying signed in and signing out."""

from datetime import timedelta

import pytest
from sqlalchemy import select, update

from app.accounts.credentials.sign_in import create_sign_in, find_sign_in
from app.accounts.credentials.tokens import hash_token
from app.accounts.models import Account, AuditEvent, SignIn
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from tests.app.conftest import BASE_URL

PASSWORD = "a long enough password"


@pytest.fixture
def email(world, engine):
    with read_only(engine) as session:
        return session.get(Account, world.accounts["therapist"]).email


def test_sign_in_gives_a_cookie_that_scripts_cannot_read(nobody, email, engine):
    response = nobody.post("/api/sign-in", json={"email": email.upper() + " ", "password": PASSWORD})
    assert response.status_code == 200
    cookie = response.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=lax" in cookie
    assert "; secure" not in cookie, "plain http on this machine: a Secure cookie would never come back"
    me = nobody.get("/api/me").json()
    assert me["email"] == email
    assert me["csrf_token"] == response.json()["csrf_token"]
    with read_only(engine) as session:
        row = session.scalars(select(SignIn)).one()
        token = nobody.cookies["telemotion_session"]
        assert row.token_hash == hash_token(token)
        assert token not in (row.id, row.csrf_token)
        assert session.scalars(select(AuditEvent.action)).all() == ["account.sign_in"]


def test_every_wrong_pair_gets_the_same_answer(nobody, email, engine, world):
    with unit_of_work(engine) as session:
        session.get(Account, world.accounts["reader"]).is_active = False
        inactive = session.get(Account, world.accounts["reader"]).email
    answers = [
        nobody.post("/api/sign-in", json={"email": address, "password": password})
        for address, password in [
            (email, "wrong"),
            ("nobody@example.org", "wrong"),
            (inactive, PASSWORD),
        ]
    ]
    assert {answer.status_code for answer in answers} == {401}
    # All but the number of the request.
    contents = [{**answer.json(), "request_id": ""} for answer in answers]
    assert contents[0] == contents[1] == contents[2]
    assert "set-cookie" not in answers[0].headers


def test_sign_out_ends_the_session_on_the_server(therapist, engine):
    assert therapist.get("/api/me").status_code == 200
    token = therapist.cookies["telemotion_session"]
    assert therapist.post("/api/sign-out").status_code == 204
    therapist.cookies.set("telemotion_session", token)
    assert therapist.get("/api/me").status_code == 401
    with read_only(engine) as session:
        assert session.scalars(select(SignIn)).all() == []


@pytest.mark.parametrize(
    "change",
    [
        {"expires_at": utc_now() - timedelta(seconds=1)},
        {"last_seen_at": utc_now() - timedelta(minutes=61)},
    ],
    ids=["absolute", "idle"],
)
def test_sessions_end_by_age_and_by_idleness(therapist, engine, change):
    with unit_of_work(engine) as session:
        session.execute(update(SignIn).values(**change))
    assert therapist.get("/api/me").status_code == 401


def test_use_keeps_a_session_alive(therapist, engine):
    with unit_of_work(engine) as session:
        session.execute(update(SignIn).values(last_seen_at=utc_now() - timedelta(minutes=50)))
    assert therapist.get("/api/me").status_code == 200
    with read_only(engine) as session:
        assert utc_now() - session.scalars(select(SignIn.last_seen_at)).one() < timedelta(minutes=1)


@pytest.mark.parametrize(("minutes", "noted_after_s"), [(1, 16), (2, 31), (60, 61)])
def test_use_is_noted_long_before_a_short_limit_ends_the_session(
    engine, settings, world, minutes, noted_after_s
):
    short = settings.model_copy(update={"sign_in_idle_minutes": minutes})
    with unit_of_work(engine) as session:
        token, row = create_sign_in(session, short, world.accounts["therapist"], "tests")
        for seconds, is_noted in ((noted_after_s - 3, False), (noted_after_s, True)):
            row.last_seen_at = utc_now() - timedelta(seconds=seconds)
            session.flush()
            assert find_sign_in(session, short, token).needs_touch == is_noted


def test_an_account_that_is_switched_off_is_out_at_once(therapist, engine, world):
    with unit_of_work(engine) as session:
        session.get(Account, world.accounts["therapist"]).is_active = False
    assert therapist.get("/api/me").status_code == 401


def test_signing_in_again_ends_the_session_that_the_browser_had(nobody, email, engine):
    for _ in range(2):
        nobody.post("/api/sign-in", json={"email": email, "password": PASSWORD})
    with read_only(engine) as session:
        assert len(session.scalars(select(SignIn)).all()) == 1


def test_a_password_never_comes_back_in_an_error(nobody):
    response = nobody.post("/api/sign-in", json={"email": "a@b.example", "password": "x" * 201})
    assert response.status_code == 422
    assert response.json()["code"] == "invalid_input"
    assert response.json()["details"]["fields"][0]["field"] == "body.password"
    assert "xxx" not in response.text


def test_everybody_chooses_the_language_of_their_own_account(nobody, email, engine):
    answer = nobody.post("/api/sign-in", json={"email": email, "password": PASSWORD}).json()
    headers = {"Origin": BASE_URL, "X-CSRF-Token": answer["csrf_token"]}
    for locale in ("de", ""):
        assert nobody.patch("/api/me", json={"locale": locale}, headers=headers).status_code == 204
        assert nobody.get("/api/me").json()["locale"] == locale
    assert nobody.patch("/api/me", json={"locale": "xx"}, headers=headers).status_code == 422
    with read_only(engine) as session:
        others = session.scalars(select(Account.locale).where(Account.email != email)).all()
    assert "de" not in others
