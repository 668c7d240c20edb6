"""A database in which one patient has everything that can be had, made once by the real chain.

Ada of clinic A and Carl of clinic B each get an uploaded session with frames, a template made from it and a
comparison. Every free text of Ada's holds `MARK`: where it appears in an answer, her data has leaked.
"""

from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import Engine, update
from sqlalchemy.orm import Session

from app.accounts.credentials.passwords import Passwords
from app.accounts.device_tokens import create_device_token
from app.accounts.subject import Subject
from app.assessment import comparisons
from app.assessment.design import recorded
from app.assessment.schemas import ComparisonIn
from app.database.base import new_id, utc_now
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Prescription
from app.exercises.schemas import TemplateIn
from app.gateway.encoding import stream_of
from app.ingest.upload import register
from app.ingest.upload_task import upload
from app.network.packet_log import log_entry, log_head
from app.patients.models import Grant, Patient
from app.recordings.analysis.jobs import run_job
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import Job, MagneticSource, MotionSession, SessionEvent
from app.recordings.schemas import UploadIn
from app.settings import Settings
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.app.conftest import World, build_world

MARK = "zq7mark"


@dataclass
class Seed:
    """Identifiers of Ada's (`own`) and Carl's (`foreign`) things by the name of a path parameter, and
    tokens."""

    world: World
    file: Path
    own: dict[str, str] = field(default_factory=dict)
    foreign: dict[str, str] = field(default_factory=dict)
    tokens: dict[str, str] = field(default_factory=dict)


def write_log(path: Path) -> None:
    """Write a packet log of a simulated person who reaches four times."""
    scenario = ArmScenario(schedule=Schedule(n_pose_s=5.0, repetitions=4), errors="ideal", seed=3)
    stream = stream_of(simulate_arm(scenario).recording)
    with path.open("wb") as file:
        file.write(log_head(stream.hello("-").model_dump(exclude={"type", "ticket"})))
        for number in range(stream.packet_count):
            file.write(log_entry(stream.packet(number)))


def build_seed(settings: Settings, passwords: Passwords, folder: Path) -> Seed:
    """Fill the migrated database of `settings`."""
    engine = create_from_url(settings.database_url)
    world = build_world(engine, passwords)
    seed = Seed(world, Path(settings.database_url.removeprefix("sqlite:///")))
    log = folder / "movement.tmlog"
    write_log(log)
    with unit_of_work(engine) as session:
        ada = session.get_one(Patient, world.patient_id)
        ada.given_name, ada.family_name, ada.notes = f"Ada {MARK}", f"L {MARK}", f"note {MARK}"
    seed.own = _everything(
        engine, settings, log, world, "therapist", world.patient_id, world.exercise_id, MARK
    )
    # Somebody of the same clinic who has no right to Ada any more.
    seed.own["account_id"] = world.accounts["former"]
    seed.foreign = _everything(
        engine,
        settings,
        log,
        world,
        "foreign_therapist",
        world.foreign_patient_id,
        world.foreign_exercise_id,
        "other",
    )
    with unit_of_work(engine) as session:
        for name, giver, patient_id in [
            ("device", "therapist", world.patient_id),
            ("revoked_device", "therapist", world.patient_id),
            ("other_device", "therapist", world.other_patient_id),
            ("foreign_device", "foreign_therapist", world.foreign_patient_id),
        ]:
            row, token = create_device_token(
                session, settings, world.subjects[giver], patient_id, f"{name} {MARK}", 1
            )
            seed.tokens[name] = token
            if name == "device":
                seed.own["token_id"] = row.id
            if name == "revoked_device":
                row.revoked_at = utc_now()
    with unit_of_work(engine) as session:
        # What the uploads queued after themselves; a service that finds it would start a worker process.
        session.execute(update(Job).where(Job.status == "queued").values(status="complete"))
    if engine.dialect.name == "sqlite":
        with engine.connect() as connection:
            driver = connection.connection.driver_connection
            assert driver is not None
            driver.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    engine.dispose()
    return seed


def _everything(
    engine: Engine,
    settings: Settings,
    log: Path,
    world: World,
    therapist: str,
    patient_id: str,
    exercise_id: str,
    mark: str,
) -> dict[str, str]:
    subject = world.subjects[therapist]
    whole = upload_folder(settings) / f"{new_id()}.upload"
    whole.write_bytes(log.read_bytes())
    declaration = UploadIn(patient_id=patient_id, exercise_id=exercise_id, format="packet_log")
    job = register(engine, settings, subject, declaration, whole)
    done = run_job(engine, settings, job.id, upload)
    assert done is not None
    assert done.status == "complete", done.message
    session_id = job.session_id
    with unit_of_work(engine) as session:
        session.get_one(MotionSession, session_id).state = "analysed"
        session.add(
            SessionEvent(session_id=session_id, kind="mark", time_s=1.0, text=f"mark {mark}", details={})
        )
    wanted = TemplateIn(
        session_id=session_id, exercise_id=exercise_id, patient_id=patient_id, name=f"template {mark}"
    )
    with unit_of_work(engine) as session:
        version, content = recorded.prepare(session, subject, wanted)
        stored = recorded.store(session, subject, wanted, version, content)
    for_all = wanted.model_copy(update={"patient_id": None, "name": f"for all of {world.clinic_id}"})
    with unit_of_work(engine) as session:
        version, content = recorded.prepare(session, subject, for_all)
        clinic_template = recorded.store(session, subject, for_all, version, content)
    compared = comparisons.compare_session(
        engine, subject, session_id, ComparisonIn(template_version_id=stored.id)
    )
    with unit_of_work(engine) as session:
        prescription = _prescription(session, subject, patient_id, exercise_id, stored.template_id)
        grant = Grant(
            id=new_id(),
            patient_id=patient_id,
            account_id=subject.id,
            level="read",
            granted_by=subject.id,
            expires_at=None,
            revoked_at=None,
        )
        source = MagneticSource(
            id=new_id(),
            clinic_id=subject.clinic_id,
            serial="S-0",
            name=f"source {mark}",
            coils=[],
            current_limit_a=1.5,
            gain_sigma=0.01,
            found={},
            method="typed",
            calibrated_at=utc_now(),
            calibrated_by=subject.id,
        )
        session.add_all([grant, source])
        session.flush()
        result_id = session.get_one(MotionSession, session_id).main_result_id
        assert result_id is not None
        return {
            "patient_id": patient_id,
            "exercise_id": exercise_id,
            "session_id": session_id,
            "result_id": result_id,
            "job_id": job.id,
            "template_id": stored.template_id,
            "version_id": stored.id,
            "clinic_template_id": clinic_template.template_id,
            "comparison_id": compared.id,
            "prescription_id": prescription.id,
            "grant_id": grant.id,
            "source_id": source.id,
        }


def _prescription(
    session: Session, subject: Subject, patient_id: str, exercise_id: str, template_id: str
) -> Prescription:
    row = Prescription(
        id=new_id(),
        patient_id=patient_id,
        exercise_id=exercise_id,
        template_id=template_id,
        prescribed_by=subject.id,
        starts_at=utc_now(),
        ends_at=None,
    )
    session.add(row)
    session.flush()
    return row
