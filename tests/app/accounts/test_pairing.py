"""Pairing codes: one use, minutes, one patient, and no guessing."""

import pytest

from app.accounts.credentials.rate_limit import Limit
from app.accounts.pairing import ALPHABET, LENGTH, LIFE_S, Offer, PairingBook
from app.accounts.schemas import DeviceTokenIn
from app.accounts.subject import Subject
from app.errors import SignInRequired, TooManyAttempts

OFFER = Offer(
    Subject("account", "a", "a", "c", "therapist", None), "p", DeviceTokenIn(label="tablet", days=90)
)


def test_a_code_works_once_however_it_is_typed():
    book = PairingBook()
    code = book.offer(OFFER)
    assert len(code) == LENGTH
    assert set(code) <= set(ALPHABET)
    assert code not in repr(book.__dict__)
    assert book.take(f" {code[:4].lower()}-{code[4:]}", "10.0.0.1") == OFFER
    with pytest.raises(SignInRequired):
        book.take(code, "10.0.0.1")


def test_a_code_is_too_old_after_ten_minutes():
    now_s = 0.0
    book = PairingBook(clock=lambda: now_s)
    early, late = book.offer(OFFER), book.offer(OFFER)
    now_s = LIFE_S - 1.0
    assert book.take(early, "10.0.0.1") == OFFER
    now_s = LIFE_S
    with pytest.raises(SignInRequired):
        book.take(late, "10.0.0.1")


def test_an_address_that_guesses_is_stopped_and_no_other():
    book = PairingBook(per_address=Limit(capacity=3, recovery_s=60.0), clock=lambda: 5.0)
    code = book.offer(OFFER)
    for _ in range(3):
        with pytest.raises(SignInRequired):
            book.take("22222222", "10.0.0.1")
    with pytest.raises(TooManyAttempts):
        book.take(code, "10.0.0.1")
    assert book.take(code, "10.0.0.2") == OFFER


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
