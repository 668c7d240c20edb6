"""What counts as practised, in which week, and for which prescription: by hand-counted examples."""

from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest
from sqlalchemy import select

from app.accounts.models import AuditEvent
from app.assessment import practice
from app.assessment.practice import Done, adherence, share_out
from app.database.base import new_id
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Prescription
from app.recordings.models import SessionEvent
from app.time_zones import is_time_zone, time_zone, week_start

from .history import History

OSLO, AUCKLAND = ZoneInfo("Europe/Oslo"), ZoneInfo("Pacific/Auckland")


def utc(text: str) -> datetime:
    return datetime.fromisoformat(text).replace(tzinfo=UTC)


def given(began: str, times_per_week: int = 3, exercise: str = "reach", ends: str | None = None):
    return Prescription(
        id=new_id(),
        exercise_id=exercise,
        times_per_week=times_per_week,
        starts_at=utc(began),
        ends_at=None if ends is None else utc(ends),
    )


@pytest.mark.parametrize(
    ("moment", "zone", "monday"),
    [
        # An ordinary Sunday night: 23:59 in Oslo is the old week, a minute later the new one.
        ("2026-06-14T21:59", OSLO, "2026-06-07T22:00"),
        ("2026-06-14T22:00", OSLO, "2026-06-14T22:00"),
        # The same moment is Monday morning in Auckland, and was since noon.
        ("2026-06-14T11:59", AUCKLAND, "2026-06-07T12:00"),
        ("2026-06-14T21:59", AUCKLAND, "2026-06-14T12:00"),
        # Oslo puts the clock forward on Sunday 29 March 2026 and back on 25 October: weeks of 167 and 169 hours.
        ("2026-03-29T21:59", OSLO, "2026-03-22T23:00"),
        ("2026-03-29T22:00", OSLO, "2026-03-29T22:00"),
        ("2026-10-25T22:59", OSLO, "2026-10-18T22:00"),
        ("2026-10-25T23:00", OSLO, "2026-10-25T23:00"),
        # Auckland puts it back on 5 April and forward on 27 September.
        ("2026-04-05T11:59", AUCKLAND, "2026-03-29T11:00"),
        ("2026-04-05T12:00", AUCKLAND, "2026-04-05T12:00"),
        ("2026-09-27T10:59", AUCKLAND, "2026-09-20T12:00"),
        ("2026-09-27T11:00", AUCKLAND, "2026-09-27T11:00"),
        ("2026-06-14T23:59", UTC, "2026-06-08T00:00"),
    ],
)
def test_a_week_begins_on_monday_by_the_clocks_of_the_place(moment, zone, monday) -> None:
    assert week_start(utc(moment), zone) == utc(monday)


def test_zones_go_by_the_names_of_places() -> None:
    assert all(map(is_time_zone, ("UTC", "Europe/Oslo", "America/Argentina/Buenos_Aires")))
    assert not any(map(is_time_zone, ("", "Oslo", "europe/oslo", "../etc/passwd", "localtime", "CEST")))
    assert time_zone("UTC") is UTC
    assert time_zone("Europe/Not_Known_Yet") is UTC, "set on a machine that knows more"


def shared_counts(prescriptions, done, zone=UTC, **how) -> list[int]:
    shared = share_out(prescriptions, done, zone, **how)
    return [len(shared[one.id]) for one in prescriptions]


def test_two_prescriptions_of_one_exercise_never_count_a_session_twice() -> None:
    older, newer = given("2026-06-01T00:00", 3), given("2026-06-02T00:00", 2)
    days = [Done(utc(f"2026-06-{day:02}T10:00"), "reach") for day in range(8, 15)]
    for made in range(8):
        first, second = shared_counts([older, newer], days[:made])
        assert first + second == made
        assert (first, second) == [(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2), (4, 2), (5, 2)][made]


def test_a_session_counts_for_what_it_was_begun_from() -> None:
    older, newer = given("2026-06-01T00:00"), given("2026-06-02T00:00")
    at = utc("2026-06-08T10:00")
    assert shared_counts([older, newer], [Done(at, "reach", newer.id)]) == [0, 1]
    assert shared_counts([older, newer], [Done(at, "reach", new_id())]) == [1, 0], "of one that has ended"
    assert shared_counts([older, newer], [Done(utc("2026-06-01T10:00"), "reach", newer.id)]) == [1, 0], (
        "not begun yet"
    )
    assert shared_counts([older, newer], [Done(at, "drink", older.id)]) == [0, 0]


def test_a_full_week_is_full_by_the_clocks_of_the_place() -> None:
    """Sunday 23:30 and Monday 0:30 in Oslo are one day of one week in UTC."""
    older, newer = given("2026-06-01T00:00", 1), given("2026-06-02T00:00", 1)
    done = [Done(utc("2026-06-14T21:30"), "reach"), Done(utc("2026-06-14T22:30"), "reach")]
    assert shared_counts([older, newer], done, OSLO) == [2, 0]
    assert shared_counts([older, newer], done, UTC) == [1, 1]


def test_the_first_week_takes_what_was_done_before() -> None:
    one = given("2026-06-10T12:00", ends="2026-06-20T00:00")
    days = [Done(utc(f"2026-06-{day:02}T10:00"), "reach") for day in (7, 8, 10, 11, 21)]
    assert shared_counts([one], days) == [1]
    assert shared_counts([one], days, from_monday=True) == [3]


def test_adherence_of_two_prescriptions_shares_the_sessions() -> None:
    now = utc("2026-06-15T00:00")
    both = [given("2026-06-01T00:00", 2), given("2026-06-01T00:00", 2)]
    done = [Done(utc(f"2026-06-{day:02}T10:00"), "reach") for day in (1, 3, 8, 10)]
    assert adherence(both[:1], done, now, UTC) == 100.0
    assert adherence(both, done, now, UTC) == 50.0
    many = [Done(utc(f"2026-06-{day:02}T{hour}:00"), "reach") for day in range(8, 15) for hour in (10, 16)]
    assert adherence(both[:1], many, now, UTC) == 100.0, "thirteen are no more than all"


@pytest.fixture
def history(engine, world):
    return History(engine, world)


@pytest.fixture
def now(monkeypatch):
    """Stop the clock of what was practised: Monday 15 June 2026, 8 o'clock in Oslo, Sunday evening in New York."""
    monkeypatch.setattr(practice, "utc_now", lambda: utc("2026-06-15T00:30"))
    return utc("2026-06-15T00:30")


def record(history, at: str, repetitions=None, active_s=None, **fields):
    return history.session_at(utc(at), valid_repetitions=repetitions, active_s=active_s, **fields)


def prescriptions(client, world):
    return client.get(f"/api/patients/{world.patient_id}/prescriptions").json()


def shown(row) -> tuple[int, int, float]:
    return row["done_this_week"], row["repetitions_this_week"], row["active_s_this_week"]


def test_only_what_was_valid_counts(history, patient, world, now) -> None:
    history.prescribe_at(utc("2026-06-01T00:00"), times_per_week=3)
    record(history, "2026-06-15T00:10", 12, 90.0)
    record(history, "2026-06-15T00:11", 12, 80.0)
    record(history, "2026-06-15T00:12", 0, 0.0)
    record(history, "2026-06-15T00:13", 0, 45.0)
    record(history, "2026-06-15T00:14", 5, 30.0, state="failed")
    record(history, "2026-06-15T00:15", None, None, state="recording")
    record(history, "2026-06-15T00:16", 5, 30.0, purpose="template")
    record(history, "2026-06-14T23:59", 5, 30.0)
    (row,) = prescriptions(patient, world)
    assert shown(row) == (3, 24, 215.0)
    # Analysed before this was measured: whatever recorded something.
    record(history, "2026-06-15T00:17", None, None)
    record(history, "2026-06-15T00:18", None, None, duration_s=0.0)
    assert prescriptions(patient, world)[0]["done_this_week"] == 4


def test_the_week_is_that_of_the_clinic(history, patient, sign_in, engine, world, now) -> None:
    history.prescribe_at(utc("2026-06-01T00:00"))
    record(history, "2026-06-15T00:10", 1, 1.0)
    record(history, "2026-06-14T23:59", 10, 10.0)
    record(history, "2026-06-14T21:59", 100, 100.0)
    record(history, "2026-06-08T03:59", 1000, 1000.0)
    assert shown(prescriptions(patient, world)[0]) == (1, 1, 1.0)
    administrator = sign_in("administrator")
    for zone, expected in [("Europe/Oslo", (2, 11, 11.0)), ("America/New_York", (3, 111, 111.0))]:
        answer = administrator.patch("/api/clinic", json={"time_zone": zone})
        assert (answer.status_code, answer.json()["time_zone"]) == (200, zone)
        assert shown(prescriptions(patient, world)[0]) == expected, zone
    with read_only(engine) as session:
        noted = select(AuditEvent.details).where(AuditEvent.action == "clinic.time_zone")
        assert session.scalars(noted).all() == [
            {"from": None, "to": "Europe/Oslo"},
            {"from": "Europe/Oslo", "to": "America/New_York"},
        ]


def test_the_setting_stands_in_for_a_clinic_that_said_nothing(
    history, patient, therapist, sign_in, services, world, now
) -> None:
    history.prescribe_at(utc("2026-06-01T00:00"))
    record(history, "2026-06-14T23:59", 10, 10.0)
    assert shown(prescriptions(patient, world)[0]) == (0, 0, 0.0)
    object.__setattr__(services.settings, "time_zone", "Europe/Oslo")
    assert shown(prescriptions(patient, world)[0]) == (1, 10, 10.0)
    found = therapist.get("/api/clinic").json()
    assert (found["time_zone"], found["is_time_zone_set"]) == ("Europe/Oslo", False)
    assert therapist.patch("/api/clinic", json={"time_zone": "UTC"}).status_code == 403
    refused = sign_in("administrator").patch("/api/clinic", json={"time_zone": "Mars/Olympus"})
    assert (refused.status_code, refused.json()["details"]["field"]) == (422, "time_zone")


def test_a_second_prescription_of_an_exercise_is_said_and_shares(history, therapist, world, now) -> None:
    path = f"/api/patients/{world.patient_id}/prescriptions"
    history.prescribe_at(utc("2026-06-01T00:00"), times_per_week=2)
    for minute in range(3):
        record(history, f"2026-06-15T00:1{minute}", 10, 60.0)
    assert [one["is_twice"] for one in prescriptions(therapist, world)] == [False]
    body = {"exercise_id": world.exercise_id, "times_per_week": 2, "starts_at": "2026-06-15T00:00:00Z"}
    made = therapist.post(path, json=body).json()
    assert (made["is_twice"], shown(made)) == (True, (1, 10, 60.0))
    rows = prescriptions(therapist, world)
    assert [one["is_twice"] for one in rows] == [True, True]
    assert [shown(one) for one in rows] == [(2, 20, 120.0), (1, 10, 60.0)]
    assert therapist.delete(f"/api/prescriptions/{rows[0]['id']}").status_code == 204
    (left,) = prescriptions(therapist, world)
    assert (left["is_twice"], shown(left)) == (False, (3, 30, 180.0))


def test_one_that_follows_another_is_no_duplicate(history, therapist, world) -> None:
    path = f"/api/patients/{world.patient_id}/prescriptions"
    start = datetime.now(UTC)
    change = start + timedelta(days=7)
    for begins, ends in [(start, change), (change, None)]:
        body = {"exercise_id": world.exercise_id, "starts_at": begins.isoformat()}
        body |= {} if ends is None else {"ends_at": ends.isoformat()}
        assert therapist.post(path, json=body).json()["is_twice"] is False
    past = {"starts_at": "2020-01-01T00:00:00Z", "ends_at": "2020-02-01T00:00:00Z"}
    answer = therapist.post(path, json={"exercise_id": world.exercise_id} | past)
    assert (answer.status_code, answer.json()["is_twice"]) == (201, False)


def test_adherence_of_named_days_goes_by_the_days_that_are_over() -> None:
    one = given("2026-06-01T00:00", 3)
    one.days, one.times = [1, 3, 5], []
    done = [Done(utc("2026-06-01T10:00"), "reach"), Done(utc("2026-06-03T10:00"), "reach")]
    # Thursday 4 June: due were Monday and Wednesday; on Friday evening still only those, for Friday is not over.
    assert adherence([one], done, utc("2026-06-04T08:00"), UTC) == 100.0
    assert adherence([one], done, utc("2026-06-05T22:00"), UTC) == 100.0
    assert adherence([one], done, utc("2026-06-06T08:00"), UTC) == 66.7
    # In Auckland it is Saturday since Friday noon.
    assert adherence([one], done, utc("2026-06-05T22:00"), AUCKLAND) == 66.7
    one.times = ["09:00", "17:00"]
    assert adherence([one], done, utc("2026-06-06T08:00"), UTC) == 33.3


def test_days_times_and_limits_are_prescribed(history, therapist, patient, world, now) -> None:
    path = f"/api/patients/{world.patient_id}/prescriptions"
    body = {
        "exercise_id": world.exercise_id,
        "template_id": history.template_id,
        "times_per_week": 28,
        "days": [7, 1, 7],
        "times": ["17:30", "09:00"],
        "tolerance_scale": 1.5,
        "stops": [{"kind": "limit", "channel": "thorax_humerus_right_yxy_elevation", "limit": 1.5}],
        "starts_at": "2026-06-15T00:00:00Z",
    }
    answer = therapist.post(path, json=body)
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert (made["days"], made["times"], made["times_per_week"]) == ([1, 7], ["09:00", "17:30"], 4)
    assert (made["tolerance_scale"], made["stops"][0]["limit"]) == (1.5, 1.5)
    # 00:30 on Monday.
    record(history, "2026-06-15T00:10", 12, 90.0, prescription_id=made["id"])
    (row,) = prescriptions(patient, world)
    assert (row["is_due_today"], row["done_today"]) == (True, 1)
    later = {**body, "starts_at": "2026-06-15T00:20:00Z"}
    tuesday = therapist.post(path, json={**later, "days": [2]}).json()
    assert (tuesday["is_due_today"], tuesday["done_today"], tuesday["is_twice"]) == (False, 0, True)
    anyday = therapist.post(path, json={**later, "days": [], "times": ["09:00"]}).json()
    assert (anyday["is_due_today"], anyday["times_per_week"]) == (True, 28)
    for wrong in (
        {"days": [0]},
        {"times": ["24:00"]},
        {"tolerance_scale": 9.0},
        {"stops": [{"kind": "limit", "channel": "thorax_humerus_left_yxy_elevation", "limit": 1.0}]},
        {"stops": [{"kind": "time", "limit": 0.0}]},
    ):
        assert therapist.post(path, json={**body, **wrong}).status_code == 422, wrong


def test_today_is_done_when_its_goals_are_and_says_what_is_left(history, patient, engine, world, now) -> None:
    """Ten are prescribed: what was counted live counts at once, else what the analysis found; without a template
    nothing counts them, and a session is a time."""
    row = history.prescribe_at(utc("2026-06-01T00:00"))

    def today() -> tuple[int, int, int]:
        (found,) = prescriptions(patient, world)
        return found["goal"], found["goal_done"], found["done_today"]

    def prescribe_again(**change) -> None:
        with unit_of_work(engine) as session:
            for name, value in change.items():
                setattr(session.get_one(Prescription, row.id), name, value)

    record(history, "2026-06-14T23:59", 9, 60.0, prescription_id=row.id)
    assert today() == (10, 0, 0), "that was yesterday"
    record(history, "2026-06-15T00:10", 4, 30.0, prescription_id=row.id)
    assert today() == (10, 4, 0)
    seen = record(history, "2026-06-15T00:15", None, None, state="closing", prescription_id=row.id)
    with unit_of_work(engine) as session:
        for number, kind in enumerate(["valid", "partial", "valid", "valid", "wrong_shape"]):
            session.add(
                SessionEvent(session_id=seen, time_s=number, kind="repetition", details={"kind": kind})
            )
    assert today() == (10, 7, 0)
    record(history, "2026-06-15T00:20", 8, 60.0, prescription_id=row.id)
    assert today() == (10, 15, 1)
    prescribe_again(days=[1], times=["09:00", "17:00"])
    assert today() == (10, 5, 1), "the second time is begun"
    prescribe_again(repetitions=3, sets=2)
    assert today() == (6, 9, 2)
    prescribe_again(template_id=None)
    assert today() == (0, 0, 2), "sessions that were analysed"
