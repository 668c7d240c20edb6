"""The report of a course of therapy: what was done, first and newest session, words that are never lost."""

import pytest

from app.assessment.course.report import notes_of
from app.database.unit_of_work import read_only

from .history import History

COURSE = "/api/patients/{}/course"
NOTES = "/api/patients/{}/course-notes"


@pytest.fixture
def history(engine, world):
    return History(engine, world)


def course(client, world):
    answer = client.get(COURSE.format(world.patient_id), params={"exercise_id": world.exercise_id})
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_a_course_counts_what_was_valid_and_names_its_ends(history, therapist, world):
    history.prescribe(14, times_per_week=2)
    history.session(13, [1.0, 1.1], valid_repetitions=2, active_s=20.0)
    history.session(9, valid_repetitions=0, active_s=0.0)
    history.session(5, [1.2, 1.3, 1.4], valid_repetitions=3, active_s=31.0)
    history.session(4, [9.0], purpose="template")
    found = course(therapist, world)
    assert (found["session_count"], found["valid_repetitions"], found["active_s"]) == (2, 5, 51.0)
    assert found["prescribed"] == ["10 repetitions, 2 times a week"]
    assert found["adherence_percent"] == pytest.approx(50.0, abs=0.2)
    assert found["first_at"] < found["last_at"]
    assert found["first_comparison_id"] != found["last_comparison_id"]
    assert found["service_version"].count(".") >= 1
    assert found["note"] is None


def test_nothing_done_is_an_empty_course(therapist, world):
    found = course(therapist, world)
    assert (found["session_count"], found["valid_repetitions"]) == (0, 0)
    assert (found["first_at"], found["last_at"], found["first_comparison_id"]) == (None, None, None)


def test_words_replace_earlier_ones_which_stay_stored(therapist, patient, world, engine):
    path = NOTES.format(world.patient_id)
    for text in ("Reaches further.", "Reaches further, without the trunk."):
        answer = therapist.post(path, json={"exercise_id": world.exercise_id, "text": text})
        assert answer.status_code == 201, answer.text
    note = course(patient, world)["note"]
    assert note["text"] == "Reaches further, without the trunk."
    assert note["written_by"]
    assert patient.post(path, json={"exercise_id": world.exercise_id, "text": "x"}).status_code == 403
    foreign = {"exercise_id": world.foreign_exercise_id, "text": "x"}
    assert therapist.post(path, json=foreign).status_code == 404
    with read_only(engine) as session:
        assert [one.text for one in notes_of(session, world.patient_id)] == [
            "Reaches further.",
            "Reaches further, without the trunk.",
        ]
