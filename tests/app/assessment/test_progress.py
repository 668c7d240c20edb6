"""Progress and caseload: the statistics by hand, the reasons by example."""

from collections import Counter
from datetime import UTC, date, timedelta

import numpy as np
import pytest

from app.assessment import caseload
from app.assessment.measures import session_values
from app.assessment.practice import Done, adherence
from app.assessment.progress import dose
from app.database.base import new_id, utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Prescription
from app.recordings.models import SessionEvent

from .history import MEASURE, History, reason_declining


@pytest.fixture
def history(engine, world):
    return History(engine, world)


def values_of(history, **arguments):
    with read_only(history.engine) as session:
        return session_values(session, [history.world.patient_id], **arguments)


def test_a_session_is_mean_spread_and_count(history):
    repetitions = [1.0, 1.1, 1.25, 0.95]
    history.session(1, repetitions)
    (value,) = values_of(history)
    assert value.mean == pytest.approx(np.mean(repetitions))
    assert value.spread == pytest.approx(np.std(repetitions, ddof=1))
    assert (value.count, value.unit) == (4, "rad")


def test_the_main_result_counts_not_every_comparison(history):
    motion = history.session(2, [1.0, 1.0])
    with unit_of_work(history.engine) as session:
        history.compare(session, motion, [9.0, 9.0], "other", utc_now())
    (value,) = values_of(history)
    assert value.mean == 1.0


def test_templates_and_other_exercises_stay_apart(history, engine, world):
    from ..conftest import make_exercise

    with unit_of_work(engine) as session:
        other = make_exercise(session, world.clinic_id, "Drink").id
    history.session(3, [1.0, 1.2])
    history.session(2, [7.0, 7.1], purpose="template")
    history.session(1, [3.0, 3.1], exercise_id=other)
    assert [v.mean for v in values_of(history, exercise_id=world.exercise_id)] == [pytest.approx(1.1)]


def test_progress_over_http_names_what_changed_meanwhile(history, therapist, world):
    history.prescribe(5)
    history.session(4, [1.0, 1.1])
    history.session(3, [1.0, 1.1], measure="duration")
    history.session(2, [1.2, 1.3], orientation="marzouk_quaternion_ekf")
    path = f"/api/patients/{world.patient_id}/progress"
    found = therapist.get(path, params={"exercise_id": world.exercise_id}).json()
    assert [measure["measure"] for measure in found["measures"]] == [MEASURE, "duration"], (
        "the main one first"
    )
    main = found["measures"][0]
    assert main["label"] == "Shoulder elevation, range of motion"
    first, last = main["points"]
    assert first["low"] == pytest.approx(1.05 - np.std([1.0, 1.1], ddof=1))
    assert last["orientation"] == "marzouk_quaternion_ekf 2"
    assert {event["kind"] for event in found["events"]} == {"template", "prescription", "estimator"}
    assert therapist.get(path).json()["exercise_id"] == world.exercise_id
    assert therapist.get(path, params={"exercise_id": world.foreign_exercise_id}).status_code == 404


def test_a_template_that_nothing_was_compared_with_marks_no_curve(history, therapist, world):
    history.session(4, [1.0, 1.1])
    unused = History(history.engine, world)
    assert unused.version_id != history.version_id
    found = therapist.get(f"/api/patients/{world.patient_id}/progress").json()
    assert [event["kind"] for event in found["events"]] == ["template"]


def line(client, world):
    rows = client.get("/api/caseload").json()
    (row,) = [row for row in rows if row["patient_id"] == world.patient_id]
    return row


def test_a_line_without_anything(therapist, world):
    row = line(therapist, world)
    assert (row["reason"], row["due"], row["trend"], row["adherence_percent"]) == ("", "", [], None)


@pytest.mark.parametrize(
    ("movement", "said"),
    [
        ("reaching", "3 sets of 10 repetitions, once a week"),
        ("timed_up_and_go", "1 walk, once a week"),
        ("walk", "1 walk, once a week"),
    ],
)
def test_a_walk_is_prescribed_without_repetitions(movement, said):
    assert dose(Prescription(repetitions=10, sets=3, times_per_week=1), movement) == said


def test_a_line_shows_dose_trend_and_adherence(history, therapist, world):
    history.prescribe(14, times_per_week=2)
    for age in (13, 9, 5):
        history.session(age, [1.0 + age / 100, 1.1 + age / 100])
    row = line(therapist, world)
    assert row["due"] == "Reach forward: 10 repetitions, 2 times a week"
    assert row["main_measure"] == "Shoulder elevation, range of motion"
    assert row["trend"] == pytest.approx([1.18, 1.14, 1.10])
    assert all(
        low < value < high
        for low, value, high in zip(row["trend_low"], row["trend"], row["trend_high"], strict=True)
    )
    assert row["adherence_percent"] == pytest.approx(75.0, abs=0.2)
    assert row["reason"] == ""


def reason_link_lost(history):
    history.session(0, state="link_lost")


def reason_not_practising(history):
    history.prescribe(30)
    history.session(20, [1.0, 1.1])


def reason_rarely_practised(history):
    history.prescribe(14, times_per_week=5)
    for age in (13, 6, 2):
        history.session(age, [1.0, 1.1])


def test_the_first_week_is_too_short_to_be_called_rare(history, therapist, world):
    history.prescribe(6, times_per_week=5)
    history.session(5, [1.0, 1.1])
    row = line(therapist, world)
    assert row["adherence_percent"] < 50.0
    assert row["reason"] == ""


def reason_bad_data(history):
    history.session(1, [1.0, 1.1], packets_stored=80, packets_missing=20)


def reason_no_template(history):
    history.prescribe(2, template=False)


def reason_pain(history):
    session_id = history.session(1, [1.0, 1.1])
    with unit_of_work(history.engine) as session:
        session.add(SessionEvent(session_id=session_id, kind="pain", time_s=20.0))


def leaned(value, uncertainty=1.0, unit="deg", measure="compensation:trunk_lean_forward_rad"):
    return {
        "measure": measure,
        "label": "",
        "group": "compensation",
        "value": value,
        "template_value": 4.0 if unit == "deg" else 0.01,
        "unit": unit,
        "uncertainty": uncertainty,
        "count": 4,
    }


def reason_compensation(history):
    history.summary = [leaned(14.0)]
    history.session(1, [1.0, 1.1])


def reason_few_repetitions(history):
    history.prescribe(2)
    history.session(1, [1.0, 1.1], valid_repetitions=4)


@pytest.mark.parametrize(
    ("reason", "arrange"),
    [
        ("pain", reason_pain),
        ("compensation", reason_compensation),
        ("few_repetitions", reason_few_repetitions),
        ("declining", reason_declining),
        ("link_lost", reason_link_lost),
        ("not_practising", reason_not_practising),
        ("rarely_practised", reason_rarely_practised),
        ("bad_data", reason_bad_data),
        ("no_template", reason_no_template),
    ],
)
def test_each_reason_to_look(history, therapist, world, reason, arrange):
    arrange(history)
    row = line(therapist, world)
    assert row["reason"] == reason
    assert row["reason_text"]
    assert (
        row["action"]
        == {
            "pain": "replay",
            "compensation": "replay",
            "few_repetitions": "replay",
            "declining": "progress",
            "link_lost": "open_live",
            "not_practising": "contact",
            "rarely_practised": "contact",
            "bad_data": "replay",
            "no_template": "record_template",
        }[reason]
    )
    assert (row["action_session_id"] is not None) is (row["action"] in {"replay", "open_live"})


@pytest.mark.parametrize(
    ("summary", "said"),
    [
        ([leaned(8.9)], None),
        ([leaned(14.0, uncertainty=12.0)], None),
        ([leaned(14.0, uncertainty=None)], "caseload.compensation_angle"),
        ([leaned(0.06, 0.005, "m", "compensation:shoulder_hike_right_m")], "caseload.compensation_length"),
        ([leaned(0.03, 0.005, "m", "compensation:shoulder_hike_right_m")], None),
        ([leaned(None)], None),
    ],
)
def test_compensation_within_its_uncertainty_is_no_reason(history, therapist, world, summary, said):
    """Ten degrees more known to twelve over root four are no more than chance."""
    history.summary = summary
    history.session(1, [1.0, 1.1])
    row = line(therapist, world)
    assert row["reason"] == ("compensation" if said else "")
    if said:
        assert row["sentences"]["reason_text"]["code"] == said


def test_half_of_the_prescribed_repetitions_are_enough(history, therapist, world):
    history.prescribe(2)
    history.session(1, [1.0, 1.1], valid_repetitions=5)
    assert line(therapist, world)["reason"] == ""


def test_pain_is_pinned_to_the_axis(history, therapist, world):
    reason_pain(history)
    found = therapist.get(f"/api/patients/{world.patient_id}/progress").json()
    assert "pain" in {event["kind"] for event in found["events"]}


def test_each_line_offers_one_action(history, therapist, world):
    assert line(therapist, world)["action"] == "prescribe"
    history.prescribe(1)
    assert line(therapist, world)["action"] == "open"
    session_id = history.session(0, state="recording")
    row = line(therapist, world)
    assert (row["action"], row["action_session_id"]) == ("watch", session_id)


def test_the_most_urgent_reason_wins_and_sorts(history, therapist, world):
    for arrange in (reason_no_template, reason_bad_data, reason_declining):
        arrange(history)
    history.prescribe(2, template=False, patient_id=world.other_patient_id)
    rows = therapist.get("/api/caseload").json()
    assert [row["reason"] for row in rows] == ["declining", "no_template"]


@pytest.mark.parametrize("state", ["calibrating", "ready", "recording", "link_lost"])
def test_an_open_session_stands_beside_the_reason_and_hides_none(history, therapist, world, state):
    reason_declining(history)
    history.prescribe(2, template=False, patient_id=world.other_patient_id)
    history.session(0, state=state, patient_id=world.other_patient_id)
    session_id = history.session(0, state=state)
    rows = therapist.get("/api/caseload").json()
    lost = state == "link_lost"
    assert [row["reason"] for row in rows] == ["declining", "link_lost" if lost else "no_template"]
    assert [row["live_state"] for row in rows] == ["link_lost" if lost else "streaming"] * 2
    assert rows[0]["live_session_id"] == session_id


def test_who_streams_ranks_behind_every_reason(history, therapist, world):
    history.prescribe(2, template=False)
    history.session(0, state="recording", patient_id=world.other_patient_id)
    rows = therapist.get("/api/caseload").json()
    assert [(row["reason"], row["live_state"]) for row in rows] == [("no_template", None), ("", "streaming")]


def test_improvement_and_rest_are_no_reasons(history, therapist, world):
    history.prescribe(30, times_per_week=1)
    for age, mean in zip((12, 11, 10, 9, 8, 8), [1.0, 1.0, 1.0, 1.5, 1.5, 1.5], strict=True):
        history.session(age, [mean - 0.02, mean + 0.02])
    assert line(therapist, world)["reason"] == "", "once a week may rest for two weeks"


def test_a_page_of_the_caseload_works_out_only_its_own_lines_and_the_order(
    history, therapist, world, monkeypatch
):
    counted: Counter[str] = Counter()

    def count(name, size=lambda *_: 1):
        real = getattr(caseload, name)

        def counting(*arguments):
            counted[name] += size(*arguments)
            return real(*arguments)

        monkeypatch.setattr(caseload, name, counting)

    for name in ("adherence", "dose", "band", "pooled_spread"):
        count(name)
    count("done_since", lambda _session, patient_ids, _start: len(patient_ids))
    for patient_id, ages in ((world.patient_id, (5, 4)), (world.other_patient_id, (9, 8, 7))):
        history.prescribe(14, patient_id=patient_id)
        for age in ages:
            history.session(age, [1.0, 1.1], patient_id=patient_id)
    whole = therapist.get("/api/caseload").json()
    assert [len(row["trend"]) for row in whole] in ([2, 3], [3, 2])
    assert counted == {"adherence": 2, "dose": 2, "band": 5, "pooled_spread": 2, "done_since": 2}
    counted.clear()
    page = therapist.get("/api/caseload", params={"limit": 1}).json()
    assert page == whole[:1]
    shown = len(page[0]["trend"])
    # How often somebody practised is a reason to look, so that the order asks for it.
    assert counted == {"adherence": 2, "dose": 1, "band": shown, "pooled_spread": 1, "done_since": 2}


def test_adherence_counts_each_exercise_at_most_in_full():
    now = utc_now()

    def prescription(exercise, **fields):
        return Prescription(
            id=new_id(),
            exercise_id=exercise,
            times_per_week=7,
            starts_at=now - timedelta(days=7),
            ends_at=None,
            **fields,
        )

    daily = [Done(now - timedelta(days=day, hours=1), "a") for day in reversed(range(7))]
    twice = [one for one in daily for _ in range(2)]
    assert adherence([prescription("a")], daily, now, UTC) == 100.0
    assert adherence([prescription("a")], twice, now, UTC) == 100.0
    assert adherence([prescription("a"), prescription("b")], twice, now, UTC) == 50.0
    assert adherence([prescription("a")], [], now, UTC) == 0.0
    assert adherence([], daily, now, UTC) is None
    coming = Prescription(
        id=new_id(), exercise_id="a", times_per_week=7, starts_at=now + timedelta(days=1), ends_at=None
    )
    assert adherence([coming], [], now, UTC) is None


def test_sessions_of_this_week_are_counted_on_prescriptions(history, patient, world):
    history.prescribe(20)
    history.session(0)
    history.session(0, duration_s=0.0)
    history.session(0, recording_start_s=12.0, recording_end_s=12.0)
    history.session(15)
    (row,) = patient.get(f"/api/patients/{world.patient_id}/prescriptions").json()
    assert row["done_this_week"] == 1, "a session that recorded nothing is none"


def test_the_small_curve_is_by_day_over_eight_weeks(history, therapist, world):
    """A busy day is one point: it neither pushes a rise of weeks out of the curve nor makes it flat."""
    noon = (utc_now() - timedelta(days=1)).replace(hour=12)
    history.session_at(noon - timedelta(days=60), [0.1, 0.1])
    for days, mean in ((40, 0.7), (20, 0.8)):
        history.session_at(noon - timedelta(days=days), [mean, mean])
    for number in range(12):
        mean = 1.0 if number % 2 else 1.1
        history.session_at(noon + timedelta(minutes=10 * number), [mean, mean])
    row = line(therapist, world)
    assert row["trend"] == pytest.approx([0.7, 0.8, 1.05])
    assert [date.fromisoformat(day) for day in row["trend_days"]] == [
        (noon - timedelta(days=days)).date() for days in (40, 20, 0)
    ]
    assert row["trend_high"][-1] - row["trend_low"][-1] == pytest.approx(0.1)
