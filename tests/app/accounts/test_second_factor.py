"""The second factor, passwords that must be changed, and passwords that are refused."""

import time
from datetime import timedelta

import pytest
from sqlalchemy import select, update

from app.accounts.credentials import totp
from app.accounts.credentials.password_rules import check_password
from app.accounts.credentials.rate_limit import PER_ACCOUNT
from app.accounts.models import Account, AuditEvent, SignIn, Ticket
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput

PASSWORD = "a long enough password"
NEW = "four plain green words"


@pytest.fixture
def email(world, engine) -> str:
    with read_only(engine) as session:
        return session.get(Account, world.accounts["therapist"]).email


@pytest.fixture
def enrolled(therapist) -> tuple[str, list[str]]:
    """Secret and recovery codes of the therapist, whose telephone has just shown the code of the step before."""
    secret = therapist.post("/api/me/second-factor", json={"password": PASSWORD}).json()["secret"]
    # A step that ends while the code is on its way makes it too old.
    left_s = totp.STEP_S - time.time() % totp.STEP_S
    if left_s < 2.0:
        time.sleep(left_s)
    code = totp.code_at(secret, int(time.time()) // totp.STEP_S - 1)
    answer = therapist.post("/api/me/second-factor/confirm", json={"code": code})
    assert answer.status_code == 200
    return secret, answer.json()["codes"]


def enter(client, email: str, code: str | None = None):
    return client.post("/api/sign-in", json={"email": email, "password": PASSWORD, "code": code})


@pytest.mark.parametrize(("at_s", "code"), [(59, "287082"), (1111111109, "081804"), (20000000000, "353130")])
def test_codes_are_those_of_the_standard(at_s: int, code: str) -> None:
    """RFC 6238, appendix B, SHA-1, the last six digits."""
    secret = "GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ"
    assert totp.code_at(secret, at_s // totp.STEP_S) == code
    assert totp.step_of(secret, f"{code[:3]} {code[3:]}", at_s) == at_s // totp.STEP_S
    assert totp.step_of(secret, code, at_s + 2 * totp.STEP_S) is None


def test_a_code_is_asked_for_and_good_once(new_client, email, enrolled) -> None:
    secret, _ = enrolled
    asked = enter(new_client(), email)
    assert (asked.status_code, asked.json()["code"]) == (401, "code_required")
    code = totp.code_at(secret, int(time.time()) // totp.STEP_S)
    assert enter(new_client(), email, code).status_code == 200
    again = enter(new_client(), email, code)
    assert (again.status_code, again.json()["code"]) == (401, "sign_in_required")


def test_a_recovery_code_is_good_once(new_client, email, enrolled, therapist, engine) -> None:
    _, codes = enrolled
    assert len(set(codes)) == 10
    assert enter(new_client(), email, codes[3].upper()).status_code == 200
    assert enter(new_client(), email, codes[3]).status_code == 401
    assert therapist.get("/api/me/second-factor").json()["recovery_codes_left"] == 9
    with read_only(engine) as session:
        actions = session.scalars(select(AuditEvent.action).order_by(AuditEvent.number)).all()
    assert actions.count("account.recovery_code") == 1
    assert actions.index("account.recovery_code") > actions.index("account.second_factor_on")


def test_an_open_browser_alone_enrols_nothing(therapist, engine, world) -> None:
    for body in ({}, {"password": "wrong"}):
        assert therapist.post("/api/me/second-factor", json=body).status_code == 422
    with read_only(engine) as session:
        assert session.get(Account, world.accounts["therapist"]).totp_secret is None
    assert therapist.post("/api/me/second-factor/confirm", json={"code": "000000"}).status_code == 409
    for _ in range(PER_ACCOUNT.capacity):
        answer = therapist.post("/api/me/second-factor", json={"password": "wrong"})
    assert answer.status_code == 429


def test_guessing_codes_is_limited(new_client, email, enrolled) -> None:
    statuses = [enter(new_client(), email, "000000").status_code for _ in range(PER_ACCOUNT.capacity + 1)]
    assert statuses == [401] * PER_ACCOUNT.capacity + [429]


def test_it_is_turned_off_with_the_password_or_by_an_administrator(
    new_client, email, enrolled, therapist, sign_in, world
) -> None:
    assert therapist.post("/api/me/second-factor", json={"password": PASSWORD}).status_code == 409
    assert therapist.post("/api/me/second-factor/remove", json={"password": "wrong"}).status_code == 422
    assert therapist.post("/api/me/second-factor/remove", json={"password": PASSWORD}).status_code == 204
    assert enter(new_client(), email).status_code == 200
    secret = therapist.post("/api/me/second-factor", json={"password": PASSWORD}).json()["secret"]
    code = totp.code_at(secret, int(time.time()) // totp.STEP_S)
    assert therapist.post("/api/me/second-factor/confirm", json={"code": code}).status_code == 200
    assert enter(new_client(), email).status_code == 401
    path = f"/api/accounts/{world.accounts['therapist']}"
    assert sign_in("administrator").patch(path, json={"remove_second_factor": True}).status_code == 200
    assert enter(new_client(), email).status_code == 200


def test_a_wrong_code_puts_nothing_in_force(new_client, email, therapist) -> None:
    therapist.post("/api/me/second-factor", json={"password": PASSWORD})
    answer = therapist.post("/api/me/second-factor/confirm", json={"code": "000000"})
    assert answer.json()["details"]["field"] == "code"
    assert enter(new_client(), email).status_code == 200


def test_an_administrators_password_must_be_changed_first(sign_in, new_client, email, world) -> None:
    path = f"/api/accounts/{world.accounts['therapist']}"
    assert sign_in("administrator").patch(path, json={"password": NEW}).status_code == 200
    client = new_client()
    found = client.post("/api/sign-in", json={"email": email, "password": NEW}).json()
    assert found["must"] == "password"
    client.headers.update({"Origin": "http://127.0.0.1:8000", "X-CSRF-Token": found["csrf_token"]})
    refused = client.get("/api/patients")
    assert (refused.status_code, refused.json()["code"]) == (403, "password_change_required")
    body = {"old_password": NEW, "new_password": "another four plain words"}
    assert client.post("/api/me/password", json=body).status_code == 204
    assert client.get("/api/me").json()["must"] is None
    assert client.get("/api/patients").status_code == 200


def test_staff_can_be_obliged_to_have_one(services, therapist, patient) -> None:
    object.__setattr__(services.settings, "staff_second_factor", "required")
    assert therapist.get("/api/me").json()["must"] == "second_factor"
    refused = therapist.get("/api/patients")
    assert (refused.status_code, refused.json()["code"]) == (403, "second_factor_required")
    assert patient.get("/api/patients").status_code == 200
    secret = therapist.post("/api/me/second-factor", json={"password": PASSWORD}).json()["secret"]
    code = totp.code_at(secret, int(time.time()) // totp.STEP_S)
    assert therapist.post("/api/me/second-factor/confirm", json={"code": code}).status_code == 200
    assert therapist.get("/api/patients").status_code == 200


@pytest.mark.parametrize(
    ("password", "problem"),
    [
        ("short", "shorter"),
        ("aaaaaaaaaa", "repeats"),
        ("abcabcabcabc", "repeats"),
        ("1234567890", "row of letters"),
        ("qwertzuiop", "row of letters"),
        ("0987654321", "row of letters"),
        ("Password123", "most common"),
        ("Telemotion2026", "most common"),
        ("P@ssw0rd1234", "most common"),
        ("Sommer2026!", "most common"),
        ("2026-Winter!", "most common"),
        ("Frühling#2027", "most common"),
        ("$0mmer2026!!", "most common"),
        ("W1llkommen99", "most common"),
        ("Welc0me_2031", "most common"),
        ("HalloWelcome1", "most common"),
        ("MeinPasswort7", "most common"),
        ("Oktober.2026", "most common"),
        ("Kl1n1kPraxis?", "most common"),
        ("ingrid.solberg@clinic.example", "name or e-mail"),
        ("IngridSolberg1", "name or e-mail"),
    ],
)
def test_easy_passwords_are_refused_in_words(password: str, problem: str) -> None:
    with pytest.raises(InvalidInput, match=problem):
        check_password(password, "ingrid.solberg@clinic.example", "Ingrid Solberg")


@pytest.mark.parametrize(
    "password",
    [
        "a long enough password",
        "correct horse battery",
        "Vk7!pq2-Lm9w",
        "demonstration",
        "Sommerregen am See",
        "monday sits on winter",
    ],
)
def test_good_passwords_pass(password: str) -> None:
    check_password(password, "ingrid.solberg@clinic.example", "Ingrid Solberg")


def test_an_open_page_that_nobody_uses_is_signed_out(therapist, engine) -> None:
    """What a live view asks by itself does not count as use; a hand on the mouse does."""
    almost = utc_now() - timedelta(minutes=50)
    with unit_of_work(engine) as session:
        session.execute(update(SignIn).values(last_seen_at=almost))
    assert therapist.get("/api/me", headers={"X-Idle-Seconds": "3000"}).status_code == 200
    with read_only(engine) as session:
        assert session.scalars(select(SignIn.last_seen_at)).one() == almost
    assert therapist.get("/api/me", headers={"X-Idle-Seconds": "5"}).status_code == 200
    with read_only(engine) as session:
        assert session.scalars(select(SignIn.last_seen_at)).one() > almost


def test_tickets_end_with_the_sign_in(therapist, engine, world) -> None:
    with unit_of_work(engine) as session:
        for account, token in (("therapist", "a"), ("reader", "b")):
            session.add(
                Ticket(
                    token_hash=token,
                    purpose="live",
                    account_id=world.accounts[account],
                    session_id="x",
                    expires_at=utc_now() + timedelta(seconds=30),
                )
            )
    assert therapist.post("/api/sign-out").status_code == 204
    with read_only(engine) as session:
        assert session.scalars(select(Ticket.token_hash)).all() == ["b"]


def test_who_lost_the_device_is_signed_out_and_told(
    new_client, email, enrolled, therapist, sign_in, engine, world
) -> None:
    administrator, path = sign_in("administrator"), f"/api/accounts/{world.accounts['therapist']}"
    accounts = {row["id"]: row["has_second_factor"] for row in administrator.get("/api/accounts").json()}
    assert accounts[world.accounts["therapist"]] is True
    assert accounts[world.accounts["administrator"]] is False
    assert {row["has_second_factor"] for row in therapist.get("/api/accounts").json()} == {None}
    assert therapist.patch(path, json={"remove_second_factor": True}).status_code == 403
    foreign = sign_in("foreign_administrator").patch(path, json={"remove_second_factor": True})
    assert foreign.status_code == 404
    assert enter(new_client(), email).json()["code"] == "code_required"
    changed = administrator.patch(path, json={"remove_second_factor": True})
    assert (changed.status_code, changed.json()["has_second_factor"]) == (200, False)
    assert therapist.get("/api/me").status_code == 401
    client = new_client()
    found = enter(client, email).json()
    assert found["second_factor_removed_at"] is not None
    client.headers.update({"Origin": "http://127.0.0.1:8000", "X-CSRF-Token": found["csrf_token"]})
    assert client.get("/api/me").json()["second_factor_removed_at"] == found["second_factor_removed_at"]
    assert client.post("/api/me/second-factor/noted").status_code == 204
    assert client.get("/api/me").json()["second_factor_removed_at"] is None
    with read_only(engine) as session:
        query = select(AuditEvent.subject_id).where(
            AuditEvent.action == "account.second_factor_off",
            AuditEvent.resource_id == world.accounts["therapist"],
        )
        assert session.scalars(query).all() == [world.accounts["administrator"]]
    # Nothing to take away: nobody is signed out, nothing is told.
    assert administrator.patch(path, json={"remove_second_factor": True}).status_code == 200
    assert client.get("/api/me").json()["second_factor_removed_at"] is None


def test_setting_it_up_again_ends_the_notice_and_the_own_one_needs_the_password(
    new_client, email, enrolled, sign_in, world
) -> None:
    administrator = sign_in("administrator")
    path = f"/api/accounts/{world.accounts['therapist']}"
    assert administrator.patch(path, json={"remove_second_factor": True}).status_code == 200
    client = new_client()
    found = enter(client, email).json()
    client.headers.update({"Origin": "http://127.0.0.1:8000", "X-CSRF-Token": found["csrf_token"]})
    secret = client.post("/api/me/second-factor", json={"password": PASSWORD}).json()["secret"]
    code = totp.code_at(secret, int(time.time()) // totp.STEP_S)
    assert client.post("/api/me/second-factor/confirm", json={"code": code}).status_code == 200
    assert client.get("/api/me").json()["second_factor_removed_at"] is None
    own = f"/api/accounts/{world.accounts['administrator']}"
    assert administrator.patch(own, json={"remove_second_factor": True}).status_code == 409
    assert client.post("/api/me/second-factor/remove", json={"password": PASSWORD}).status_code == 204
    assert client.get("/api/me").json()["second_factor_removed_at"] is None, "they did it themselves"
