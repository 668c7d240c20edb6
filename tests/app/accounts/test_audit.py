"""The audit trail: complete, in one chain per clinic, and tampering is seen."""

import threading

import pytest
from sqlalchemy import select, text, update
from typer.testing import CliRunner

from app.accounts import audit
from app.accounts.models import AuditEvent
from app.cli import cli
from app.database import backup
from app.database.unit_of_work import read_only, unit_of_work


@pytest.fixture
def subject(world):
    return world.subjects["therapist"]


def record_some(engine, subject, count=5):
    for number in range(count):
        with unit_of_work(engine) as session:
            audit.record(session, subject, "patient.read", "p" * 32, details={"number": number, "ä": 1.5})


def check(engine, clinic_id, head=None):
    with read_only(engine) as session:
        return audit.verify(session, clinic_id, head)


def test_an_untouched_chain_is_intact(engine, subject, world):
    assert check(engine, world.clinic_id).is_intact
    record_some(engine, subject)
    report = check(engine, world.clinic_id)
    assert (report.is_intact, report.events) == (True, 5)
    with read_only(engine) as session:
        assert audit.head(session, world.clinic_id) == (5, report.head)
    assert check(engine, world.foreign_clinic_id).events == 0


@pytest.mark.parametrize(
    ("statement", "broken_at"),
    [
        ("UPDATE audit_event SET action = 'patient.list' WHERE number = 3", 3),
        ("UPDATE audit_event SET subject_id = 'x' WHERE number = 1", 1),
        ("UPDATE audit_event SET at = '2001-01-01 00:00:00.000000' WHERE number = 2", 2),
        ("UPDATE audit_event SET patient_id = NULL WHERE number = 5", 5),
        ("UPDATE audit_event SET details = '{}' WHERE number = 4", 4),
        ("DELETE FROM audit_event WHERE number = 3", 4),
        ("DELETE FROM audit_event WHERE number = 1", 2),
        ("UPDATE audit_event SET number = 99 WHERE number = 5", 99),
    ],
)
def test_tampering_is_found_at_its_place(engine, subject, world, statement, broken_at):
    record_some(engine, subject)
    with engine.begin() as connection:
        # Somebody with the file can drop the triggers; the chain still tells.
        connection.execute(text("DROP TRIGGER audit_event_no_update"))
        connection.execute(text("DROP TRIGGER audit_event_no_delete"))
        connection.execute(text(statement))
    report = check(engine, world.clinic_id)
    assert not report.is_intact
    assert report.broken_at == broken_at


def test_recomputing_one_hash_breaks_the_next(engine, subject, world):
    record_some(engine, subject)
    with engine.begin() as connection:
        connection.execute(text("DROP TRIGGER audit_event_no_update"))
    with unit_of_work(engine) as session:
        event = session.scalars(select(AuditEvent).where(AuditEvent.number == 2)).one()
        event.action = "nothing.happened"
        session.execute(update(AuditEvent).where(AuditEvent.number == 2).values(hash=audit.hash_event(event)))
    assert check(engine, world.clinic_id).broken_at == 3


def test_a_cut_end_is_found_with_a_head_kept_elsewhere(engine, subject, world):
    record_some(engine, subject)
    with read_only(engine) as session:
        head = audit.head(session, world.clinic_id)
    with engine.begin() as connection:
        connection.execute(text("DROP TRIGGER audit_event_no_delete"))
        connection.execute(text("DELETE FROM audit_event WHERE number > 3"))
    assert check(engine, world.clinic_id).is_intact, "a cut chain is whole in itself"
    assert not check(engine, world.clinic_id, head).is_intact
    record_some(engine, subject)
    report = check(engine, world.clinic_id, head)
    assert (report.is_intact, report.broken_at) == (False, 5)


def test_many_writers_and_readers_make_one_chain(engine, subject, world):
    errors = []

    def work(unit, own):
        try:
            for _ in range(15):
                with unit(engine) as session:
                    audit.record(session, own, "patient.read", "p" * 32)
                    audit.record(session, own, "session.read", "p" * 32)
        except Exception as error:
            errors.append(error)

    foreign = world.subjects["foreign_therapist"]
    threads = [
        threading.Thread(target=work, args=(unit, own))
        for unit in (unit_of_work, read_only)
        for own in (subject, foreign, subject)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    own, other = check(engine, world.clinic_id), check(engine, world.foreign_clinic_id)
    assert (own.is_intact, own.events) == (True, 4 * 15 * 2)
    assert (other.is_intact, other.events) == (True, 2 * 15 * 2)


def test_what_is_rolled_back_was_not_done_and_is_not_noted(engine, subject, world):
    with pytest.raises(RuntimeError), unit_of_work(engine) as session:  # noqa: PT012
        audit.record(session, subject, "patient.create")
        raise RuntimeError("later failure")
    with pytest.raises(RuntimeError), read_only(engine) as session:  # noqa: PT012
        audit.record(session, subject, "patient.read")
        raise RuntimeError("nothing was answered")
    assert check(engine, world.clinic_id).events == 0


def test_an_answer_that_cannot_be_audited_is_not_given(therapist, world, engine):
    with engine.begin() as connection:
        connection.execute(
            text(
                "CREATE TRIGGER full BEFORE INSERT ON audit_event BEGIN SELECT RAISE(ABORT, 'disk full'); END"
            )
        )
    answer = therapist.get(f"/api/patients/{world.patient_id}")
    assert answer.status_code == 500
    assert "Ada" not in answer.text


def test_every_read_and_write_of_a_patient_is_noted(therapist, world, engine):
    base = f"/api/patients/{world.patient_id}"
    requests = [
        ("GET", base, None, "patient.read"),
        ("PATCH", base, {"notes": "secret remark"}, "patient.update"),
        ("GET", f"{base}/progress", None, "progress.read"),
        ("GET", f"{base}/grants", None, "grant.list"),
        ("GET", f"{base}/consents", None, "consent.read"),
        ("PUT", f"{base}/consents", {"purpose": "research", "granted": True}, "consent.change"),
        ("GET", f"{base}/device-tokens", None, "device_token.list"),
        ("POST", f"{base}/device-tokens", {"label": "tablet"}, "device_token.create"),
        ("GET", f"{base}/prescriptions", None, "prescription.list"),
        ("POST", f"{base}/prescriptions", {"exercise_id": world.exercise_id}, "prescription.create"),
        ("GET", f"{base}/audit", None, "audit.read"),
        ("GET", f"{base}/sessions", None, "session.list"),
        ("GET", "/api/patients", None, "patient.list"),
        ("GET", "/api/caseload", None, "caseload.read"),
    ]
    for method, path, body, action in requests:
        answer = therapist.request(method, path, json=body)
        assert answer.status_code < 300, (path, answer.text)
        with read_only(engine) as session:
            newest = session.scalars(select(AuditEvent).order_by(AuditEvent.number.desc()).limit(2)).all()
        assert action in {event.action for event in newest}, path
    assert check(engine, world.clinic_id).is_intact
    with read_only(engine) as session:
        for event in session.scalars(select(AuditEvent)):
            assert "secret remark" not in str(event.details), "the trail holds no patient data"


def run_command(settings, monkeypatch, *arguments):
    monkeypatch.setenv("TELEMOTION_DATABASE_URL", settings.database_url)
    monkeypatch.setenv("TELEMOTION_SECRET_KEY", settings.secret_key.get_secret_value())
    return CliRunner().invoke(cli, ["audit-verify", *arguments])


def test_the_command_tells_whole_and_broken_chains(engine, subject, world, settings, monkeypatch, tmp_path):
    record_some(engine, subject)
    whole = run_command(settings, monkeypatch)
    assert whole.exit_code == 0, whole.output
    assert f"clinic {world.clinic_id}: 5 events, intact" in whole.output
    assert f"clinic {world.foreign_clinic_id}: 0 events, intact" in whole.output
    archive = tmp_path / "kept.backup"
    backup.backup(engine, archive)
    assert run_command(settings, monkeypatch, "--against", str(archive)).exit_code == 0
    with engine.begin() as connection:
        connection.execute(text("DROP TRIGGER audit_event_no_delete"))
        connection.execute(text("DELETE FROM audit_event WHERE number = 5"))
    assert run_command(settings, monkeypatch).exit_code == 0, "a cut chain is whole in itself"
    cut = run_command(settings, monkeypatch, "--against", str(archive))
    assert cut.exit_code == 1
    assert f"clinic {world.clinic_id}: broken at event 5: events at the end are missing" in cut.output
    with engine.begin() as connection:
        connection.execute(text("DELETE FROM audit_event WHERE number = 2"))
    broken = run_command(settings, monkeypatch)
    assert broken.exit_code == 1
    assert f"clinic {world.clinic_id}: broken at event 3" in broken.output
