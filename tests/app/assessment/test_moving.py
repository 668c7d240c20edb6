"""A session under the wrong patient is moved, two records of one person become one; rights, consents and trails."""

import pytest
from sqlalchemy import func, select

from app.accounts.models import Account, AuditEvent
from app.assessment.comparisons import compare_task
from app.assessment.models import Comparison, CourseNote, WorrySeen
from app.database.base import new_id, utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Exercise, Prescription, Template, TemplateVersion
from app.patients.models import Grant, Mounting, Patient
from app.recordings.analysis.jobs import JobRunner, run_job
from app.recordings.models import Job, MotionSession, Result
from estimators.pipelines import SessionSetup

from .history import History

REASON = "chosen by mistake"
LAYOUT = ("segments", "points", "angles", "scalars")


@pytest.fixture(autouse=True)
def quiet_queue(services):
    services.get(JobRunner).stop()


@pytest.fixture
def history(engine, world):
    """Ada has a prescription and one compared session; the therapist treats Bert too."""
    history = History(engine, world)
    history.prescribe(10)
    history.session(1, [1.0, 1.1], valid_repetitions=2, active_s=20.0)
    setup = SessionSetup("arm", ("sternum", "upper_arm_right", "forearm_right"), 100.0)
    with unit_of_work(engine) as session:
        session.scalars(select(MotionSession)).one().setup = setup.to_dict()
        session.scalars(select(Result)).one().layout = dict.fromkeys(LAYOUT, ())
    return history


@pytest.fixture
def session_id(engine, history):
    with read_only(engine) as session:
        return session.scalars(select(MotionSession.id)).one()


def patch(client, session_id, **body):
    return client.patch(f"/api/sessions/{session_id}", json={"reason": REASON, **body})


def count(engine, table, *conditions):
    with read_only(engine) as session:
        return session.scalar(select(func.count()).select_from(table).where(*conditions))


def trail(engine, patient_id, prefix):
    with read_only(engine) as session:
        rows = session.execute(
            select(AuditEvent.action, AuditEvent.details).where(
                AuditEvent.patient_id == patient_id, AuditEvent.action.startswith(prefix)
            )
        ).all()
    return [(action, details) for action, details in rows]


def test_a_session_moves_with_its_results_and_is_compared_anew(engine, therapist, world, session_id, history):
    before = therapist.get(f"/api/patients/{world.patient_id}/progress").text
    assert session_id in before
    prescribed = history.prescribe(10, template=False, patient_id=world.other_patient_id)
    with unit_of_work(engine) as session:
        session.add(Mounting(patient_id=world.patient_id, calibration={}, session_id=session_id))
    moved = patch(therapist, session_id, patient_id=world.other_patient_id)
    assert moved.status_code == 200, moved.text
    assert moved.json()["patient_id"] == world.other_patient_id
    assert moved.json()["prescription_id"] == prescribed.id
    assert "Moved here" in moved.json()["events"][-1]["text"]
    assert count(engine, Result) == 1
    # Ada's own template says nothing about Bert; how the sensors sat on him is not offered for her.
    assert count(engine, Comparison) == count(engine, Mounting) == 0
    assert session_id not in therapist.get(f"/api/patients/{world.patient_id}/progress").text
    listed = therapist.get(f"/api/patients/{world.other_patient_id}/sessions").json()
    assert [one["id"] for one in listed] == [session_id]
    with read_only(engine) as session:
        (job,) = session.scalars(select(Job)).all()
        assert (job.kind, job.arguments) == ("compare", {"close": True})
        assert session.get_one(MotionSession, session_id).valid_repetitions is None
    (left,) = trail(engine, world.patient_id, "session.move")
    (came,) = trail(engine, world.other_patient_id, "session.move")
    assert left == ("session.move_out", {"to": world.other_patient_id, "reason": REASON})
    assert came == ("session.move_in", {"from": world.patient_id, "reason": REASON})
    # At once again, although its comparison waits: and back.
    back = patch(therapist, session_id, patient_id=world.patient_id)
    assert back.json()["patient_id"] == world.patient_id
    assert back.json()["prescription_id"] not in {None, prescribed.id}


def test_worries_that_were_seen_follow_their_session(engine, therapist, world, session_id):
    with unit_of_work(engine) as session:
        session.add(WorrySeen(session_id=session_id, kind="pain", known_until=utc_now(), seen_by="x"))
    patch(therapist, session_id, patient_id=world.other_patient_id)
    assert count(engine, WorrySeen, WorrySeen.session_id == session_id) == 1


def test_another_exercise_is_chosen(engine, therapist, world, session_id, history):
    with unit_of_work(engine) as session:
        other = Exercise(
            id=new_id(),
            clinic_id=world.clinic_id,
            name="Other",
            movement="drinking",
            primary_angle="",
        )
        session.add(other)
    moved = patch(therapist, session_id, exercise_id=other.id)
    assert moved.status_code == 200, moved.text
    assert (moved.json()["exercise_id"], moved.json()["prescription_id"]) == (other.id, None)
    assert count(engine, Comparison) == 0
    ((_, details),) = trail(engine, world.patient_id, "session.exercise")
    assert details == {"from": world.exercise_id, "to": other.id, "reason": REASON}
    assert patch(therapist, session_id, exercise_id=world.foreign_exercise_id).status_code == 422


def test_a_comparison_that_was_under_way_is_not_stored_for_the_wrong_patient(
    engine, settings, therapist, world, session_id, history, monkeypatch
):
    with unit_of_work(engine) as session:
        job = Job(session_id=session_id, kind="compare", arguments={"close": True}, created_by="x")
        session.add(job)
    stored = count(engine, Comparison)

    def move_meanwhile(*_):
        patch(therapist, session_id, patient_id=world.other_patient_id)
        return None, ""

    monkeypatch.setattr("app.assessment.comparisons._counted", move_meanwhile)
    monkeypatch.setattr("app.assessment.comparisons._store", lambda *_: pytest.fail("of the wrong patient"))
    assert stored == 1
    assert run_job(engine, settings, job.id, compare_task).status == "complete"


@pytest.mark.parametrize(
    ("who", "target", "status"),
    [
        ("reader", "other_patient_id", 403),
        ("administrator", "other_patient_id", 403),
        ("patient", "other_patient_id", 403),
        ("colleague", "other_patient_id", 404),
        ("therapist", "foreign_patient_id", 404),
        ("foreign_therapist", "foreign_patient_id", 404),
    ],
)
def test_only_who_treats_both_moves(sign_in, world, session_id, engine, who, target, status):
    answer = patch(sign_in(who), session_id, patient_id=getattr(world, target))
    assert answer.status_code == status, answer.text
    with read_only(engine) as session:
        assert session.get_one(MotionSession, session_id).patient_id == world.patient_id


def test_a_therapist_of_one_patient_alone_does_not_move(sign_in, therapist, world, session_id, engine):
    with unit_of_work(engine) as session:
        for grant in session.scalars(select(Grant).where(Grant.patient_id == world.other_patient_id)):
            grant.revoked_at = utc_now()
    assert patch(therapist, session_id, patient_id=world.other_patient_id).status_code == 404


def test_what_cannot_be_moved_says_why(engine, therapist, world, session_id, history):
    assert patch(therapist, session_id, reason="  ").json()["details"] == {"field": "reason"}
    assert patch(therapist, session_id).json()["details"] == {"field": "patient_id"}
    with unit_of_work(engine) as session:
        session.get_one(MotionSession, session_id).state = "recording"
    live = patch(therapist, session_id, patient_id=world.other_patient_id)
    assert (live.status_code, live.json()["details"]["reason"]) == (409, "live")
    with unit_of_work(engine) as session:
        session.get_one(MotionSession, session_id).state = "analysed"
        version = session.scalars(select(TemplateVersion)).one()
        version.source_session_id = session_id
    made = patch(therapist, session_id, patient_id=world.other_patient_id)
    assert (made.status_code, made.json()["details"]["reason"]) == (409, "template")
    therapist.put(
        f"/api/patients/{world.other_patient_id}/consents", json={"purpose": "treatment", "granted": False}
    )
    assert patch(therapist, session_id, patient_id=world.other_patient_id).status_code == 403


def merge(client, kept, other):
    return client.post(f"/api/patients/{kept}/merge", json={"other_id": other, "reason": "entered twice"})


def test_two_records_of_one_person_become_one(engine, sign_in, therapist, world, session_id, history):
    history.prescribe(5, template=False, patient_id=world.other_patient_id)
    token = therapist.post(f"/api/patients/{world.patient_id}/device-tokens", json={"label": "phone"}).json()
    with unit_of_work(engine) as session:
        session.add(
            CourseNote(
                patient_id=world.patient_id, exercise_id=world.exercise_id, text="Better.", written_by="x"
            )
        )
    kept, other = (f"/api/patients/{one}" for one in (world.other_patient_id, world.patient_id))
    therapist.put(f"{kept}/consents", json={"purpose": "research", "granted": True})
    therapist.put(f"{other}/consents", json={"purpose": "research", "granted": False})
    therapist.put(f"{other}/consents", json={"purpose": "home_streaming", "granted": True})
    before = {one["purpose"]: one["granted"] for one in therapist.get(f"{kept}/consents").json()}
    rights = {one["account_id"] for one in therapist.get(f"{kept}/grants").json()}
    said = merge(therapist, world.other_patient_id, world.patient_id)
    assert said.status_code == 200, said.text
    assert said.json() == {
        "patient_id": world.other_patient_id,
        "sessions": 1,
        "prescriptions": 1,
        "templates": 1,
        "notes": 1,
        "revoked_tokens": 1,
        "withdrawn_consents": ["research"],
    }
    # A no holds, a yes of the other record is not taken over, and nobody sees more than before.
    answers = {one["purpose"]: one["granted"] for one in therapist.get(f"{kept}/consents").json()}
    assert answers["research"] is False
    assert answers.get("home_streaming") == before.get("home_streaming")
    assert {one["account_id"] for one in therapist.get(f"{kept}/grants").json()} == rights
    left = therapist.get(other).json()
    assert (left["merged_into_id"], left["archived_at"] is not None) == (world.other_patient_id, True)
    assert [one["id"] for one in therapist.get(f"{kept}/sessions").json()] == [session_id]
    # Compared with the person's own template, as before; of one exercise one prescription goes on.
    assert count(engine, Comparison) == 1
    assert count(engine, Prescription, Prescription.ends_at.is_(None)) == 1
    assert count(engine, Template, Template.patient_id == world.other_patient_id) == 1
    assert sign_in("administrator").get(f"{other}/device-tokens").json()[0]["revoked_at"] is not None, token
    with read_only(engine) as session:
        assert not session.get_one(Account, world.accounts["patient"]).is_active, "the other sign-in stays"
    assert merge(therapist, world.other_patient_id, world.patient_id).status_code == 409
    assert merge(therapist, world.other_patient_id, world.other_patient_id).status_code == 422
    for patient_id in (world.patient_id, world.other_patient_id):
        ((_, details),) = trail(engine, patient_id, "patient.merge")
        assert details["reason"] == "entered twice"
    # One session did not belong: it is moved back once the record is taken out of the archive.
    therapist.patch(other, json={"is_archived": False})
    assert patch(therapist, session_id, patient_id=world.patient_id).status_code == 200


def test_both_records_are_erased_together(engine, sign_in, therapist, world, session_id):
    merge(therapist, world.other_patient_id, world.patient_id)
    administrator = sign_in("administrator")
    path = f"/api/patients/{world.other_patient_id}"
    administrator.patch(path, json={"is_archived": True})
    assert administrator.request("DELETE", path, json={"confirmation": "ERASE"}).status_code == 204
    assert count(engine, Patient, Patient.clinic_id == world.clinic_id) == 0
    assert len(trail(engine, world.patient_id, "patient.erase")) == 1


@pytest.mark.parametrize("who", ["reader", "administrator", "colleague", "foreign_therapist", "patient"])
def test_only_who_treats_both_merges(sign_in, world, session_id, engine, who):
    assert merge(sign_in(who), world.other_patient_id, world.patient_id).status_code in {403, 404}
    assert count(engine, Patient, Patient.merged_into_id.is_not(None)) == 0
