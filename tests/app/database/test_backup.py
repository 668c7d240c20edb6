"""Backup and restore: everything comes back, nothing half-written is taken for a backup."""

import stat
import zipfile

import pytest
from sqlalchemy import select, text

from app.accounts import audit
from app.accounts.credentials.sign_in import create_sign_in
from app.accounts.models import AuditEvent, Clinic, SignIn
from app.database import backup as backups
from app.database.engine import create_from_url
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, RecordingFormatError
from app.patients.models import Patient
from app.recordings.models import MotionSession, SignalChunk


@pytest.fixture
def filled(engine, world, settings):
    with unit_of_work(engine) as session:
        motion = MotionSession(
            id="a" * 32,
            clinic_id=world.clinic_id,
            patient_id=world.patient_id,
            setup={"rate_hz": 100.0, "placements": ["hand_right"]},
            created_by=world.accounts["therapist"],
        )
        session.add(motion)
        session.flush()
        for sequence in range(3):
            session.add(
                SignalChunk(
                    session_id=motion.id,
                    stream="raw",
                    sequence=sequence,
                    start_ns=sequence * 10**9,
                    ticks=100,
                    codec="test",
                    scale={"gyroscope": 0.001},
                    crc=1,
                    data=bytes(range(256)) * 10,
                )
            )
        create_sign_in(session, settings, world.accounts["therapist"], "tests")
        audit.record(session, world.subjects["therapist"], "patient.read", world.patient_id)
        audit.record(session, world.subjects["foreign_therapist"], "patient.read", world.foreign_patient_id)
    return engine


def test_everything_comes_back(filled, tmp_path, world):
    path = tmp_path / "backup.zip"
    manifest = backups.backup(filled, path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert not list(tmp_path.glob("*.unfinished"))
    target = f"sqlite:///{tmp_path / 'restored.db'}"
    assert backups.restore(path, target) == manifest
    restored = create_from_url(target)
    with read_only(filled) as before, read_only(restored) as after:
        for model in (Clinic, Patient, MotionSession, SignalChunk, AuditEvent):
            columns = list(model.__table__.columns)
            query = select(*columns).order_by(*model.__table__.primary_key.columns)
            assert after.execute(query).all() == before.execute(query).all(), model
        assert after.scalars(select(SignIn)).all() == []
        for clinic_id in (world.clinic_id, world.foreign_clinic_id):
            report = audit.verify(after, clinic_id, manifest.audit_heads[clinic_id])
            assert report.is_intact
            assert report.events == 1
    with unit_of_work(restored) as session:
        audit.record(session, world.subjects["therapist"], "patient.read", world.patient_id)
    restored.dispose()


def test_a_database_in_use_is_not_overwritten(filled, tmp_path, settings):
    path = tmp_path / "backup.zip"
    backups.backup(filled, path)
    with pytest.raises(Conflict):
        backups.restore(path, settings.database_url)


@pytest.mark.parametrize("damage", ["cut", "changed", "empty", "other"])
def test_damage_is_found_before_anything_is_written(filled, tmp_path, damage):
    path = tmp_path / "backup.zip"
    backups.backup(filled, path)
    whole = path.read_bytes()
    if damage == "cut":
        path.write_bytes(whole[: len(whole) // 2])
    elif damage == "changed":
        place = whole.index(bytes(range(100, 200)))
        path.write_bytes(whole[:place] + b"\0" + whole[place + 1 :])
    elif damage == "empty":
        path.write_bytes(b"")
    else:
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("manifest.json", '{"format": "something else"}')
    target = tmp_path / "restored.db"
    with pytest.raises(RecordingFormatError):
        backups.restore(path, f"sqlite:///{target}")
    assert not target.exists()


def test_a_backup_of_a_newer_version_says_so(filled, tmp_path, monkeypatch):
    path = tmp_path / "backup.zip"
    with filled.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999_future'"))
    backups.backup(filled, path)
    with pytest.raises(RecordingFormatError, match="newer version"):
        backups.restore(path, f"sqlite:///{tmp_path / 'restored.db'}")
