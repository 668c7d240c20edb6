"""Archiving a patient, and erasing one: everything goes, also from the file; the trail stays whole."""

import pytest
from sqlalchemy import func, select, update

from app.accounts import audit
from app.accounts.models import Account, AuditEvent, Consent, DeviceToken, SignIn
from app.assessment.models import Comparison, ComparisonMeasure, RepetitionMeasure
from app.database.base import new_id, utc_now
from app.database.engine import forget_deleted
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Prescription, Template, TemplateVersion
from app.patients.models import Grant, Mounting, Patient
from app.recordings.analysis.jobs import JobRunner
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import Job, MotionSession, Result, SessionEvent, SignalChunk

from .history import History

MARK = "Qvxjzw"
"""Letters that stand nowhere else."""
BLOB = b"\x07SIGNALS\x07" * 2000
ERASE = {"confirmation": "ERASE"}


@pytest.fixture(autouse=True)
def quiet_queue(services):
    services.get(JobRunner).stop()


@pytest.fixture
def path(world):
    return f"/api/patients/{world.patient_id}"


@pytest.fixture
def full(engine, world, settings, therapist, path):
    """Give Ada something in every table; returns the number of her sessions."""
    history = History(engine, world)
    history.prescribe(10)
    for age in range(3):
        history.session(age, [1.0, 1.1])
    therapist.patch(path, json={"notes": MARK, "family_name": MARK})
    therapist.post(f"{path}/device-tokens", json={"label": MARK})
    with unit_of_work(engine) as session:
        own = session.get_one(Account, world.accounts["patient"])
        own.display_name, own.email = MARK, f"{MARK.lower()}@example.org"
        motion = session.scalars(
            select(MotionSession).where(MotionSession.patient_id == world.patient_id)
        ).first()
        motion.prescription_id = session.scalars(select(Prescription.id)).first()
        for sequence in range(20):
            session.add(
                SignalChunk(
                    session_id=motion.id,
                    stream="raw",
                    sequence=sequence,
                    start_ns=0,
                    ticks=1,
                    codec="none",
                    scale={},
                    crc=0,
                    data=BLOB,
                )
            )
        session.add(SessionEvent(session_id=motion.id, kind="mark", time_s=1.0, text=MARK, details={}))
        session.add(Mounting(patient_id=world.patient_id, calibration={"says": MARK}, session_id=motion.id))
        file = upload_folder(settings) / f"{new_id()}.upload"
        file.write_text(MARK)
        session.add(
            Job(
                session_id=motion.id,
                kind="upload",
                arguments={"file": file.name},
                created_by="x",
                status="queued",
            )
        )
    return history


def count(engine, *tables):
    with read_only(engine) as session:
        return {
            table.__tablename__: session.scalar(select(func.count()).select_from(table)) for table in tables
        }


def files_with(folder, *needles):
    return [
        (path.name, needle)
        for path in folder.rglob("*")
        if path.is_file()
        for needle in needles
        if needle in path.read_bytes()
    ]


def test_an_archived_patient_is_read_and_not_added_to(
    sign_in, patient, therapist, world, path, device_client
):
    device = device_client(world.patient_id)
    new = {"patient_id": world.patient_id, "placements": ["upper_arm_right"]}
    assert therapist.patch(path, json={"is_archived": True}).json()["archived_at"] is not None
    assert [row["patient_id"] for row in therapist.get("/api/caseload").json()] == [world.other_patient_id]
    assert therapist.get("/api/patients").json()[-1]["id"] == world.patient_id, "still listed, last"
    assert therapist.get(path).status_code == 200
    assert patient.get(f"{path}/progress").status_code == 200
    for client in (therapist, patient, device):
        answer = client.post("/api/sessions", json=new)
        assert (answer.status_code, answer.json()["details"]["archived"]) == (403, True)
    assert therapist.post(f"{path}/prescriptions", json={"exercise_id": world.exercise_id}).status_code == 403
    assert sign_in("reader").patch(path, json={"is_archived": False}).status_code == 403
    assert therapist.patch(path, json={"is_archived": False}).json()["archived_at"] is None
    assert therapist.post("/api/sessions", json=new).status_code == 201
    trail = [row["action"] for row in therapist.get(f"{path}/audit").json()]
    assert trail.count("patient.archive") == trail.count("patient.unarchive") == 1
    assert "patient.update" not in trail


def test_erasing_leaves_nothing_but_the_trail(sign_in, patient, full, engine, settings, world, path):
    administrator = sign_in("administrator")
    folder = upload_folder(settings).parent.parent
    kept = count(engine, AuditEvent)["audit_event"]
    assert files_with(folder, MARK.encode(), BLOB)
    administrator.patch(path, json={"is_archived": True})
    answer = administrator.request("DELETE", path, json=ERASE)
    assert answer.status_code == 204, answer.text
    own_data = (
        Prescription, MotionSession, SignalChunk, SessionEvent, Result, Job, Comparison, ComparisonMeasure,
        RepetitionMeasure, Mounting, Template, TemplateVersion,
    )  # fmt: skip
    assert set(count(engine, *own_data).values()) == {0}
    with read_only(engine) as session:
        assert session.get(Patient, world.patient_id) is None
        assert session.get(Account, world.accounts["patient"]) is None
        for table in (Grant, Consent, DeviceToken):
            query = select(func.count()).where(table.patient_id == world.patient_id)
            assert session.scalar(query) == 0, table
        assert (
            session.scalars(select(SignIn).where(SignIn.account_id == world.accounts["patient"])).all() == []
        )
        report = audit.verify(session, world.clinic_id)
        assert report.is_intact
        assert report.events > kept
        last = session.scalars(select(AuditEvent).order_by(AuditEvent.id.desc())).first()
    assert (last.action, last.patient_id, last.subject_id, last.details) == (
        "patient.erase",
        world.patient_id,
        world.accounts["administrator"],
        {"sessions": 3, "accounts": 1},
    )
    # Neither in the database's file nor in its log nor among the uploads, once the log is reused.
    assert forget_deleted(engine)
    assert files_with(folder, MARK.encode(), MARK.lower().encode(), BLOB[:40]) == []
    # Everybody else is as before.
    assert patient.get("/api/me").status_code == 401
    assert administrator.get(path).status_code == 404
    assert administrator.request("DELETE", path, json=ERASE).status_code == 404
    ids = {row["id"] for row in administrator.get("/api/patients").json()}
    assert ids == {world.other_patient_id}
    assert sign_in("other_patient").get(f"/api/patients/{world.other_patient_id}").status_code == 200


def test_erasing_asks_for_the_archive_and_the_word(sign_in, therapist, world, path):
    administrator = sign_in("administrator")
    answer = administrator.request("DELETE", path, json=ERASE)
    assert (answer.status_code, answer.json()["details"]) == (409, {"archived": False})
    therapist.patch(path, json={"is_archived": True})
    for body in ({}, {"confirmation": "yes"}, {"confirmation": "erase"}):
        assert administrator.request("DELETE", path, json=body).status_code == 422
    assert therapist.request("DELETE", path, json=ERASE).status_code == 403
    assert sign_in("foreign_administrator").request("DELETE", path, json=ERASE).status_code == 404
    assert administrator.get(path).status_code == 200


@pytest.mark.parametrize(
    ("session_state", "job_status", "reason"),
    [
        ("recording", None, "live"),
        ("link_lost", None, "live"),
        ("closing", None, "live"),
        ("closing", "running", "analysis"),
        ("analysed", "running", "analysis"),
        ("closing", "queued", None),
        ("created", None, None),
        ("failed", "failed", None),
    ],
)
def test_erasing_waits_for_work_on_the_recordings(
    sign_in, full, engine, world, path, session_state, job_status, reason
):
    administrator = sign_in("administrator")
    administrator.patch(path, json={"is_archived": True})
    with unit_of_work(engine) as session:
        job = session.scalars(select(Job)).one()
        session.execute(
            update(MotionSession).where(MotionSession.id == job.session_id).values(state=session_state)
        )
        if job_status is None:
            session.delete(job)
        else:
            job.status = job_status
    answer = administrator.request("DELETE", path, json=ERASE)
    if reason is None:
        assert answer.status_code == 204, answer.text
        return
    assert (answer.status_code, answer.json()["details"]["reason"]) == (409, reason)
    assert administrator.get(path).status_code == 200


def test_erasing_takes_the_clinics_templates_that_were_made_from_the_patient(
    sign_in, full, engine, world, path
):
    """One whose only version is the patient's goes; of one that also has another's version that version stays."""
    with unit_of_work(engine) as session:
        motion = session.scalars(
            select(MotionSession).where(MotionSession.patient_id == world.patient_id)
        ).first()
        kept, gone = (
            Template(
                id=new_id(),
                clinic_id=world.clinic_id,
                exercise_id=world.exercise_id,
                patient_id=None,
                name=name,
                created_by=world.accounts["therapist"],
            )
            for name in ("kept", "gone")
        )
        session.add_all([kept, gone])
        session.flush()
        for template, number, source in ((gone, 1, motion.id), (kept, 1, new_id()), (kept, 2, motion.id)):
            session.add(
                TemplateVersion(
                    id=new_id(),
                    template_id=template.id,
                    number=number,
                    source_session_id=source,
                    source_result_id=new_id(),
                    repetitions=[],
                    content=BLOB,
                    created_by=world.accounts["therapist"],
                )
            )
        prescription = Prescription(
            id=new_id(),
            patient_id=world.other_patient_id,
            exercise_id=world.exercise_id,
            template_id=gone.id,
            prescribed_by=world.accounts["therapist"],
            starts_at=utc_now(),
        )
        session.add(prescription)
    administrator = sign_in("administrator")
    administrator.patch(path, json={"is_archived": True})
    assert administrator.request("DELETE", path, json=ERASE).status_code == 204
    with read_only(engine) as session:
        assert session.scalars(select(Template.name)).all() == ["kept"]
        assert session.scalars(select(TemplateVersion.number)).all() == [1]
        assert session.get_one(Prescription, prescription.id).template_id is None
