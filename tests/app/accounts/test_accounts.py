"""Changing the own password, and administrators changing accounts; refused sign-ins leave a trail without what was
typed."""

import logging

import pytest
from sqlalchemy import select
from starlette.websockets import WebSocketDisconnect

from app.accounts.models import Account, AuditEvent, SignIn
from app.accounts.refusals import MAXIMUM_WAITING, RefusedSignIns
from app.database.unit_of_work import read_only, unit_of_work
from tests.app.conftest import PASSWORD

NEW = "another long password"


@pytest.fixture
def address_of(engine, world):
    def find(name):
        with read_only(engine) as session:
            return session.get_one(Account, world.accounts[name]).email

    return find


@pytest.fixture
def enter(new_client, address_of):
    """Try to sign in as somebody with a password; returns the status."""

    def attempt(name, password):
        return (
            new_client()
            .post("/api/sign-in", json={"email": address_of(name), "password": password})
            .status_code
        )

    return attempt


@pytest.fixture
def events(engine):
    """Return actions and details in the audit trail, oldest first."""

    def read(prefix="account."):
        with read_only(engine) as session:
            rows = session.scalars(select(AuditEvent).order_by(AuditEvent.clinic_id, AuditEvent.number))
            return [
                (row.action, row.resource_id, row.details) for row in rows if row.action.startswith(prefix)
            ]

    return read


def test_a_new_password_ends_every_other_sign_in(sign_in, enter, engine, world, events):
    here, elsewhere, other_person = sign_in("therapist"), sign_in("therapist"), sign_in("reader")
    body = {"old_password": PASSWORD, "new_password": NEW}
    assert here.post("/api/me/password", json=body).status_code == 204
    assert here.get("/api/me").status_code == 200
    assert elsewhere.get("/api/me").status_code == 401
    assert other_person.get("/api/me").status_code == 200
    assert enter("therapist", PASSWORD) == 401
    assert enter("therapist", NEW) == 200
    changed = [event for event in events() if event[0] == "account.password_change"]
    assert changed == [("account.password_change", world.accounts["therapist"], {"sign_ins_ended": 1})]
    with read_only(engine) as session:
        stored = session.scalars(select(AuditEvent.details)).all()
    assert PASSWORD not in str(stored)
    assert NEW not in str(stored)


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"old_password": "wrong", "new_password": NEW}, "old_password"),
        ({"old_password": PASSWORD, "new_password": PASSWORD}, "new_password"),
        ({"old_password": PASSWORD, "new_password": "short"}, "body.new_password"),
    ],
)
def test_a_password_change_that_is_refused_changes_nothing(sign_in, enter, body, field):
    here, elsewhere = sign_in("therapist"), sign_in("therapist")
    answer = here.post("/api/me/password", json=body)
    assert answer.status_code == 422
    details = answer.json()["details"]
    assert details.get("field") == field or details["fields"][0]["field"] == field
    assert body["new_password"] not in answer.text
    assert elsewhere.get("/api/me").status_code == 200
    assert enter("therapist", PASSWORD) == 200


def test_guessing_the_present_password_is_limited_like_signing_in(sign_in):
    here = sign_in("therapist")
    body = {"old_password": "guess", "new_password": NEW}
    statuses = [here.post("/api/me/password", json=body).status_code for _ in range(10)]
    assert statuses == [422] * 8 + [429] * 2


def test_a_password_change_needs_the_csrf_token(sign_in):
    here = sign_in("therapist")
    del here.headers["X-CSRF-Token"]
    answer = here.post("/api/me/password", json={"old_password": PASSWORD, "new_password": NEW})
    assert (answer.status_code, answer.json()["code"]) == (403, "not_allowed")


def test_an_account_is_switched_off_and_on(sign_in, enter, world, events):
    administrator, therapist = sign_in("administrator"), sign_in("therapist")
    path = f"/api/accounts/{world.accounts['therapist']}"
    answer = administrator.patch(path, json={"is_active": False})
    assert (answer.status_code, answer.json()["is_active"]) == (200, False)
    assert therapist.get("/api/me").status_code == 401
    assert enter("therapist", PASSWORD) == 401
    assert administrator.patch(path, json={"is_active": False}).status_code == 200, (
        "saying it twice is no event"
    )
    assert administrator.patch(path, json={"is_active": True, "display_name": "Dr Therapist"}).json() == {
        "id": world.accounts["therapist"],
        "display_name": "Dr Therapist",
        "email": answer.json()["email"],
        "role": "therapist",
        "is_active": True,
        "has_second_factor": False,
    }
    assert therapist.get("/api/me").status_code == 401, "the ended session does not come back"
    assert enter("therapist", PASSWORD) == 200
    actions = [event[0] for event in events() if not event[0].startswith("account.sign_in")]
    assert actions == ["account.switch_off", "account.rename", "account.switch_on"]


def drain(socket, received):
    while True:
        received.append(socket.receive_json())


def test_an_open_socket_ends_when_its_account_is_switched_off(sign_in, world, therapist, monkeypatch):
    monkeypatch.setattr("app.live.service.CHECK_EVERY_S", 0.05)
    body = {"patient_id": world.patient_id, "placements": ["upper_arm_right"]}
    session_id = therapist.post("/api/sessions", json=body).json()["id"]
    with therapist.websocket_connect(f"/ws/live/{session_id}") as socket:
        assert socket.receive_json()["type"] == "layout"
        path = f"/api/accounts/{world.accounts['therapist']}"
        assert sign_in("administrator").patch(path, json={"is_active": False}).status_code == 200
        received = []
        with pytest.raises(WebSocketDisconnect):
            drain(socket, received)
        assert received[-1]["code"] == "sign_in_required"


def test_a_forgotten_password_is_replaced_by_an_administrator(sign_in, enter, world, events):
    therapist = sign_in("therapist")
    path = f"/api/accounts/{world.accounts['therapist']}"
    assert sign_in("administrator").patch(path, json={"password": NEW}).status_code == 200
    assert therapist.get("/api/me").status_code == 401
    assert (enter("therapist", PASSWORD), enter("therapist", NEW)) == (401, 200)
    assert "account.password_reset" in [event[0] for event in events()]


def test_administrators_cannot_lock_themselves_out(sign_in, world, enter):
    administrator = sign_in("administrator")
    path = f"/api/accounts/{world.accounts['administrator']}"
    for body in ({"is_active": False}, {"password": NEW}):
        assert administrator.patch(path, json=body).status_code == 409
    assert administrator.patch(path, json={"display_name": "Chief"}).status_code == 200
    assert enter("administrator", PASSWORD) == 200


def test_only_administrators_of_the_clinic_change_accounts(sign_in, world):
    path = f"/api/accounts/{world.accounts['therapist']}"
    for name, status in [
        ("therapist", 403),
        ("patient", 403),
        ("integrator", 403),
        ("foreign_administrator", 404),
    ]:
        assert sign_in(name).patch(path, json={"is_active": False}).status_code == status, name
    assert sign_in("administrator").patch(f"/api/accounts/{'0' * 32}", json={}).status_code == 404


# --- refused sign-ins ----------------------------------------------------------------------------------------------


def test_refused_sign_ins_are_in_the_trail_without_the_address(
    enter, world, engine, events, services, caplog
):
    with unit_of_work(engine) as session:
        session.get_one(Account, world.accounts["former"]).is_active = False
    for name, password in [("therapist", "wrong"), ("former", PASSWORD), ("patient", "wrong")]:
        assert enter(name, password) == 401
    services.get(RefusedSignIns).settle()
    wrong, switched_off = {"reason": "wrong password"}, {"reason": "switched off"}
    assert events() == [
        ("account.sign_in_refused", world.accounts["therapist"], wrong),
        ("account.sign_in_refused", world.accounts["former"], switched_off),
        ("account.sign_in_refused", world.accounts["patient"], wrong),
    ]
    with read_only(engine) as session:
        rows = session.scalars(select(AuditEvent)).all()
        assert [row.patient_id for row in rows] == [None, None, world.patient_id], "the patient can see it"
        assert "example" not in str([vars(row) for row in rows])
    assert "example" not in caplog.text


def test_an_unknown_address_is_in_the_log_as_a_fingerprint(nobody, services, events, caplog):
    caplog.set_level(logging.WARNING, "telemotion.sign_in")
    for address in ("ghost@example.org", " Ghost@Example.org", "other@example.org"):
        nobody.post("/api/sign-in", json={"email": address, "password": "wrong"})
    services.get(RefusedSignIns).settle()
    said = [record.getMessage() for record in caplog.records if record.name == "telemotion.sign_in"]
    assert len(said) == 3
    assert said[0] == said[1] != said[2], "the same address can be recognised"
    assert "ghost" not in caplog.text.lower()
    assert events() == []


def test_a_flood_of_refusals_is_counted_and_not_kept(services, caplog):
    refused = services.get(RefusedSignIns)
    caplog.set_level(logging.WARNING, "telemotion.sign_in")
    held = refused._lock
    with held:
        refused._waiting = MAXIMUM_WAITING
    for _ in range(5):
        refused.note("ghost@example.org")
    with held:
        refused._waiting = 0
    refused.note("ghost@example.org")
    refused.settle()
    assert "5 refused sign-ins were not noted one by one" in caplog.text


def test_a_refused_password_change_is_noted_too(sign_in, services, events, world):
    here = sign_in("therapist")
    here.post("/api/me/password", json={"old_password": "wrong", "new_password": NEW})
    services.get(RefusedSignIns).settle()
    assert ("account.sign_in_refused", world.accounts["therapist"], {"reason": "wrong password"}) in events()


def test_nothing_of_a_refused_sign_in_is_kept_as_a_sign_in(enter, engine):
    enter("therapist", "wrong")
    with read_only(engine) as session:
        assert session.scalars(select(SignIn)).all() == []
