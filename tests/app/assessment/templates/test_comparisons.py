"""From a patient's session to its comparison with what was prescribed."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.accounts.models import AuditEvent
from app.assessment.models import Comparison, ComparisonMeasure, RepetitionMeasure
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Exercise
from app.recordings.models import Job, MotionSession
from estimators.simulation import ArmScenario, Schedule, SimulatedSession, simulate_arm

from .conftest import ARM, MAIN

pytestmark = pytest.mark.usefixtures("quiet_queue")


def prescribe(therapist: Any, world: Any, template_id: str) -> str:
    answer = therapist.post(
        f"/api/patients/{world.patient_id}/prescriptions",
        json={"exercise_id": world.exercise_id, "template_id": template_id},
    )
    assert answer.status_code in {200, 201}, answer.text
    return str(answer.json()["id"])


def assert_further_measures(summary: dict[str, Any]) -> None:
    """Slower, smaller, more of the trunk: what the other measures make of it, with units that people read."""
    for name, unit, group in (
        ("mean_speed", "m/s", "path"),
        ("time_to_peak_speed", "%", "timing"),
        ("units_per_metre", "1/m", "smoothness"),
        ("log_dimensionless_jerk", "1", "smoothness"),
        ("joint_correlation", "1", "coordination"),
        ("joint_lag", "ms", "coordination"),
        ("path_residual", "m", "path"),
        ("path_turn", "deg", "path"),
        ("path_scale", "1", "path"),
    ):
        found = summary[name]
        assert (found["unit"], found["group"]) == (unit, group)
        assert found["value"] is not None, name
        assert found["uncertainty"] is not None, name
    assert summary["mean_speed"]["value"] < 0.7 * summary["mean_speed"]["template_value"]
    assert summary["path_scale"]["value"] > 1.1, "the smaller path is made larger"
    alike = summary[MAIN.replace("range:", "multiple_correlation:")]
    assert (alike["count"], alike["note"]) == (4, "")
    assert 0.5 < alike["value"] <= 1.0


def test_a_closed_session_is_compared_with_what_was_prescribed(
    therapist: Any,
    patient: Any,
    world: Any,
    store: Any,
    patients: SimulatedSession,
    template_version: dict[str, Any],
    engine: Engine,
) -> None:
    prescription = prescribe(therapist, world, template_version["template_id"])
    session_id = store(patients, "patient", prescription_id=prescription)
    shown = patient.get(f"/api/sessions/{session_id}").json()
    assert shown["state"] == "analysed"
    (listed,) = patient.get(f"/api/sessions/{session_id}/comparisons").json()
    assert listed["template_name"] == "Reach, my way"
    assert listed["repetition_count"] == 4
    detail = patient.get(f"/api/comparisons/{listed['id']}").json()
    summary = {m["measure"]: m for m in detail["summary"]}
    assert detail["summary"] == listed["summary"]

    # The truth of both simulations, in the units that people read.
    def true_range(simulated: SimulatedSession, name: str) -> float:
        values = np.degrees(simulated.truth.angle_rad(name))
        step = 100
        spans = [np.ptp(values[round(a * step) : round(b * step)]) for a, b in simulated.truth.repetitions_s]
        return float(np.mean(spans))

    main = summary[MAIN]
    assert (main["unit"], main["count"], main["group"]) == ("deg", 4, "range")
    assert main["label"] == "Shoulder elevation, range of motion"
    assert main["value"] == pytest.approx(true_range(patients, MAIN.removeprefix("range:")), abs=4.0)
    assert main["uncertainty"] is not None
    duration = summary["duration"]
    assert duration["unit"] == "s"
    lengths = np.diff(patients.truth.repetitions_s, axis=1)
    assert duration["value"] == pytest.approx(float(lengths.mean()), abs=0.4)
    assert duration["value"] > duration["template_value"] * 1.2
    lean = summary["compensation:trunk_lean_forward_rad"]
    assert (lean["unit"], lean["group"]) == ("deg", "compensation")
    assert lean["value"] == pytest.approx(true_range(patients, "trunk_lean_forward_rad"), abs=3.0)
    assert lean["value"] > lean["template_value"] + 5.0
    assert_further_measures(summary)
    assert detail["findings"]
    for one in detail["repetitions"]:
        warp = one["warp_template_phase"]
        assert len(warp) == 101
        assert all(a <= b for a, b in pairwise(warp))
        assert all(0 <= a < b <= 101 for spans in one["outside_band"].values() for a, b in spans)
    assert len(detail["curves"][0]["repetitions"]) == 4
    with read_only(engine) as session:
        rows = session.scalars(select(RepetitionMeasure).where(RepetitionMeasure.measure == MAIN)).all()
        drawn = session.scalars(select(ComparisonMeasure).where(ComparisonMeasure.measure == MAIN)).one()
        every = [set(session.scalars(select(one.measure))) for one in (ComparisonMeasure, RepetitionMeasure)]
    assert every[0] == every[1]
    assert (drawn.mean, drawn.repetitions, drawn.unit) == (pytest.approx(main["value"]), 4, "deg")
    assert len(rows) == 4
    assert {row.unit for row in rows} == {"deg"}
    assert np.mean([row.value for row in rows]) == pytest.approx(main["value"])


def test_what_the_therapist_draws_decides_what_is_outside(
    therapist: Any, world: Any, store: Any, patients: SimulatedSession, template_version: dict[str, Any]
) -> None:
    """The same recording of somebody who leans 12 degrees, judged by four bands."""
    lean = "trunk_lean_forward_rad"
    newest = str(template_version["id"])

    def drawn(**design: Any) -> str:
        nonlocal newest
        answer = therapist.post(
            f"/api/templates/{template_version['template_id']}/versions",
            json={"based_on": newest, "design": design, "reason": "lean"},
        )
        assert answer.status_code == 201, answer.text
        newest = str(answer.json()["id"])
        return newest

    def judged(session_id: str, version_id: str) -> tuple[list[Any], dict[str, Any]]:
        made = therapist.post(
            f"/api/sessions/{session_id}/comparisons", json={"template_version_id": version_id}
        ).json()
        detail = therapist.get(f"/api/comparisons/{made['id']}").json()
        return [one["outside_band"].get(lean, []) for one in detail["repetitions"]], detail

    def spent(spans: list[tuple[int, int]]) -> int:
        return sum(end - start for start, end in spans)

    session_id = store(patients, "therapist")
    recorded, _ = judged(session_id, template_version["id"])
    assert all(recorded), "it leaves the recorded band in each repetition"
    # Free but for one phase: outside there and nowhere else.
    knots = [
        {"phase": 0.29, "below": None, "above": None},
        {"phase": 0.3, "above": 0.5},
        {"phase": 0.5, "above": 0.5},
        {"phase": 0.51, "below": None, "above": None},
    ]
    version = drawn(
        phases=[{"name": "Lift", "start": 0.0, "end": 0.3}, {"name": "Hold", "start": 0.3, "end": 0.5}],
        tolerances=[{"channel": lean, "knots": knots}],
    )
    narrow, detail = judged(session_id, version)
    assert all(narrow)
    assert all(30 <= start < end <= 51 for spans in narrow for start, end in spans)
    assert [one["name"] for one in detail["phases"]] == ["Lift", "Hold"]
    assert any("Mostly in: Hold." in sentence for sentence in detail["findings"])
    curve = next(one for one in detail["curves"] if one["channel"] == lean)
    assert (curve["high"][20], curve["low"][20]) == (None, None), "free"
    assert curve["high"][40] - curve["mean"][40] == pytest.approx(0.5 * curve["width"][40], abs=1e-3)
    watched, detail = judged(session_id, drawn(watched=[lean]))
    assert not any(watched)
    assert not any("lean" in sentence.lower() for sentence in detail["findings"])
    # A band of 3 degrees, prescribed three times as wide, holds all but the farthest of a lean of 12 degrees.
    prescription = therapist.post(
        f"/api/patients/{world.patient_id}/prescriptions",
        json={
            "exercise_id": world.exercise_id,
            "template_id": template_version["template_id"],
            "tolerance_scale": 3.0,
        },
    ).json()["id"]
    wide, detail = judged(store(patients, "therapist", prescription_id=prescription), template_version["id"])
    assert all(0 < spent(wide_one) < spent(one) for wide_one, one in zip(wide, recorded, strict=True))
    curve = next(one for one in detail["curves"] if one["channel"] == lean)
    assert curve["high"][40] - curve["mean"][40] == pytest.approx(3.0 * curve["width"][40], abs=1e-3)


def test_a_sum_is_what_the_therapist_weighed_with_all_its_parts(
    therapist: Any, store: Any, patients: SimulatedSession, template_version: dict[str, Any]
) -> None:
    weights = [{"measure": MAIN, "weight": 0.5}, {"measure": "timing_deviation", "weight": -2.0}]
    drawn = therapist.post(
        f"/api/templates/{template_version['template_id']}/versions",
        json={"based_on": template_version["id"], "design": {"weights": weights}, "reason": "sum"},
    ).json()
    assert drawn["design"]["weights"] == weights
    session_id = store(patients, "therapist")

    def detail(version_id: str) -> dict[str, Any]:
        body = {"template_version_id": version_id}
        made = therapist.post(f"/api/sessions/{session_id}/comparisons", json=body).json()
        return therapist.get(f"/api/comparisons/{made['id']}").json()

    assert detail(template_version["id"])["weighted_sum"] is None, "the version before weighs nothing"
    compared = detail(drawn["id"])
    found = compared["weighted_sum"]
    rows = [
        {one["measure"]: one["value"] for one in each["measures"]}
        for each in compared["repetitions"]
        if each["repetition"]["is_kept"]
    ]
    sums = [0.5 * row[MAIN] - 2.0 * row["timing_deviation"] for row in rows]
    assert found["count"] == len(sums) == 4
    assert found["value"] == pytest.approx(np.mean(sums))
    assert found["uncertainty"] == pytest.approx(np.std(sums, ddof=1))
    assert found["value"] == pytest.approx(sum(one["part"] for one in found["parts"]))
    summary = {one["measure"]: one for one in compared["summary"]}
    for part, weight in zip(found["parts"], weights, strict=True):
        own = summary[weight["measure"]]
        assert (part["label"], part["unit"], part["weight"]) == (own["label"], own["unit"], weight["weight"])
        assert part["value"] == pytest.approx(own["value"])
        assert part["template_value"] == own["template_value"]
    # Uneven timing is measured against the template: of its own it has none.
    assert found["template_value"] is None


def test_progress_takes_up_the_comparison(
    therapist: Any, world: Any, store: Any, patients: SimulatedSession, template_version: dict[str, Any]
) -> None:
    prescription = prescribe(therapist, world, template_version["template_id"])
    store(patients, prescription_id=prescription)
    progress = therapist.get(f"/api/patients/{world.patient_id}/progress").json()
    main = progress["measures"][0]
    assert (main["measure"], main["unit"]) == (MAIN, "deg")
    assert main["points"][0]["count"] == 4
    alike = next(
        one
        for one in progress["measures"]
        if one["measure"] == MAIN.replace("range:", "multiple_correlation:")
    )
    assert alike["points"][0]["count"] == 4, "of all repetitions together"
    assert 0.5 < alike["points"][0]["value"] < 1.0
    assert alike["points"][0]["low"] < alike["points"][0]["value"]


def test_a_session_can_be_compared_on_demand(
    therapist: Any, store: Any, patients: SimulatedSession, template_version: dict[str, Any], engine: Engine
) -> None:
    session_id = store(patients)
    # Nothing was prescribed: the session is analysed without a comparison.
    assert therapist.get(f"/api/sessions/{session_id}").json()["state"] == "analysed"
    assert therapist.get(f"/api/sessions/{session_id}/comparisons").json() == []
    answer = therapist.post(
        f"/api/sessions/{session_id}/comparisons", json={"template_version_id": template_version["id"]}
    )
    assert answer.status_code == 201, answer.text
    assert therapist.get(f"/api/sessions/{session_id}/comparisons").json() == [answer.json()]
    with read_only(engine) as session:
        actions = set(session.scalars(select(AuditEvent.action)))
    assert {"comparison.create", "comparison.list", "template.publish", "template.preview"} <= actions


def test_a_template_compared_with_its_own_recording_lies_inside_its_band(
    therapist: Any, template_version: dict[str, Any]
) -> None:
    answer = therapist.post(
        f"/api/sessions/{template_version['source_session_id']}/comparisons",
        json={"template_version_id": template_version["id"]},
    )
    summary = {m["measure"]: m for m in answer.json()["summary"]}
    assert summary["inside_band"]["value"] > 90.0
    assert summary["duration_ratio"]["value"] == pytest.approx(1.0, abs=0.02)


def test_the_other_arm_is_compared_with_the_mirrored_template(
    therapist: Any, world: Any, store: Any, template_version: dict[str, Any], engine: Engine
) -> None:
    left = simulate_arm(
        ArmScenario(
            exercise="reaching",
            side="left",
            placements=tuple(name.replace("right", "left") for name in ARM),
            schedule=Schedule(n_pose_s=7.0, repetitions=3),
            seed=5,
        )
    )
    with unit_of_work(engine) as session:
        exercise = Exercise(
            clinic_id=world.clinic_id,
            name="Reach left",
            movement="reaching",
            side="left",
            primary_angle="thorax_humerus_left_yxy_elevation",
        )
        session.add(exercise)
    session_id = store(left, exercise_id=exercise.id)
    answer = therapist.post(
        f"/api/sessions/{session_id}/comparisons", json={"template_version_id": template_version["id"]}
    )
    assert answer.status_code == 201, answer.text
    detail = therapist.get(f"/api/comparisons/{answer.json()['id']}").json()
    assert detail["repetition_count"] == 3
    assert all("_right_" not in curve["channel"] for curve in detail["curves"])
    measured = {m["measure"]: m for m in detail["summary"]}
    assert measured["range_ratio:thorax_humerus_left_yxy_elevation"]["value"] == pytest.approx(1.0, abs=0.12)


def test_a_session_that_cannot_be_compared_is_still_analysed(
    therapist: Any,
    world: Any,
    store: Any,
    run_queue: Any,
    patients: SimulatedSession,
    template_version: dict[str, Any],
    engine: Engine,
) -> None:
    prescription = prescribe(therapist, world, template_version["template_id"])
    session_id = store(patients, prescription_id=prescription)
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, session_id)
        session.delete(session.scalars(select(Comparison)).one())
        # Nothing moved in the stretch that counts.
        found.state, found.recording_start_s, found.recording_end_s = "closing", 1.0, 1.05
        session.add(Job(session_id=session_id, kind="compare", arguments={"close": True}, created_by="x"))
    (ended,) = run_queue()
    assert ended.startswith("compare complete")
    assert therapist.get(f"/api/sessions/{session_id}").json()["state"] == "analysed"
