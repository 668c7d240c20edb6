"""Measures of a comparison are stored drawn together: what progress reads is what the repetitions give."""

import math

import numpy as np
import pytest
from sqlalchemy import delete, event, func, select

from app.assessment.course import scatter
from app.assessment.measures import session_values, store_drawn
from app.assessment.models import ALL_REPETITIONS, Comparison, ComparisonMeasure, RepetitionMeasure
from app.assessment.progress import progress
from app.database.unit_of_work import read_only, unit_of_work

from .history import History


@pytest.fixture
def history(engine, world):
    return History(engine, world)


def test_what_is_stored_is_what_the_repetitions_give(history):
    """To the last bit, of repetitions and of what only all of them together have."""
    generator = np.random.default_rng(2)
    for age, count in enumerate((1, 2, 3, 7, 60), start=1):
        history.session(age, generator.normal(40.0, 9.0, count).tolist())
    with unit_of_work(history.engine) as session:
        comparison = session.scalars(select(Comparison).where(Comparison.repetition_count == 7)).one()
        session.add(
            RepetitionMeasure(
                comparison_id=comparison.id,
                repetition=ALL_REPETITIONS,
                measure="multiple_correlation:x",
                value=0.9,
                uncertainty=0.03,
                unit="1",
            )
        )
        session.execute(delete(ComparisonMeasure).where(ComparisonMeasure.comparison_id == comparison.id))
        session.flush()
        store_drawn(session, comparison.id)
    with read_only(history.engine) as session:
        rows = session.execute(
            select(
                Comparison.session_id,
                RepetitionMeasure.measure,
                func.avg(RepetitionMeasure.value),
                func.avg(RepetitionMeasure.value * RepetitionMeasure.value),
                func.count(),
            )
            .join(Comparison, Comparison.id == RepetitionMeasure.comparison_id)
            .group_by(Comparison.session_id, RepetitionMeasure.measure)
        ).all()
    expected = {
        (of, name): (mean, math.sqrt(max(0.0, square - mean * mean) * n / (n - 1)) if n > 1 else None, n)
        for of, name, mean, square, n in rows
    }
    expected[comparison.session_id, "multiple_correlation:x"] = (0.9, 0.03, 7)
    with read_only(history.engine) as session:
        values = session_values(session, [history.world.patient_id])
    found = {(one.session_id, one.measure): (one.mean, one.spread, one.count) for one in values}
    assert found == expected


def test_progress_reads_a_row_a_measure_whatever_was_repeated(history, world, monkeypatch):
    """And no more statements for more sessions."""
    # A slow machine may not forget meanwhile what it learnt.
    monkeypatch.setattr(scatter, "_SHARE", 1e9)
    said, rows = [], []

    def note(_connection, cursor, statement, *_rest):
        said.append(statement)

    def read():
        said.clear()
        with unit_of_work(history.engine) as session:
            progress(session, world.subjects["therapist"], world.patient_id, world.exercise_id, "UTC")
        rows.append([one for one in said if "comparison_measure" in one])
        assert not [one for one in said if "repetition_measure" in one]
        return len(said)

    event.listen(history.engine, "before_cursor_execute", note)
    try:
        history.session(30, [1.0, 1.1])
        # The first look learns how much days of this clinic differ, and remembers it.
        read()
        rows.clear()
        few = read()
        for age in range(1, 20):
            history.session(age, [1.0, 1.1, 1.2])
        assert read() == few
    finally:
        event.remove(history.engine, "before_cursor_execute", note)
    assert [len(one) for one in rows] == [1, 1]
    with read_only(history.engine) as session:
        assert session.scalar(select(func.count()).select_from(ComparisonMeasure)) == 20
        assert session.scalar(select(func.count()).select_from(RepetitionMeasure)) == 59
