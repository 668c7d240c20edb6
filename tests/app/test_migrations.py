"""Migrations: from nothing to the models and back, on both databases."""

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import inspect, text
from sqlalchemy.exc import DBAPIError

from app.accounts import audit
from app.accounts.models import Clinic
from app.accounts.subject import Subject
from app.database import backup as backups
from app.database import migrate
from app.database.base import new_id
from app.database.engine import create_from_url
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict
from app.tables import metadata


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.postgres)])
def empty_url(request, tmp_path):
    """Addresses of two empty databases of one kind."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'fresh.db'}", f"sqlite:///{tmp_path / 'second.db'}"
    new_database = request.getfixturevalue("postgresql_database")
    return new_database(), new_database()


def differences(engine):
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        return compare_metadata(context, metadata)


def test_fresh_upgrade_makes_exactly_the_models(empty_url):
    url, _ = empty_url
    migrate.upgrade(url)
    engine = create_from_url(url)
    migrate.require_newest(engine)
    assert differences(engine) == []
    migrate.upgrade(url)
    engine.dispose()


def test_downgrade_leaves_nothing_behind_and_can_be_repeated(empty_url):
    url, _ = empty_url
    migrate.upgrade(url)
    migrate.downgrade(url, "base")
    engine = create_from_url(url)
    assert inspect(engine).get_table_names() == ["alembic_version"]
    with pytest.raises(Conflict, match="telemotion migrate"):
        migrate.require_newest(engine)
    migrate.upgrade(url)
    assert differences(engine) == []
    engine.dispose()


def test_drift_would_be_seen(engine):
    with engine.begin() as connection:
        connection.execute(text("ALTER TABLE patient ADD COLUMN shoe_size INTEGER"))
        connection.execute(text("DROP INDEX ix_patient_clinic_id"))
    assert {change[0] for change in differences(engine)} == {"remove_column", "add_index"}


def test_the_database_refuses_changes_of_the_audit_trail(empty_url):
    url, _ = empty_url
    migrate.upgrade(url)
    engine = create_from_url(url)
    clinic_id = fill(engine)
    for statement in ("UPDATE audit_event SET action = 'nothing'", "DELETE FROM audit_event"):
        with pytest.raises(DBAPIError, match="append-only"), engine.begin() as connection:
            connection.execute(text(statement))
    with read_only(engine) as session:
        assert audit.verify(session, clinic_id).is_intact
    engine.dispose()


def test_backup_moves_between_databases(empty_url, tmp_path):
    url, second = empty_url
    migrate.upgrade(url)
    engine = create_from_url(url)
    clinic_id = fill(engine)
    path = tmp_path / "backup.zip"
    backups.backup(engine, path)
    engine.dispose()
    for target in (second, f"sqlite:///{tmp_path / 'elsewhere.db'}"):
        manifest = backups.restore(path, target)
        restored = create_from_url(target)
        with read_only(restored) as session:
            assert audit.verify(session, clinic_id, manifest.audit_heads[clinic_id]).is_intact
        with unit_of_work(restored) as session:
            audit.record(session, Subject.system(clinic_id), "test.again")
        restored.dispose()


def fill(engine):
    clinic_id = new_id()
    with unit_of_work(engine) as session:
        session.add(Clinic(id=clinic_id, name="Clinic"))
    for number in range(3):
        with unit_of_work(engine) as session:
            audit.record(session, Subject.system(clinic_id), "test.event", details={"number": number})
    return clinic_id
