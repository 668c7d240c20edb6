"""Transactions: who may write, when it is stored, and that writers wait instead of failing."""

import threading

import pytest
from sqlalchemy import select, text
from sqlalchemy.exc import OperationalError

from app.accounts.models import Clinic
from app.database.unit_of_work import read_only, unit_of_work


def names(engine):
    with read_only(engine) as session:
        return set(session.scalars(select(Clinic.name)))


def test_a_unit_commits_whole_or_not_at_all(engine):
    with unit_of_work(engine) as session:
        session.add(Clinic(name="kept"))
    with pytest.raises(ValueError, match="later"), unit_of_work(engine) as session:  # noqa: PT012
        session.add(Clinic(name="lost"))
        session.flush()
        raise ValueError("later")
    assert names(engine) == {"kept"}


def test_reading_units_refuse_changes_in_python_and_in_the_database(engine):
    with pytest.raises(RuntimeError, match="only reads"), read_only(engine) as session:  # noqa: PT012
        session.add(Clinic(name="sneaked in"))
        session.flush()
    with pytest.raises(OperationalError, match="readonly"), read_only(engine) as session:
        session.execute(text("DELETE FROM clinic"))
    with unit_of_work(engine) as session:
        session.add(Clinic(name="after"))
    assert names(engine) == {"after"}, "the connection writes again after it was used for reading"


def test_a_reader_sees_one_moment_and_does_not_wait_for_a_writer(engine):
    with unit_of_work(engine) as session:
        session.add(Clinic(name="one"))
    with read_only(engine) as reader, unit_of_work(engine) as writer:
        assert set(reader.scalars(select(Clinic.name))) == {"one"}
        writer.add(Clinic(name="two"))
        writer.flush()
        writer.commit()
        assert set(reader.scalars(select(Clinic.name))) == {"one"}
    assert names(engine) == {"one", "two"}


def test_units_that_read_first_and_write_later_do_not_collide(engine):
    with unit_of_work(engine) as session:
        session.add(Clinic(id="c", name="0"))
    errors = []

    def count_up():
        try:
            for _ in range(20):
                with unit_of_work(engine) as session:
                    clinic = session.get_one(Clinic, "c")
                    clinic.name = str(int(clinic.name) + 1)
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=count_up) for _ in range(5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert names(engine) == {"100"}, "no update was lost"


def test_sqlite_is_set_up_as_promised(engine):
    with read_only(engine) as session:
        pragmas = {
            name: session.execute(text(f"PRAGMA {name}")).scalar()
            for name in ("journal_mode", "foreign_keys", "synchronous", "busy_timeout")
        }
    assert pragmas == {"journal_mode": "wal", "foreign_keys": 1, "synchronous": 1, "busy_timeout": 15000}


def test_errors_of_the_database_do_not_quote_values(engine):
    with pytest.raises(Exception) as caught, unit_of_work(engine) as session:
        session.execute(
            text("INSERT INTO clinic (id, name, created_at) VALUES (:i, :n, NULL)"),
            {"i": "x", "n": "Ada Lindqvist"},
        )
    assert "Ada" not in str(caught.value)
