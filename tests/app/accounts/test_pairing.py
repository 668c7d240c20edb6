"""Pairing codes: one use, minutes, one patient, and no guessing."""

from functools import partial

import pytest
from sqlalchemy import select, update

from app.accounts.credentials.rate_limit import LeakyCounter, Limit
from app.accounts.credentials.stored_limit import StoredCounter
from app.accounts.credentials.tickets import account_subject
from app.accounts.models import Account, PairingCode
from app.accounts.pairing import ALPHABET, LENGTH, LIFE, PER_PATIENT, Offer, PairingBook
from app.accounts.schemas import DeviceTokenIn
from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.errors import SignInRequired, TooManyAttempts


@pytest.fixture
def offer(engine, world):
    with unit_of_work(engine) as session:
        giver = account_subject(session.get(Account, world.accounts["therapist"]))
    return Offer(giver, world.patient_id, DeviceTokenIn(label="tablet", days=30))


def given(engine, book, offer):
    with unit_of_work(engine) as session:
        return book.offer(session, offer)[0]


def taken(engine, book, code, address="10.0.0.1"):
    with unit_of_work(engine) as session:
        return book.take(session, code, address)


def test_a_code_works_once_at_any_edge_however_it_is_typed(engine, settings, offer):
    book, of_another_edge = PairingBook(settings), PairingBook(settings)
    code = given(engine, book, offer)
    assert len(code) == LENGTH
    assert set(code) <= set(ALPHABET)
    assert taken(engine, of_another_edge, f" {code[:4].lower()}-{code[4:]}") == offer
    for one in (book, of_another_edge):
        with pytest.raises(SignInRequired):
            taken(engine, one, code)


def test_what_is_stored_of_a_code_needs_the_key_of_the_service(engine, settings, offer):
    code = given(engine, PairingBook(settings), offer)
    with unit_of_work(engine) as session:
        assert code not in repr(session.execute(select(PairingCode.__table__)).all())
    other = settings.model_copy(update={"secret_key": type(settings.secret_key)("another" * 8)})
    with pytest.raises(SignInRequired):
        taken(engine, PairingBook(other), code)
    assert taken(engine, PairingBook(settings), code) == offer


def test_a_code_is_too_old_after_ten_minutes(engine, settings, offer):
    book = PairingBook(settings)
    early, late = given(engine, book, offer), given(engine, book, offer)
    with unit_of_work(engine) as session:
        for row in session.scalars(select(PairingCode)):
            assert abs(row.expires_at - utc_now() - LIFE).total_seconds() < 60.0
    assert taken(engine, book, early) == offer
    with unit_of_work(engine) as session:
        session.execute(update(PairingCode).values(expires_at=utc_now()))
    with pytest.raises(SignInRequired):
        taken(engine, book, late)
    given(engine, book, offer)
    with unit_of_work(engine) as session:
        assert len(session.scalars(select(PairingCode)).all()) == 1, "one that expired is deleted"


def test_the_oldest_codes_of_a_patient_make_room(engine, settings, offer):
    book = PairingBook(settings)
    codes = [given(engine, book, offer) for _ in range(PER_PATIENT + 1)]
    with pytest.raises(SignInRequired):
        taken(engine, book, codes[0])
    assert [taken(engine, book, one) for one in codes[1:]] == [offer] * PER_PATIENT


def test_an_address_that_guesses_is_stopped_and_no_other(engine, settings, offer):
    limit = Limit(capacity=3, recovery_s=60.0)
    book = PairingBook(settings, limit, partial(LeakyCounter, clock=lambda: 5.0))
    code = given(engine, book, offer)
    for _ in range(3):
        with pytest.raises(SignInRequired):
            taken(engine, book, "22222222")
    with pytest.raises(TooManyAttempts):
        taken(engine, book, code)
    assert taken(engine, book, code, "10.0.0.2") == offer


def test_wrong_codes_count_at_every_edge_and_a_right_one_does_not(engine, settings, offer):
    counting = partial(StoredCounter, engine=engine, settings=settings, clock=lambda: 5.0)
    edges = [PairingBook(settings, Limit(capacity=3, recovery_s=60.0), counting) for _ in range(2)]
    for number in range(10):
        assert taken(engine, edges[number % 2], given(engine, edges[0], offer)) == offer
    for edge in (edges[0], edges[1], edges[0]):
        with pytest.raises(SignInRequired):
            taken(engine, edge, "22222222")
    code = given(engine, edges[0], offer)
    for edge in edges:
        with pytest.raises(TooManyAttempts):
            taken(engine, edge, code)
    assert taken(engine, edges[1], code, "10.0.0.2") == offer


def test_a_gateway_gets_a_token_of_this_patient(patient, new_client, world):
    path = f"/api/patients/{world.patient_id}/pairing-codes"
    made = patient.post(path, json={"label": "tablet", "days": 30})
    assert made.status_code == 201, made.text
    gateway = new_client()
    paired = gateway.post("/api/devices/pair", json={"code": made.json()["code"]})
    assert paired.status_code == 200, paired.text
    assert gateway.post("/api/devices/pair", json={"code": made.json()["code"]}).status_code == 401
    gateway.headers["Authorization"] = f"Bearer {paired.json()['token']}"
    assert gateway.post("/api/devices/next-session").json()["code"] == "no_open_session"
    tokens = patient.get(f"/api/patients/{world.patient_id}/device-tokens").json()
    assert [one["label"] for one in tokens] == ["tablet"]


def test_who_lost_the_right_meanwhile_pairs_nothing(therapist, sign_in, new_client, world):
    code = therapist.post(f"/api/patients/{world.patient_id}/pairing-codes", json={"label": "t"}).json()[
        "code"
    ]
    administrator = sign_in("administrator")
    off = administrator.patch(f"/api/accounts/{world.accounts['therapist']}", json={"is_active": False})
    assert off.status_code == 200, off.text
    assert new_client().post("/api/devices/pair", json={"code": code}).status_code == 401
