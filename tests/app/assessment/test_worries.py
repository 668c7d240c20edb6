"""A worry stays on the caseload until a therapist has marked it as seen; nothing that follows hides it."""

from datetime import timedelta

import pytest
from sqlalchemy import select

from app.accounts.models import AuditEvent
from app.assessment.worries.found import unseen, worries_of
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.patients.models import Grant
from app.recordings.models import DEAD_LINK, SessionAnswers, SessionEvent
from estimators.sentences import say

from .history import History
from .test_progress import leaned


@pytest.fixture
def history(engine, world):
    return History(engine, world)


@pytest.fixture
def therapist(sign_in):
    return sign_in("therapist")


def line(client, world):
    return next(row for row in client.get("/api/caseload").json() if row["patient_id"] == world.patient_id)


def event(history, session_id, kind, time_s=20.0, **more):
    with unit_of_work(history.engine) as session:
        session.add(SessionEvent(session_id=session_id, kind=kind, time_s=time_s, **more))


def pain(history, days_ago=1):
    event(history, session_id := history.session(days_ago, [1.0, 1.1]), "pain")
    return session_id


def stop_rule(history, days_ago=1):
    session_id = history.session(days_ago, [1.0, 1.1])
    details = {"cause": "limit", "value": 2.0, "limit": 1.5}
    event(history, session_id, "guidance_stop", text=say("guided.limit"), details=details)
    return session_id


def dead_link(history, days_ago=1):
    session_id = history.session(days_ago, [1.0, 1.1])
    event(history, session_id, DEAD_LINK, text=say("caseload.dead_link", silence_s=10.0))
    return session_id


def compensation(history, days_ago=1):
    history.summary = [leaned(14.0)]
    session_id = history.session(days_ago, [1.0, 1.1])
    history.summary = []
    return session_id


KINDS = {"pain": pain, "stop": stop_rule, "link_lost": dead_link, "compensation": compensation}


def seen(client, world, *worries):
    named = [{name: one[name] for name in ("session_id", "kind", "known_at")} for one in worries]
    return client.post(f"/api/patients/{world.patient_id}/worries/seen", json={"worries": named})


@pytest.mark.parametrize("kind", KINDS)
def test_what_follows_does_not_hide_a_worry(history, therapist, world, kind):
    """A good session, ten of them, a session that is live now, and a break: it is there until it is marked."""
    session_id = KINDS[kind](history, 20)
    for days_ago in range(19, 9, -1):
        history.session(days_ago, [1.0, 1.1])
    history.session(0, state="recording")
    row = line(therapist, world)
    assert (row["reason"], row["live_state"], row["action"]) == (kind, "streaming", "watch")
    worry = row["worry"]
    assert (worry["session_id"], worry["kind"], row["worry_count"]) == (session_id, kind, 1)
    assert worry["text"]
    assert worry["seen_at"] is worry["seen_by"] is None
    assert row["sentences"]["reason_text"] == worry["sentences"]["text"]

    (marked,) = seen(therapist, world, worry).json()
    assert marked["seen_by"] == "Therapist"
    assert marked["seen_at"]
    row = line(therapist, world)
    assert (row["reason"], row["worry"], row["worry_count"]) == ("", None, 0)
    (listed,) = therapist.get(f"/api/patients/{world.patient_id}/worries").json()
    assert listed == marked


def test_all_are_kept_and_the_gravest_newest_one_is_shown(history, therapist, world):
    older, newer = pain(history, 9), pain(history, 5)
    others = [compensation(history, 4), stop_rule(history, 3), dead_link(history, 2)]
    row = line(therapist, world)
    assert (row["reason"], row["worry"]["session_id"], row["worry_count"]) == ("pain", newer, 5)
    assert (row["action"], row["action_session_id"]) == ("replay", newer)
    path = f"/api/patients/{world.patient_id}/worries"
    assert [one["session_id"] for one in therapist.get(path).json()] == [*others[::-1], newer, older]
    pages = therapist.get(path, params={"limit": 2})
    rest = therapist.get(pages.links["next"]["url"]).json()
    assert [one["session_id"] for one in [*pages.json(), *rest]] == [*others[::-1], newer]

    left = []
    while (row := line(therapist, world))["worry"] is not None:
        left.append((row["worry"]["kind"], row["worry"]["session_id"]))
        assert seen(therapist, world, row["worry"]).is_success
    kinds = ("pain", "pain", "stop", "link_lost", "compensation")
    assert left == list(zip(kinds, (newer, older, others[1], others[2], others[0]), strict=True))


def test_her_words_and_mark_stand_beside_it(history, therapist, sign_in, world):
    session_id = pain(history)
    path = f"/api/sessions/{session_id}/answers"
    therapist_sees = line(therapist, world)["worry"]
    assert (therapist_sees["words"], therapist_sees["sentences"]["text"]["code"]) == ("", "caseload.pain")
    assert sign_in("patient").put(path, json={"pain": 6, "note": "Es zog in der Schulter"}).is_success
    worry = line(therapist, world)["worry"]
    assert worry["words"] == "Es zog in der Schulter"
    assert worry["sentences"]["text"]["code"] == "caseload.pain_marked"

    # What was looked at before her words came is not all of it: the same mark sent again covers the rest.
    assert seen(therapist, world, therapist_sees).json()[0]["seen_at"] is None
    assert line(therapist, world)["worry_count"] == 1
    assert seen(therapist, world, worry).json()[0]["seen_by"] == "Therapist"
    assert line(therapist, world)["worry_count"] == 0


def test_much_pain_stays_where_it_is_said_otherwise_later(history, therapist, sign_in, world):
    session_id = history.session(1, [1.0, 1.1])
    put = sign_in("patient").put
    assert put(f"/api/sessions/{session_id}/answers", json={"pain": 4}).is_success
    assert line(therapist, world)["worry"] is None
    assert put(f"/api/sessions/{session_id}/answers", json={"pain": 7}).is_success
    assert put(f"/api/sessions/{session_id}/answers", json={"pain": 1}).is_success
    worry = line(therapist, world)["worry"]
    assert worry["text"] == "Pain 7 of 10 after the session. Later changed to 1 of 10."
    with unit_of_work(history.engine) as session:
        assert session.get_one(SessionAnswers, session_id).most_pain == 7


def test_who_marked_first_is_shown_to_both(history, therapist, sign_in, world, engine):
    session_id = pain(history)
    worry = line(therapist, world)["worry"]
    colleague = sign_in("colleague")
    assert seen(colleague, world, worry).status_code == 404
    with unit_of_work(engine) as session:
        session.add(
            Grant(
                patient_id=world.patient_id,
                account_id=world.accounts["colleague"],
                level="treat",
                granted_by=world.accounts["therapist"],
                expires_at=None,
                revoked_at=None,
            )
        )
    (first,) = seen(colleague, world, worry).json()
    (second,) = seen(therapist, world, worry).json()
    assert first == second
    assert first["seen_by"] == "Colleague"
    with read_only(engine) as session:
        trail = session.scalars(select(AuditEvent).where(AuditEvent.action == "worry.seen")).all()
    assert [(one.subject_id, one.resource_id, one.details) for one in trail] == [
        (world.accounts["colleague"], session_id, {"kind": "pain"})
    ]


def test_who_may_not_treat_marks_nothing(history, therapist, sign_in, world):
    pain(history)
    worry = line(therapist, world)["worry"]
    for who in ("patient", "reader", "administrator"):
        assert seen(sign_in(who), world, worry).status_code == 403, who
    assert seen(sign_in("other_patient"), world, worry).status_code == 404
    assert line(therapist, world)["worry_count"] == 1
    other = {**worry, "kind": "compensation"}
    assert seen(therapist, world, other).status_code == 404
    assert therapist.get(f"/api/patients/{world.patient_id}/worries").json() == [worry]


def test_what_comes_after_a_mark_is_a_worry_again(history, therapist, world):
    session_id = pain(history, 0)
    assert seen(therapist, world, line(therapist, world)["worry"]).is_success
    event(history, session_id, "pain", 50.0)
    assert line(therapist, world)["worry_count"] == 1
    ahead = {**line(therapist, world)["worry"], "known_at": (utc_now() + timedelta(days=900)).isoformat()}
    assert seen(therapist, world, ahead).is_success
    event(history, session_id, "pain", 60.0)
    assert line(therapist, world)["worry_count"] == 1


def test_a_compensation_that_was_seen_is_seen_when_it_is_analysed_again(history, therapist, world, engine):
    session_id = compensation(history)
    assert seen(therapist, world, line(therapist, world)["worry"]).is_success
    with read_only(engine) as session:
        known = worries_of(session, [world.patient_id])[world.patient_id]
    history.summary = [leaned(16.0)]
    with unit_of_work(engine) as session:
        history.compare(session, session_id, [1.0, 1.1], "vqf", utc_now())
    assert unseen(known) == []
    assert line(therapist, world)["worry_count"] == 0


def test_a_lost_link_shows_beside_a_session_that_streams(history, therapist, world):
    lost = history.session(1, state="link_lost")
    history.session(0, state="recording")
    row = line(therapist, world)
    assert (row["reason"], row["live_state"], row["worry"]) == ("link_lost", "streaming", None)
    assert lost != row["live_session_id"]


def test_who_may_treat_is_told_so(history, therapist, sign_in, world):
    pain(history)
    assert line(therapist, world)["may_treat"]
    assert not line(sign_in("reader"), world)["may_treat"]


@pytest.mark.parametrize("cause", ["valid_count", "set", "time", "person", "lost"])
def test_an_exercise_that_ends_as_it_should_is_no_worry(history, therapist, world, cause):
    session_id = history.session(1, [1.0, 1.1])
    event(history, session_id, "guidance_stop", details={"cause": cause})
    event(history, session_id, "state", text="link_lost")
    assert line(therapist, world)["worry"] is None


def test_who_shows_a_template_is_no_patient_but_pain_is_pain(history, therapist, world):
    session_id = history.session(1, purpose="template")
    event(history, session_id, DEAD_LINK)
    assert line(therapist, world)["worry"] is None
    event(history, session_id, "pain")
    assert line(therapist, world)["worry"]["kind"] == "pain"
