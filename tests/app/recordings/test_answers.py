"""What a patient says after an exercise: stored once for each session, read by those who may."""

import json
import zipfile
from io import BytesIO
from typing import Any

import pytest
from sqlalchemy import Engine

from app.database.unit_of_work import read_only
from app.recordings.models import SessionAnswers


@pytest.fixture
def session_id(sign_in: Any, world: Any) -> str:
    therapist = sign_in("therapist")
    prescription = therapist.post(
        f"/api/patients/{world.patient_id}/prescriptions",
        json={"exercise_id": world.exercise_id, "question": " Did the shoulder feel stable? "},
    )
    assert prescription.status_code == 201, prescription.text
    assert prescription.json()["question"] == "Did the shoulder feel stable?"
    made = therapist.post(
        "/api/sessions",
        json={
            "patient_id": world.patient_id,
            "exercise_id": world.exercise_id,
            "prescription_id": prescription.json()["id"],
            "placements": ["sternum", "upper_arm_right"],
        },
    )
    assert made.status_code == 201, made.text
    return str(made.json()["id"])


def test_a_patient_answers_and_the_therapist_reads(sign_in: Any, session_id: str) -> None:
    path = f"/api/sessions/{session_id}/answers"
    before = sign_in("therapist").get(path).json()
    assert before["question"] == "Did the shoulder feel stable?"
    assert before["pain"] is before["answered_at"] is None
    patient = sign_in("patient")
    assert patient.put(path, json={"pain": 2, "effort": 6}).is_success
    said = patient.put(path, json={"pain": 3, "effort": 6, "third": 8, "note": "Better than on Monday."})
    assert said.is_success, said.text
    read = sign_in("therapist").get(path).json()
    assert (read["pain"], read["effort"], read["third"]) == (3, 6, 8)
    assert read["note"] == "Better than on Monday."
    assert read["answered_at"] is not None
    assert sign_in("reader").put(path, json={"pain": 1}).status_code == 403
    assert sign_in("other_patient").get(path).status_code == 404


@pytest.mark.parametrize("wrong", [{"pain": 11}, {"effort": -1}, {"pain": "much"}, {"mood": 3}])
def test_what_is_no_answer_is_refused(sign_in: Any, session_id: str, wrong: dict[str, Any]) -> None:
    assert sign_in("patient").put(f"/api/sessions/{session_id}/answers", json=wrong).status_code == 422


def test_the_export_holds_what_was_said(sign_in: Any, world: Any, session_id: str) -> None:
    sign_in("patient").put(f"/api/sessions/{session_id}/answers", json={"pain": 4})
    answer = sign_in("therapist").get(f"/api/patients/{world.patient_id}/export")
    assert answer.is_success, answer.text
    with zipfile.ZipFile(BytesIO(answer.content)) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith("/answers.json"))
        assert json.loads(archive.read(name))["pain"] == 4


def test_the_most_pain_that_was_said_is_kept(engine: Engine, sign_in: Any, session_id: str) -> None:
    """Saying it again does not take it back, and a telephone that sends the same again says nothing new."""
    patient, path = sign_in("patient"), f"/api/sessions/{session_id}/answers"
    first = patient.put(path, json={"pain": 7, "note": "It pulls."}).json()
    assert patient.put(path, json={"pain": 7, "note": "It pulls."}).json() == first
    assert patient.put(path, json={"pain": 1}).json()["answered_at"] > first["answered_at"]
    with read_only(engine) as session:
        stored = session.get_one(SessionAnswers, session_id)
        assert (stored.pain, stored.most_pain) == (1, 7)
