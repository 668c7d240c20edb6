"""The same service on a real PostgreSQL: locks, read-only units, tickets, progress and a walk over HTTP."""

import threading

import pytest
from sqlalchemy import select
from sqlalchemy.exc import DBAPIError

from app.accounts import audit
from app.accounts.credentials.tickets import issue_ticket, redeem_ticket
from app.accounts.models import Clinic
from app.database.engine import create_from_url
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import SignInRequired
from app.recordings.models import MotionSession
from tests.app.assessment.history import History, reason_declining

pytestmark = pytest.mark.postgres


@pytest.fixture
def settings(settings_on_postgresql):
    return settings_on_postgresql


@pytest.fixture
def engine(settings):
    engine = create_from_url(settings.database_url)
    yield engine
    engine.dispose()


def run_together(count, work):
    errors = []

    def guarded(number):
        try:
            work(number)
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=guarded, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []


def test_reading_units_cannot_write_and_give_the_connection_back_clean(engine):
    with pytest.raises(DBAPIError, match="read-only"), read_only(engine) as session:
        session.connection().exec_driver_sql("DELETE FROM clinic")
    for number in range(3):
        with unit_of_work(engine) as session:
            session.add(Clinic(name=str(number)))
        with read_only(engine) as session:
            assert len(session.scalars(select(Clinic.id)).all()) == number + 1


def test_many_processes_would_make_one_chain(engine, world):
    def work(number):
        name = "therapist" if number % 2 else "foreign_therapist"
        for unit in (unit_of_work, read_only) * 5:
            with unit(engine) as session:
                audit.record(session, world.subjects[name], "patient.read", details={"number": 1.25})

    run_together(6, work)
    with read_only(engine) as session:
        for clinic_id in (world.clinic_id, world.foreign_clinic_id):
            report = audit.verify(session, clinic_id)
            assert (report.is_intact, report.events) == (True, 30)


def test_of_many_at_once_one_uses_a_ticket(engine, world):
    with unit_of_work(engine) as session:
        token, _ = issue_ticket(session, world.subjects["patient"], "live", "5" * 32)
    results = []

    def work(_):
        try:
            with unit_of_work(engine) as session:
                results.append(redeem_ticket(session, token, "live").session_id)
        except SignInRequired:
            results.append("")

    run_together(6, work)
    assert sorted(results) == [""] * 5 + ["5" * 32]


def test_the_pages_of_a_therapist(engine, world, therapist, patient, sign_in):
    history = History(engine, world)
    history.prescribe(10)
    reason_declining(history)
    (first, _) = therapist.get("/api/caseload").json()
    assert (first["reason"], first["trend"][-1]) == ("declining", pytest.approx(1.0))
    found = therapist.get(f"/api/patients/{world.patient_id}/progress").json()
    assert found["measures"][0]["trend"]["probability"] < 0.05
    base = f"/api/patients/{world.patient_id}"
    assert therapist.patch(base, json={"notes": "on PostgreSQL"}).json()["notes"] == "on PostgreSQL"
    (prescription,) = patient.get(f"{base}/prescriptions").json()
    assert prescription["exercise_name"] == "Reach forward"
    answer = therapist.post(
        "/api/sessions", json={"patient_id": world.patient_id, "placements": ["upper_arm_right"]}
    )
    assert answer.status_code == 201, answer.text
    assert therapist.get(f"{base}/audit").status_code == 200
    assert therapist.delete(f"/api/sessions/{answer.json()['id']}").status_code == 204
    assert therapist.patch(base, json={"is_archived": True}).status_code == 200
    administrator = sign_in("administrator")
    erased = administrator.request("DELETE", base, json={"confirmation": "ERASE"})
    assert erased.status_code == 204, erased.text
    assert patient.get("/api/me").status_code == 401
    with read_only(engine) as session:
        assert session.scalars(select(MotionSession)).all() == []
        assert audit.verify(session, world.clinic_id).is_intact
