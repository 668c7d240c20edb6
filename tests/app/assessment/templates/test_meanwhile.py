"""Two therapists at one record: the second save is told who and when, and drops nothing in silence."""

from datetime import datetime
from typing import Any

import pytest
from sqlalchemy import Engine, select

from app.accounts.models import AuditEvent
from app.database.unit_of_work import read_only

from .drawing import store_template


@pytest.fixture
def stored(engine: Engine, world: Any) -> tuple[str, str]:
    return store_template(engine, world, world.patient_id)


def draw(client: Any, stored: tuple[str, str], based_on: str, design: dict[str, Any], reason: str) -> Any:
    body = {"based_on": based_on, "design": design, "reason": reason}
    return client.post(f"/api/templates/{stored[0]}/versions", json=body)


def test_a_second_drawing_on_the_same_version_is_a_conflict(therapist: Any, stored: tuple[str, str]) -> None:
    stopping = {"stops": [{"kind": "time", "limit": 120.0}]}
    naming = {"phases": [{"name": "Reach", "start": 0.0, "end": 0.5}]}
    first = draw(therapist, stored, stored[1], stopping, "two minutes")
    assert first.status_code == 201, first.text
    second = draw(therapist, stored, stored[1], naming, "named")
    assert second.status_code == 409
    error = second.json()
    assert error["sentences"]["message"]["code"] == "template.changed_meanwhile"
    said = error["sentences"]["message"]["params"]
    assert (said["name"], said["number"], said["reason"]) == (first.json()["made_by"], 2, "two minutes")
    # The time is data: the page writes it by its own clock, and the sentence names none of another zone.
    at = datetime.fromisoformat(error["details"]["changed_at"])
    assert at == datetime.fromisoformat(first.json()["created_at"])
    assert "UTC" not in error["message"]
    assert str(at.year) not in error["message"]
    assert error["details"]["newest"] == first.json()["id"]
    # On top of what was saved meanwhile both are there.
    both = draw(therapist, stored, first.json()["id"], {**stopping, **naming}, "named")
    assert both.status_code == 201
    assert both.json()["number"] == 3


def test_a_prescription_is_changed_with_its_history(
    therapist: Any, world: Any, engine: Engine, stored: tuple[str, str]
) -> None:
    path = f"/api/patients/{world.patient_id}/prescriptions"
    made = therapist.post(path, json={"exercise_id": world.exercise_id, "repetitions": 10}).json()
    assert (made["number"], made["changes"]) == (1, [])
    one = f"/api/prescriptions/{made['id']}"
    body = {"number": 1, "repetitions": 12, "sets": 3, "template_id": stored[0], "days": [1, 3]}
    changed = therapist.patch(one, json=body)
    assert changed.status_code == 200, changed.text
    now = changed.json()
    assert (now["repetitions"], now["sets"], now["template_id"], now["number"]) == (12, 3, stored[0], 2)
    assert (now["times_per_week"], now["starts_at"]) == (2, made["starts_at"])
    (change,) = now["changes"]
    assert change["changed_by"]
    assert change["before"]["repetitions"] == 10
    assert change["before"]["template_id"] is None
    # What is not named stays; what does not differ is no change.
    same = therapist.patch(one, json={"number": 2, "repetitions": 12}).json()
    assert (same["number"], same["sets"]) == (2, 3)
    assert therapist.get(path).json() == [same]
    with read_only(engine) as session:
        audited = session.scalars(select(AuditEvent).where(AuditEvent.action == "prescription.change")).all()
    assert [one.details["fields"] for one in audited] == [
        ["days", "repetitions", "sets", "template_id", "times_per_week"]
    ]


def test_a_second_change_of_the_same_prescription_is_a_conflict(therapist: Any, world: Any) -> None:
    path = f"/api/patients/{world.patient_id}/prescriptions"
    made = therapist.post(path, json={"exercise_id": world.exercise_id}).json()
    one = f"/api/prescriptions/{made['id']}"
    assert therapist.patch(one, json={"number": 1, "repetitions": 20}).status_code == 200
    second = therapist.patch(one, json={"number": 1, "sets": 2})
    assert second.status_code == 409
    assert second.json()["sentences"]["message"]["code"] == "edited.meanwhile"
    details = second.json()["details"]
    assert details["changed_by"]
    at = datetime.fromisoformat(details["changed_at"])
    assert at.tzinfo is not None
    assert str(at.year) not in second.json()["message"]
    (listed,) = therapist.get(path).json()
    assert (listed["repetitions"], listed["sets"]) == (20, 1)


def test_what_has_ended_is_not_changed(therapist: Any, patient: Any, world: Any) -> None:
    path = f"/api/patients/{world.patient_id}/prescriptions"
    made = therapist.post(path, json={"exercise_id": world.exercise_id}).json()
    one = f"/api/prescriptions/{made['id']}"
    assert patient.patch(one, json={"number": 1, "repetitions": 1}).status_code == 403
    assert therapist.delete(one).status_code == 204
    assert therapist.patch(one, json={"number": 1, "repetitions": 1}).status_code == 409
