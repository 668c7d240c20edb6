"""What is said of a change, through the service: words, the clinic's scatter, breaks, declines, earlier reports."""

import re
from dataclasses import replace
from datetime import UTC, timedelta
from zoneinfo import ZoneInfo

import numpy as np
import pytest

from app.assessment.course.days import days_of
from app.assessment.course.judgement import decline_of, judged
from app.assessment.course.published import PUBLISHED, published_of
from app.assessment.course.scatter import Scatters, learnt_of
from app.assessment.measures import session_values
from app.database.base import utc_now
from app.database.unit_of_work import read_only
from estimators.progress import NO_PRIOR, Scatter

from .history import MEASURE, History

OPENS = (39.0, 44.0, 50.0, 54.0, 54.0, 59.0)
AGES = (24.2, 20.1, 15.0, 9.3, 4.1, 1.2)


@pytest.fixture
def history(engine, world):
    return History(engine, world)


@pytest.fixture
def pattern(history):
    """Return a value of which others are made."""
    history.session(1, [1.0, 1.2])
    with read_only(history.engine) as session:
        (found,) = session_values(session, [history.world.patient_id])
    return replace(found, unit="deg")


def series(pattern, means, spread=2.0, every_days=2.0, **fields):
    noon = utc_now().replace(hour=12)
    return [
        replace(
            pattern,
            at=noon - timedelta(days=every_days * (len(means) - 1 - number)),
            session_id=str(number),
            mean=float(mean),
            spread=spread,
            count=6,
            **fields,
        )
        for number, mean in enumerate(means)
    ]


def said(values, prior=NO_PRIOR, measure=MEASURE):
    scatters = Scatters("reach_forward", {re.sub("left|right", "side", measure): prior})
    named = [replace(value, measure=measure) for value in values]
    return judged({measure: named}, measure, scatters, UTC)[measure]


def test_an_elbow_that_opens_more_reads_so(history, therapist, world):
    """39 to 59 degrees in six sessions, each within two: the scatter of the first sessions is her improvement."""
    for age, mean in zip(AGES, OPENS, strict=True):
        history.session(age, np.radians([mean - 2.0, mean + 2.0]))
    (measure,) = therapist.get(f"/api/patients/{world.patient_id}/progress").json()["measures"]
    trend = measure["trend"]
    assert trend["word"] == "more"
    assert np.degrees(trend["change"]) >= 15.0
    assert trend["change"] == pytest.approx(trend["now"] - trend["start"])
    assert np.degrees(trend["minimal_detectable_change"]) < 6.0
    assert trend["probability"] > 0.975


def test_a_report_says_what_was_known_with_its_session(history, therapist, world):
    ids = [
        history.session(age, np.radians([mean - 2.0, mean + 2.0]))
        for age, mean in zip(AGES, OPENS, strict=True)
    ]
    path = f"/api/patients/{world.patient_id}/progress"
    (measure,) = therapist.get(path, params={"until": ids[2]}).json()["measures"]
    assert [point["session_id"] for point in measure["points"]] == ids[:3]
    assert measure["trend"]["word"] == "values"
    (measure,) = therapist.get(path, params={"until": "0" * 32}).json()["measures"]
    assert len(measure["points"]) == 6


def test_unchanged_is_said_of_a_narrow_interval_only(pattern):
    rng = np.random.default_rng(5)
    few = series(pattern, 50.0 + 4.0 * rng.normal(size=4))
    assert said(few).word in ("unknown", "probably_more", "probably_less")
    many = series(pattern, 50.0 + np.array([1.0, -1.0, -0.5, 0.5] * 6))
    found = said(many, Scatter(1.0, 10.0))
    assert found.word == "unchanged"
    assert abs(found.change) + found.half_width <= found.minimal_detectable_change


def test_a_sure_change_below_what_matters_is_little(pattern):
    means = 0.9 + 0.003 * np.arange(10) + 0.001 * (-1.0) ** np.arange(10)
    values = series(pattern, means, spread=0.001)
    found = said([replace(one, unit="m/s") for one in values], Scatter(1e-6, 10.0), "walk:speed:left")
    assert (found.word, found.important) == ("a_little_more", 0.05)
    assert "Perera" in found.important_source


def test_published_figures_stand_in_until_there_are_own(pattern):
    values = series(pattern, 0.9 + 0.01 * np.random.default_rng(0).normal(size=6), spread=0.001)
    own = Scatters("walk", {})
    found = judged(
        {"walk:speed:left": [replace(one, measure="walk:speed:left") for one in values]}, None, own, UTC
    )["walk:speed:left"]
    assert (found.scatter_people, "Flansbjer" in found.scatter_source) == (50, True)
    assert found.scatter == pytest.approx(0.07, abs=0.02)
    assert all(one.scatter_source for one in PUBLISHED)
    assert published_of("walk:test_time", "walk") is None
    assert published_of("walk:speediness", "walk") is None
    assert published_of(MEASURE, "reach_forward") is None


def test_the_clinic_teaches_both_sides_together(pattern):
    rng = np.random.default_rng(9)
    values = [
        one
        for number in range(40)
        for one in series(
            pattern,
            50.0 + number + 3.0 * rng.normal(size=12),
            patient_id=f"{number:02}",
            measure=MEASURE if number % 2 else MEASURE.replace("right", "left"),
        )
    ]
    learnt = learnt_of(values, UTC)
    assert list(learnt) == [MEASURE.replace("right", "side")]
    (found,) = learnt.values()
    assert (np.sqrt(found.variance), found.people) == (pytest.approx(3.0, rel=0.15), 40)
    assert learnt_of(values[:12], UTC)[MEASURE.replace("right", "side")] == NO_PRIOR


def test_another_estimator_template_or_placement_is_a_break(pattern):
    values = series(pattern, [50.0, 51.0, 50.0, 51.0, 60.0, 61.0, 60.0, 61.0])
    changes = {
        "estimator": {"orientation_version": "3"},
        "template": {"template_id": "other"},
        "placement": {"placements": ("forearm_right",)},
    }
    before = [replace(one, placements=("hand_right",)) for one in values]
    assert said(before).word == "more"
    for kind, fields in changes.items():
        found = said([*before[:4], *(replace(one, **fields) for one in before[4:])])
        assert [(one.kind, one.at) for one in found.breaks] == [(kind, values[4].at)]
        assert found.word != "more"
    unknown = [*before[:4], *(replace(one, placements=()) for one in before[4:])]
    assert said(unknown).breaks == []


def test_a_new_version_breaks_only_what_is_measured_against_it(pattern):
    values = series(pattern, [50.0, 51.0, 50.0, 51.0, 50.0, 51.0])
    newer = [*values[:3], *(replace(one, template_version_id="2") for one in values[3:])]
    assert said(newer).breaks == []
    assert [one.kind for one in said(newer, measure="shape_deviation").breaks] == ["template"]


def test_sessions_of_one_day_are_one_value(pattern):
    """By the clocks of the clinic: 23:30 and 00:30 in Berlin are two days, 12:00 and 18:00 one."""
    at = utc_now().replace(month=1, day=15, hour=22, minute=30)
    late = [
        replace(pattern, at=at + timedelta(hours=hours), mean=mean) for hours, mean in ((0, 1.0), (1, 2.0))
    ]
    assert days_of(late, ZoneInfo("Europe/Berlin")).values.tolist() == [1.0, 2.0]
    assert days_of(late, ZoneInfo("America/New_York")).values.tolist() == [1.5]


def test_an_unusual_day_is_said_and_changes_nothing(pattern):
    rng = np.random.default_rng(1)
    values = series(pattern, [*(50.0 + rng.normal(size=9)), 62.0])
    found = said(values, Scatter(1.0, 10.0))
    assert found.is_last_day_unusual
    assert found.expected == pytest.approx(50.0, abs=2.0)
    assert found.until == values[-2].at
    assert found.word not in ("more", "less")


def test_a_decline_is_raised_as_probable(pattern):
    rng = np.random.default_rng(6)
    prior = Scatters("reach_forward", {MEASURE.replace("right", "side"): Scatter(4.0, 10.0)})
    falling = series(pattern, 60.0 - np.arange(10) + 2.0 * rng.normal(size=10))
    found = decline_of(falling, prior, UTC)
    assert found is not None
    assert found.trend.probability <= 0.05
    assert found.text.code == "caseload.declining_angle"
    assert "probably" in found.text
    assert decline_of(series(pattern, 60.0 + np.arange(10)), prior, UTC) is None
    assert decline_of(series(pattern, 60.0 + rng.normal(size=10)), prior, UTC) is None
    assert decline_of([], prior, UTC) is None


def test_others_than_the_main_measure_are_judged_together(pattern):
    """Of forty measures in which nothing changes hardly one is said to have changed."""
    rng = np.random.default_rng(8)
    names = [f"measure_{number}" for number in range(40)]
    changed = 0
    for _ in range(4):
        values = {name: series(pattern, 50.0 + 4.0 * rng.normal(size=10), measure=name) for name in names}
        found = judged(values, names[0], Scatters("", dict.fromkeys(names, Scatter(16.0, 10.0))), UTC)
        changed += sum(found[name].word in ("more", "less") for name in names[1:])
    assert changed <= 2
