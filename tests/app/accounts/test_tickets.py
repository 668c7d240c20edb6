"""Tickets: one use, thirty seconds, one purpose, one session."""

import threading
from dataclasses import replace
from datetime import timedelta

import pytest
from sqlalchemy import delete, select, update

from app.accounts.credentials.sign_in import create_sign_in
from app.accounts.credentials.tickets import is_open, issue_ticket, redeem_ticket
from app.accounts.models import Account, DeviceToken, SignIn, Ticket
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import SignInRequired

SESSION = "5" * 32


@pytest.fixture
def issue(engine, world):
    def make(subject=None, purpose="live"):
        with unit_of_work(engine) as session:
            token, _ = issue_ticket(session, subject or world.subjects["patient"], purpose, SESSION)
        return token

    return make


def redeem(engine, token, purpose="live", session_id=SESSION):
    with unit_of_work(engine) as session:
        return redeem_ticket(session, token, purpose, session_id)


def test_a_ticket_says_who_and_where_once(engine, issue, world):
    token = issue()
    redeemed = redeem(engine, token)
    assert redeemed.subject == world.subjects["patient"]
    assert redeemed.session_id == SESSION
    with pytest.raises(SignInRequired):
        redeem(engine, token)
    with read_only(engine) as session:
        assert session.scalars(select(Ticket.token_hash)).one() != token


def test_looking_at_a_ticket_does_not_use_it(engine, issue):
    def looked(token, purpose="live"):
        with read_only(engine) as session:
            return is_open(session, token, purpose)

    token = issue()
    assert looked(token)
    assert not looked(token, "ingest")
    assert not looked("made up")
    redeem(engine, token)
    assert not looked(token)
    late = issue()
    with unit_of_work(engine) as session:
        session.execute(update(Ticket).values(expires_at=utc_now() - timedelta(milliseconds=1)))
    assert not looked(late)


def test_a_ticket_is_for_its_purpose_and_session_only(engine, issue):
    for purpose, session_id in [("ingest", SESSION), ("viewer", SESSION), ("live", "6" * 32)]:
        with pytest.raises(SignInRequired):
            redeem(engine, issue(), purpose, session_id)
    with pytest.raises(SignInRequired):
        redeem(engine, "made up")


def test_a_ticket_ends_after_thirty_seconds(engine, issue):
    token = issue()
    with read_only(engine) as session:
        left = session.scalars(select(Ticket.expires_at)).one() - utc_now()
    assert timedelta(seconds=25) < left <= timedelta(seconds=30)
    with unit_of_work(engine) as session:
        session.execute(update(Ticket).values(expires_at=utc_now() - timedelta(milliseconds=1)))
    with pytest.raises(SignInRequired):
        redeem(engine, token)


def test_of_many_at_once_one_gets_in(engine, issue):
    token = issue()
    results = []

    def attempt():
        try:
            results.append(redeem(engine, token).session_id)
        except SignInRequired:
            results.append(None)

    threads = [threading.Thread(target=attempt) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(results, key=str) == [SESSION] + [None] * 7


def test_who_lost_the_right_meanwhile_stays_out(engine, issue, world, device_token):
    account_ticket = issue()
    device_token(world.patient_id)
    with read_only(engine) as session:
        device_id = session.scalars(select(DeviceToken.id)).one()
    device = Subject("device", device_id, None, world.clinic_id, "device", world.patient_id)
    device_ticket, other_ticket = issue(device, "ingest"), issue(device, "ingest")
    assert redeem(engine, other_ticket, "ingest").subject == device
    with unit_of_work(engine) as session:
        session.get(DeviceToken, device_id).revoked_at = utc_now()
        session.get(Account, world.accounts["patient"]).is_active = False
    for token, purpose in [(account_ticket, "live"), (device_ticket, "ingest")]:
        with pytest.raises(SignInRequired):
            redeem(engine, token, purpose)


def test_a_ticket_is_worth_nothing_after_the_browser_session_that_asked_for_it(
    engine, issue, world, settings
):
    with unit_of_work(engine) as session:
        _, row = create_sign_in(session, settings, world.accounts["patient"], "tests")
    patient = replace(world.subjects["patient"], sign_in_id=row.id)
    assert redeem(engine, issue(patient)).subject.sign_in_id == row.id
    late = issue(patient)
    with unit_of_work(engine) as session:
        session.execute(delete(SignIn))
    with pytest.raises(SignInRequired):
        redeem(engine, late)
