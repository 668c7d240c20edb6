"""What progress shows values beside, and what it costs: other side, published values, statements that do not grow."""

from datetime import date, timedelta
from typing import Any

import numpy as np
import pytest
from sqlalchemy import event

from app.assessment.course import scatter
from app.assessment.course.bands import beside_other_side
from app.assessment.course.norms import norm_of
from app.assessment.schemas import MeasureValue
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Exercise
from app.patients.models import Patient

from ..conftest import make_exercise
from .history import MEASURE, History

PATH = "/api/patients/{}/progress"


@pytest.fixture
def history(engine, world):
    return History(engine, world)


def progress(client, world, exercise_id=None) -> dict[str, Any]:
    wanted = {"exercise_id": exercise_id or world.exercise_id}
    return client.get(PATH.format(world.patient_id), params=wanted).json()


def with_twin(history, world, affected="right") -> str:
    """Give the patient an affected side and the exercise a twin for the other; return the twin."""
    with unit_of_work(history.engine) as session:
        own = session.get_one(Exercise, world.exercise_id)
        twin = make_exercise(session, world.clinic_id, "Reach, left")
        twin.side, twin.movement = "left", own.movement
        twin.primary_angle = own.primary_angle.replace("right", "left")
        session.get_one(Patient, world.patient_id).affected_side = affected
        return twin.id


def test_the_other_side_is_a_band_with_symmetry(history, therapist, world):
    """40 on the affected right side, 50 on the left: ln 0.8, and an angle of -7.04 %, for the left is larger."""
    twin = with_twin(history, world)
    mirrored = MEASURE.replace("right", "left")
    history.session(9, [20.0, 22.0], measure=mirrored, exercise_id=twin)
    history.session(8, [49.0, 51.0], measure=mirrored, exercise_id=twin)
    history.session(7, [40.0, 40.0])
    (measure,) = progress(therapist, world)["measures"]
    (band,) = measure["bands"]
    assert band["kind"] == "other_side"
    assert (band["low"], band["high"]) == pytest.approx((50 - np.sqrt(2), 50 + np.sqrt(2)))
    assert band["value"] == pytest.approx(50.0)
    assert band["symmetry_ratio"] == pytest.approx(-0.2231, abs=1e-4)
    assert band["symmetry_angle_percent"] == pytest.approx(-7.04, abs=0.005)
    # The standard error of 49 and 51 is 1.
    assert band["symmetry_ratio_sigma"] == pytest.approx(1 / 50)
    assert "left" in band["text"]
    assert band["sentences"]["text"]["code"] == "progress.other_side"


def test_a_comparison_stands_beside_the_newest_session_of_the_other_side(history, world):
    """As above, of one session's own summary; what the other side never did is left out."""
    twin = with_twin(history, world)
    mirrored = MEASURE.replace("right", "left")
    history.session(9, [20.0, 22.0], measure=mirrored, exercise_id=twin)
    history.session(8, [49.0, 51.0], measure=mirrored, exercise_id=twin)

    def summary(measure: str, value: float | None) -> MeasureValue:
        return MeasureValue(
            measure=measure,
            label="Elevation",
            value=value,
            unit="rad",
            uncertainty=2.0,
            count=4,
            template_value=60.0,
            group="range",
        )

    with read_only(history.engine) as session:
        patient = session.get_one(Patient, world.patient_id)
        own, other = (session.get_one(Exercise, one) for one in (world.exercise_id, twin))
        (found,) = beside_other_side(
            session, patient, own, [summary(MEASURE, 40.0), summary("duration", 3.0)]
        )
        assert beside_other_side(session, patient, own, [summary(MEASURE, None)]) == []
        assert beside_other_side(session, patient, other, [summary(mirrored, 40.0)]) == []
    assert (found.value, found.other_value, found.other_count) == pytest.approx((40.0, 50.0, 2))
    assert found.symmetry_ratio == pytest.approx(-0.2231, abs=1e-4)
    assert found.symmetry_angle_percent == pytest.approx(-7.04, abs=0.005)
    # Standard errors of 1 in 40 and of 1 in 50.
    assert found.symmetry_ratio_sigma == pytest.approx(np.hypot(1 / 40, 1 / 50))


def test_symmetry_of_what_may_be_nothing_is_unknown(history, therapist, world):
    twin = with_twin(history, world)
    history.session(8, [0.5, 5.5], measure=MEASURE.replace("right", "left"), exercise_id=twin)
    history.session(7, [40.0, 41.0])
    (band,) = progress(therapist, world)["measures"][0]["bands"]
    assert (band["symmetry_ratio"], band["symmetry_angle_percent"]) == (None, None)


@pytest.mark.parametrize("affected", ["left", "both", None])
def test_no_other_side_where_this_one_is_not_the_affected(history, therapist, world, affected):
    twin = with_twin(history, world, affected)
    history.session(8, [50.0, 51.0], measure=MEASURE.replace("right", "left"), exercise_id=twin)
    history.session(7, [40.0, 41.0])
    assert progress(therapist, world)["measures"][0]["bands"] == []


def test_norms_are_by_age_and_name_their_source():
    """As the abstract prints them: 8.1 (7.1-9.0), 9.2 (8.2-10.2) and 11.3 (10.0-12.7) s."""
    on = date(2026, 6, 1)
    found = {
        years: norm_of("walk:test_time", date(2026 - years, 6, 1), on) for years in (59, 60, 69, 70, 80, 99)
    }
    assert found[59] is None
    bounds = {years: (one.low, one.high) for years, one in found.items() if one}
    assert bounds == {60: (7.1, 9.0), 69: (7.1, 9.0), 70: (8.2, 10.2), 80: (10.0, 12.7), 99: (10.0, 12.7)}
    assert "Bohannon" in found[60].source
    assert norm_of("walk:test_time", date(1966, 6, 2), on) is None, "sixty tomorrow"
    assert norm_of("walk:test_time", None, on) is None
    assert norm_of("range:x", date(1960, 1, 1), on) is None


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_of_three_days_or_fewer_only_values_are_shown(history, therapist, world, count):
    for age in range(count, 0, -1):
        history.session(age, [50.0 + age, 51.0 + age])
    (measure,) = progress(therapist, world)["measures"]
    trend = measure["trend"]
    assert trend["days"] == count
    assert (trend["word"] == "values") is (count <= 3)
    assert (trend["change"] is None) is (count <= 3)


def test_statements_do_not_grow_with_sessions(history, therapist, world, engine, monkeypatch):
    """Nor do the caseload's, nor those by which a clinic's scatter is learnt, here anew each time."""
    monkeypatch.setattr(scatter, "_SHARE", 0.0)
    statements: list[str] = []

    def note(*told: Any) -> None:
        # Not the service's own, such as the check each second that it can store.
        if any(table in told[2] for table in ("motion_session", "exercise", "template", "prescription")):
            statements.append(told[2])

    watched = therapist.app.state.services.engine
    event.listen(watched, "before_cursor_execute", note)

    def counted(path: str) -> int:
        counts = []
        for _ in range(3):
            statements.clear()
            assert therapist.get(path).status_code == 200
            counts.append(len(statements))
        return min(counts)

    paths = (PATH.format(world.patient_id), "/api/caseload")
    try:
        with_twin(history, world)
        history.prescribe(30)
        for age in (29, 28, 27, 26):
            history.session(age, [50.0, 51.0])
        few = [counted(path) for path in paths]
        for hour in range(30):
            history.session_at(utc_now() - timedelta(days=20, hours=-hour), [50.0, 51.0])
        assert [counted(path) for path in paths] == few
    finally:
        event.remove(watched, "before_cursor_execute", note)
    assert max(few) < 25
