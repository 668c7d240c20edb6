"""The past is judged by the dose that held then, and a session that pain ended is said, not silently done."""

from datetime import timedelta

import pytest

from app.assessment import practice
from app.assessment.practice import Done, adherence, share_out
from app.database.base import new_id, utc_now
from app.database.unit_of_work import unit_of_work
from app.exercises.doses import dose_on, doses_of, lasting
from app.exercises.models import PrescriptionChange
from app.recordings.models import SessionEvent
from app.time_zones import UTC

from ..history import History
from ..test_practice import given, prescriptions, record, utc


def changed(prescription, number, at, **before):
    return PrescriptionChange(
        id=new_id(), prescription_id=prescription.id, number=number, created_at=utc(at), before=before
    )


def test_each_day_has_the_dose_that_held_on_it() -> None:
    one = given("2026-06-01T00:00", 2)
    one.repetitions, one.sets, one.days, one.times = 20, 1, [], []
    changes = [
        changed(one, 2, "2026-06-15T00:00", times_per_week=7),
        changed(one, 1, "2026-06-08T00:00", repetitions=10, times_per_week=4),
        changed(one, 3, "2026-06-20T00:00", question="no part of the dose"),
    ]
    doses = doses_of(one, changes)
    assert [(each.start.day, each.repetitions, each.times_per_week) for each in doses] == [
        (1, 10, 4),
        (8, 20, 7),
        (15, 20, 2),
    ]
    assert dose_on(doses, utc("2026-06-14T23:59")).times_per_week == 7
    assert dose_on(doses, utc("2026-05-01T00:00")).times_per_week == 4
    slip = [
        *changes,
        changed(one, 4, "2026-06-20T00:00", times_per_week=2),
        changed(one, 5, "2026-06-20T00:05", times_per_week=9),
    ]
    assert [each.times_per_week for each in doses_of(one, slip)] == [4, 7, 2, 9, 2]
    assert [each.times_per_week for each in lasting(doses_of(one, slip))] == [4, 7, 2, 2], (
        "mended after minutes"
    )
    early = [changed(one, 1, "2026-05-20T00:00", times_per_week=5)]
    assert [each.times_per_week for each in doses_of(one, early)] == [2], "changed before it began"


def test_a_new_dose_makes_no_past_week_better_or_worse() -> None:
    """Two weeks of seven a week, all done; then once a week. And twice a week, all done; then daily, for a day."""
    one = given("2026-06-01T00:00", 1)
    daily = [Done(utc(f"2026-06-{day:02}T10:00"), "reach") for day in range(1, 8)]
    history = {one.id: doses_of(one, [changed(one, 1, "2026-06-15T00:00", times_per_week=7)])}
    now = utc("2026-06-15T00:00")
    assert adherence([one], daily, now, UTC, history) == 50.0
    assert adherence([one], daily, now, UTC) == 100.0, "what the new dose alone would say of it"
    more = given("2026-06-01T00:00", 7)
    twice = [Done(utc(f"2026-06-{day:02}T10:00"), "reach") for day in (1, 4, 8, 11)]
    history = {more.id: doses_of(more, [changed(more, 1, "2026-06-14T23:00", times_per_week=2)])}
    assert adherence([more], twice, now, UTC, history) == pytest.approx(99.0, abs=1.0)
    assert adherence([more], twice, now, UTC) == pytest.approx(28.6, abs=0.1)


def test_a_week_is_full_by_the_dose_of_that_week() -> None:
    older, newer = given("2026-06-01T00:00", 1), given("2026-06-02T00:00", 3)
    history = {older.id: doses_of(older, [changed(older, 1, "2026-06-15T00:00", times_per_week=3)])}
    done = [Done(utc(f"2026-06-{day:02}T10:00"), "reach") for day in (8, 9, 10)]
    shared = share_out([older, newer], done, UTC, history=history)
    assert [len(shared[one.id]) for one in (older, newer)] == [3, 0]


@pytest.fixture
def history(engine, world):
    return History(engine, world)


@pytest.fixture
def now(monkeypatch):
    monkeypatch.setattr(practice, "utc_now", lambda: utc("2026-06-17T12:00"))


def pressed(history, session_id, *events):
    with unit_of_work(history.engine) as session:
        for kind, time_s in events:
            session.add(SessionEvent(session_id=session_id, kind=kind, time_s=time_s))


def test_a_session_that_pain_ended_is_said_in_the_week(history, sign_in, world, now) -> None:
    therapist = sign_in("therapist")
    history.prescribe_at(utc("2026-06-01T00:00"), times_per_week=3)

    def week():
        (row,) = prescriptions(therapist, world)
        return row["done_this_week"], row["pain_stops_this_week"]

    record(history, "2026-06-15T10:00", 8, 30.0)
    assert week() == (1, 0)
    # Stopped, then gone on: not ended by pain.
    went_on = record(history, "2026-06-16T10:00", 8, 30.0)
    pressed(history, went_on, ("pain", 10.0), ("guidance_resume", 14.0))
    assert week() == (2, 0)
    ended = record(history, "2026-06-17T09:00", 3, 12.0)
    pressed(history, ended, ("guidance_resume", 5.0), ("pain", 20.0))
    assert week() == (3, 1), "counts, and is said"
    # Before anything valid was done: it does not count, and is said.
    at_once = record(history, "2026-06-17T10:00", 0, 0.0)
    pressed(history, at_once, ("pain", 2.0))
    assert week() == (3, 2)
    last_week = record(history, "2026-06-10T10:00", 8, 30.0)
    pressed(history, last_week, ("pain", 2.0))
    assert week() == (3, 2)


def test_caseload_and_report_say_it_beside_the_share(history, sign_in, world) -> None:
    therapist = sign_in("therapist")
    history.prescribe(10, times_per_week=3)
    pressed(history, history.session(2, [1.0, 1.1], valid_repetitions=4, active_s=9.0), ("pain", 8.0))
    pressed(history, history.session(40, [1.0, 1.1], valid_repetitions=4, active_s=9.0), ("pain", 8.0))
    row = next(one for one in therapist.get("/api/caseload").json() if one["patient_id"] == world.patient_id)
    assert row["pain_stops"] == 1
    path = f"/api/patients/{world.patient_id}/course"
    course = therapist.get(path, params={"exercise_id": world.exercise_id}).json()
    assert course["pain_stops"] == 1
    assert course["adherence_percent"] == row["adherence_percent"]


def test_a_changed_dose_stands_in_progress_where_it_began_to_hold(history, sign_in, world) -> None:
    therapist = sign_in("therapist")
    path = f"/api/patients/{world.patient_id}/prescriptions"
    begun = (utc_now() - timedelta(days=20)).isoformat()
    body = {"exercise_id": world.exercise_id, "repetitions": 10, "times_per_week": 2, "starts_at": begun}
    made = therapist.post(path, json=body).json()
    for days_ago in (12, 5):
        history.session(days_ago, [1.0, 1.1])
    change = {"number": 1, "repetitions": 25, "times_per_week": 7}
    assert therapist.patch(f"/api/prescriptions/{made['id']}", json=change).status_code == 200
    found = therapist.get(
        f"/api/patients/{world.patient_id}/progress", params={"exercise_id": world.exercise_id}
    ).json()
    events = [one for one in found["events"] if one["kind"] == "prescription"]
    counts = [one["sentences"]["text"]["params"]["dose"]["params"] for one in events]
    assert [(one["amount"]["params"]["count"], one["count"]) for one in counts] == [(10, 2), (25, 7)]
    assert events[0]["at"] < events[1]["at"]
    course = therapist.get(
        f"/api/patients/{world.patient_id}/course", params={"exercise_id": world.exercise_id}
    ).json()
    assert len(course["prescribed"]) == 2


def test_a_raised_dose_makes_no_past_session_too_short(history, sign_in, world) -> None:
    therapist = sign_in("therapist")
    path = f"/api/patients/{world.patient_id}/prescriptions"
    begun = (utc_now() - timedelta(days=6)).isoformat()
    made = therapist.post(
        path, json={"exercise_id": world.exercise_id, "repetitions": 10, "starts_at": begun}
    ).json()
    history.session(1, [1.0, 1.1], valid_repetitions=9, active_s=30.0)
    change = {"number": 1, "repetitions": 40}
    assert therapist.patch(f"/api/prescriptions/{made['id']}", json=change).status_code == 200
    row = next(one for one in therapist.get("/api/caseload").json() if one["patient_id"] == world.patient_id)
    assert row["reason"] != "few_repetitions", row["reason_text"]
