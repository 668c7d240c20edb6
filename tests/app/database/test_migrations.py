"""Migrations: from nothing to the models and back, on both databases."""

import json
import zlib

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import inspect, select, text
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
from app.recordings.models import Result
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


def test_what_was_practised_before_is_filled_in(empty_url):
    """Sessions as version 0005 left them: compared, compared and nothing kept, walked, tested, damaged, without any."""
    url, _ = empty_url
    migrate.upgrade(url, "0005_second_factor")
    engine = create_from_url(url)
    ids = {
        name: new_id()
        for name in ("compared", "empty", "walked", "tested", "cut", "bare", "template", "open")
    }
    strides = [{"duration_s": 1.1, "is_counted": True}, {"duration_s": 1.5, "is_counted": False}] * 3
    walk = {"feet": [{"strides": strides}, {"strides": []}], "test": {"kind": "walk", "time_s": 9.0}}
    walks = {"walked": walk, "tested": walk | {"test": {"kind": "timed_up_and_go", "time_s": 11.5}}}
    with engine.begin() as connection:
        for statement, rows in _sessions_of_0005(ids, walks):
            connection.execute(text(statement), rows)
    migrate.upgrade(url)
    assert differences(engine) == []
    with read_only(engine) as session:
        rows = session.execute(text("SELECT id, valid_repetitions, active_s FROM motion_session")).all()
    found = {one.id: (one.valid_repetitions, one.active_s) for one in rows}
    assert {name: found[of] for name, of in ids.items()} == {
        "compared": (2, pytest.approx(5.5)),
        "empty": (0, 0.0),
        "walked": (0, pytest.approx(3.3)),
        "tested": (0, 11.5),
        "cut": (None, None),
        "bare": (None, None),
        "template": (None, None),
        "open": (None, None),
    }
    migrate.downgrade(url, "0005_second_factor")
    migrate.upgrade(url)
    engine.dispose()


def test_what_progress_reads_is_filled_in(empty_url):
    """Of comparisons and of more walks than are read at once; a damaged one has none, and nothing else is lost."""
    url, _ = empty_url
    migrate.upgrade(url, "0005_second_factor")
    engine = create_from_url(url)
    walked = [f"walk {number}" for number in range(120)]
    ids = {name: new_id() for name in ("compared", "empty", *walked, "walked", "open", "cut", "shapeless")}

    def measure(name, value):
        return {"measure": name, "value": value, "sigma": 0.1, "spread": 0.2, "count": 9, "unit": "m"}

    def walk(number):
        length = 1.0 + number / 7.0
        return {
            "feet": [{"side": "left", "strides": [], "measures": [measure("stride_length", length)]}],
            "both": [measure("step_width", None), measure("walk_ratio", 0.1 + 0.2)],
            "asymmetry": [measure("stride_length", -0.01)],
            "test": {"kind": "timed_up_and_go", "time_s": 11.5},
            "balance": {"measures": [measure("margin", 0.05)]},
        }

    walks = {name: walk(number) for number, name in enumerate(walked)} | {
        "walked": walk(0),
        "shapeless": walk(0),
    }
    with engine.begin() as connection:
        for statement, rows in _sessions_of_0005(ids, walks):
            connection.execute(text(statement), rows)
    migrate.upgrade(url, "0017_attempt_count")
    together = "INSERT INTO repetition_measure (comparison_id, repetition, measure, value, uncertainty, unit)"
    with engine.begin() as connection:
        compared = connection.execute(text("SELECT MIN(comparison_id) FROM repetition_measure")).scalar_one()
        connection.execute(text(f"{together} VALUES (:of, 0, 'cmc', 0.5, 0.125, '1')"), {"of": compared})
        # Whole JSON, but no walk.
        connection.execute(
            text("UPDATE signal_chunk SET data = :data WHERE session_id = :of"),
            {"data": zlib.compress(b'{"feet": null}'), "of": ids["shapeless"]},
        )
    with engine.connect() as connection:
        drawn = connection.execute(
            text(
                "SELECT comparison_id, measure, MIN(unit), AVG(value), AVG(value * value), COUNT(*)"
                " FROM repetition_measure GROUP BY comparison_id, measure ORDER BY comparison_id, measure"
            )
        ).all()
    migrate.upgrade(url)
    with read_only(engine) as session:
        rows = session.execute(text("SELECT * FROM comparison_measure ORDER BY comparison_id, measure")).all()
        kept = dict(session.execute(select(Result.session_id, Result.followed)).all())
    assert len(drawn) == 7
    assert [tuple(row)[:6] for row in rows] == [tuple(row) for row in drawn]
    assert {
        (row.unit, row.mean, row.mean_square, row.repetitions, bool(row.is_of_all), row.uncertainty)
        for row in rows
    } == {("s", 2.75, 7.625, 2, False, None), ("1", 0.5, 0.25, 1, True, 0.125)}
    for number, name in enumerate(walked):
        assert kept[ids[name]] == [
            ["test_time", "s", 11.5, None, 1],
            ["stride_length:left", "m", 1.0 + number / 7.0, 0.2, 9],
            ["uneven:stride_length", "m", -0.01, 0.2, 9],
            ["walk_ratio", "m", 0.1 + 0.2, 0.2, 9],
            ["margin", "m", 0.05, 0.2, 9],
        ]
    assert sum(1 for rows in kept.values() if rows is not None) == 121, (
        "neither the damaged ones nor other kinds"
    )
    migrate.downgrade(url, "0017_attempt_count")
    migrate.upgrade(url)
    with read_only(engine) as session:
        assert dict(session.execute(select(Result.session_id, Result.followed)).all()) == kept
    engine.dispose()


def _sessions_of_0005(ids, walks):
    """Rows by plain SQL: the models have gone on since."""
    now, by = "2026-01-01 10:00:00+00:00", new_id()
    clinic, patient, exercise, template, version = (new_id() for _ in range(5))
    yield (
        "INSERT INTO clinic (id, name, created_at) VALUES (:id, 'C', :now)",
        [{"id": clinic, "now": now}],
    )
    yield (
        "INSERT INTO account (id, clinic_id, role, email, display_name, is_active, locale, created_at)"
        " VALUES (:id, :clinic, 'therapist', 't@c.example', 'T', :yes, 'en', :now)",
        [{"id": by, "clinic": clinic, "yes": True, "now": now}],
    )
    yield (
        "INSERT INTO patient (id, clinic_id, given_name, family_name, notes, body_dimensions, created_at)"
        " VALUES (:id, :clinic, 'A', 'B', '', '{}', :now)",
        [{"id": patient, "clinic": clinic, "now": now}],
    )
    yield (
        "INSERT INTO exercise (id, clinic_id, name, description, movement, side, primary_angle, created_at)"
        " VALUES (:id, :clinic, 'E', '', 'reaching', 'right', 'x', :now)",
        [{"id": exercise, "clinic": clinic, "now": now}],
    )
    yield (
        "INSERT INTO template (id, clinic_id, exercise_id, name, created_by, created_at)"
        " VALUES (:id, :clinic, :exercise, 'T', :by, :now)",
        [{"id": template, "clinic": clinic, "exercise": exercise, "by": by, "now": now}],
    )
    yield (
        "INSERT INTO template_version (id, template_id, number, source_session_id, source_result_id, repetitions,"
        " tolerance_scale, content, is_published, created_by, created_at)"
        " VALUES (:id, :template, 1, :id, :id, '[]', '{}', :none, :yes, :by, :now)",
        [{"id": version, "template": template, "none": b"", "yes": True, "by": by, "now": now}],
    )
    sessions = [
        {
            "id": of,
            "clinic": clinic,
            "patient": patient,
            "exercise": exercise,
            "purpose": "template" if name == "template" else "exercise",
            "state": "recording" if name == "open" else "analysed",
            "main": new_id(),
            "now": now,
        }
        for name, of in ids.items()
    ]
    yield (
        "INSERT INTO motion_session (id, clinic_id, patient_id, exercise_id, purpose, source, state, state_reason,"
        " setup, created_by, packets_stored, packets_missing, duration_s, main_result_id, created_at)"
        " VALUES (:id, :clinic, :patient, :exercise, :purpose, 'stream', :state, '', '{}', :id, 0, 0, 60.0, :main,"
        " :now)",
        sessions,
    )
    results = [{"id": one["main"], "of": one["id"], "now": now} for one in sessions]
    compared, empty = results[0], results[1]
    older = {"id": new_id(), "of": compared["of"], "now": now}
    yield (
        "INSERT INTO result (id, session_id, kind, pipeline, pipeline_version, orientation, orientation_version,"
        " setup, layout, status, progress, message, created_at)"
        " VALUES (:id, :of, 'offline', 'arm', '1', 'vqf', '1', '{}', '{}', 'complete', 1.0, '', :now)",
        [*results, older],
    )
    # An earlier comparison, one of another result, and the newest, which counts.
    comparisons = [
        {
            "id": new_id(),
            "of": of,
            "result": result,
            "count": count,
            "version": version,
            "none": b"",
            "at": at,
        }
        for of, result, count, at in [
            (compared["of"], compared["id"], 9, "2026-01-01 10:00:00+00:00"),
            (compared["of"], compared["id"], 2, "2026-01-02 10:00:00+00:00"),
            (compared["of"], older["id"], 7, "2026-01-03 10:00:00+00:00"),
            (empty["of"], empty["id"], 0, "2026-01-01 10:00:00+00:00"),
            (ids["open"], results[-1]["id"], 3, "2026-01-01 10:00:00+00:00"),
        ]
    ]
    yield (
        "INSERT INTO comparison (id, session_id, result_id, template_version_id, version, repetition_count, summary,"
        " content, created_at) VALUES (:id, :of, :result, :version, '1', :count, '{}', :none, :at)",
        comparisons,
    )
    yield (
        "INSERT INTO repetition_measure (comparison_id, repetition, measure, value, unit)"
        " VALUES (:of, :number, :measure, :value, 's')",
        [
            {"of": one["id"], "number": number, "measure": measure, "value": value}
            for one in comparisons[:3]
            for number, value in ((1, 2.5), (2, 3.0))
            for measure in ("duration", "duration_ratio")
        ],
    )
    data = {name: zlib.compress(json.dumps(walk).encode()) for name, walk in walks.items()}
    data["cut"] = data["walked"][:-9]
    mains = {one["id"]: one["main"] for one in sessions}
    yield (
        "INSERT INTO signal_chunk (session_id, stream, sequence, start_ns, ticks, codec, scale, crc, data)"
        " VALUES (:of, :stream, 0, 0, 2, 'json.zlib', '{}', 0, :data)",
        [
            {"of": ids[name], "stream": f"gait/{mains[ids[name]]}", "data": content}
            for name, content in data.items()
        ],
    )
