"""Names and dates of birth as people have them and as people mistype them, on page and REST alike."""

from datetime import UTC, datetime, timedelta

import pytest


def add(client, **body):
    return client.post("/api/patients", json={"given_name": "Maria", "family_name": "Silva", **body})


@pytest.mark.parametrize(
    ("given", "family"), [("Suharto", ""), ("", "Suharto"), ("  Anna  Maria ", "de  Boer")]
)
def test_one_name_is_enough_and_blanks_around_are_left_out(therapist, given, family):
    answer = add(therapist, given_name=given, family_name=family)
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert (made["given_name"], made["family_name"]) == (" ".join(given.split()), " ".join(family.split()))


@pytest.mark.parametrize(
    "body",
    [
        {"given_name": "  ", "family_name": " "},
        {"given_name": "", "family_name": "\u2003"},
        {"given_name": "A\u202eB"},
        {"family_name": "A\u2067B"},
        {"given_name": "A\nB"},
        {"given_name": "A\x07B"},
    ],
)
def test_no_name_and_characters_of_no_name_are_refused(therapist, world, body):
    assert add(therapist, **body).status_code == 422
    kept = therapist.get(f"/api/patients/{world.patient_id}").json()
    both = {"given_name": "", "family_name": ""} | body if not any(body.values()) else body
    changed = therapist.patch(f"/api/patients/{world.patient_id}", json=both)
    assert changed.status_code == 422, changed.text
    assert therapist.get(f"/api/patients/{world.patient_id}").json() == kept


@pytest.mark.parametrize(
    ("born", "says"),
    [
        ((datetime.now(UTC) + timedelta(days=3)).date().isoformat(), "future"),
        ("2931-01-01", "2931"),
        ("1850-01-01", "1850"),
    ],
)
def test_a_birth_that_nobody_has_is_refused_with_its_year(therapist, world, born, says):
    for answer in (
        add(therapist, birth_date=born),
        therapist.patch(f"/api/patients/{world.patient_id}", json={"birth_date": born}),
    ):
        assert answer.status_code == 422
        assert says in answer.text


def test_a_second_record_of_one_person_is_asked_about(sign_in, therapist):
    first = add(therapist, birth_date="1960-05-04").json()
    again = add(therapist, given_name="silva", family_name="MARIA ", birth_date="1960-05-04")
    assert again.status_code == 409
    assert again.json()["details"] == {"field": "is_another_person", "patient_id": first["id"]}
    assert add(therapist, birth_date="1960-05-05").status_code == 201
    assert add(therapist, birth_date="1960-05-04", is_another_person=True).status_code == 201
    # Whoever has no right to her does not learn that she is there.
    assert add(sign_in("colleague"), birth_date="1960-05-04").status_code == 201
