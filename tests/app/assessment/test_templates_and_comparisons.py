"""From a therapist's recording to a template, and from a patient's session to its comparison."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app import readers
from app.accounts.models import AuditEvent
from app.assessment.comparisons import compare_task
from app.assessment.models import Comparison, RepetitionMeasure
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Exercise, TemplateVersion
from app.ingest.upload import register, upload_folder
from app.ingest.upload_task import upload
from app.network.packet_log import write_log
from app.recordings.analysis.jobs import JobRunner, run_job
from app.recordings.analysis.reprocess import reprocess
from app.recordings.models import Job, MotionSession
from app.recordings.schemas import UploadIn
from app.settings import Settings
from estimators.simulation import ArmScenario, MovementStyle, Schedule, SimulatedSession, simulate_arm

ARM = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
HANDLERS = {"upload": upload, "reprocess": reprocess, "compare": compare_task}
MAIN = "range:thorax_humerus_right_yxy_elevation"


def perform(style: MovementStyle, repetitions: int, seed: int) -> SimulatedSession:
    return simulate_arm(
        ArmScenario(
            exercise="reaching",
            placements=ARM,
            style=style,
            schedule=Schedule(n_pose_s=7.0, repetitions=repetitions, pause_s=1.5),
            seed=seed,
        )
    )


@pytest.fixture(scope="module")
def therapists() -> SimulatedSession:
    return perform(MovementStyle(), 5, 21)


@pytest.fixture(scope="module")
def patients() -> SimulatedSession:
    """Slower, smaller, and with the trunk: what a comparison must find."""
    style = replace(MovementStyle(), speed=0.6, amplitude=0.7, trunk_lean_rad=np.radians(12))
    return perform(style, 4, 22)


@pytest.fixture
def run_queue(engine: Engine, settings: Settings) -> Callable[[], list[str]]:
    """Do every queued task in this process, in order; returns how each ended."""

    def run() -> list[str]:
        ended = []
        while True:
            with read_only(engine) as session:
                job = session.scalars(
                    select(Job).where(Job.status == "queued").order_by(Job.created_at).limit(1)
                ).first()
            if job is None:
                return ended
            done = run_job(engine, settings, job.id, HANDLERS[job.kind])
            ended.append(f"{job.kind} {done.status}: {done.message}")

    return run


@pytest.fixture
def store(
    engine: Engine, settings: Settings, world: Any, run_queue: Callable[[], list[str]]
) -> Callable[..., str]:
    """Upload a simulated session, without the packets of an interval, and analyse it; returns its id."""

    def make(
        simulated: SimulatedSession,
        name: str = "therapist",
        lost_s: tuple[float, float] = (0.0, 0.0),
        **declared: Any,
    ) -> str:
        prepared = readers.packets_of(simulated.recording)
        first_us = next(iter(prepared.packets(1))).device_time_us
        kept = (
            packet
            for packet in prepared.packets(1)
            if not lost_s[0] <= (packet.device_time_us - first_us) * 1e-6 < lost_s[1]
        )
        path: Path = upload_folder(settings) / f"{name}-{len(declared)}.upload"
        path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), kept)))
        declaration = UploadIn(
            **{
                "patient_id": world.patient_id,
                "format": "packet_log",
                "exercise_id": world.exercise_id,
                **declared,
            }
        )
        job = register(engine, settings, world.subjects[name], declaration, path)
        ended = run_queue()
        assert all(" complete" in line for line in ended), ended
        return job.session_id

    return make


@pytest.fixture
def template_version(therapist: Any, store: Any, world: Any, therapists: SimulatedSession) -> dict[str, Any]:
    source = store(therapists, purpose="template")
    answer = therapist.post(
        "/api/templates",
        json={"session_id": source, "exercise_id": world.exercise_id, "name": "Reach, my way"},
    )
    assert answer.status_code == 201, answer.text
    return answer.json()


@pytest.fixture(autouse=True)
def quiet_queue(services: Any) -> None:
    """The tests do the tasks themselves."""
    services.get(JobRunner).stop()


def test_a_preview_shows_repetitions_on_top_of_each_other(
    therapist: Any, store: Any, therapists: SimulatedSession, engine: Engine
) -> None:
    session_id = store(therapists, purpose="template")
    content = therapist.post("/api/templates/preview", json={"session_id": session_id}).json()
    found = content["repetitions"]
    assert [r["number"] for r in found] == [1, 2, 3, 4, 5]
    assert all(r["is_kept"] for r in found)
    for repetition, (start_s, end_s) in zip(found, therapists.truth.repetitions_s, strict=True):
        assert repetition["start_s"] == pytest.approx(start_s, abs=0.35)
        assert repetition["end_s"] == pytest.approx(end_s, abs=0.35)
    main = next(c for c in content["curves"] if c["channel"] == MAIN.removeprefix("range:"))
    assert (main["unit"], main["label"]) == ("deg", "Shoulder elevation")
    assert len(main["mean"]) == 101
    assert len(main["repetitions"]) == 5
    known = [p for p in range(101) if main["mean"][p] is not None]
    assert len(known) > 90
    assert all(main["low"][p] < main["mean"][p] < main["high"][p] for p in known)
    # In degrees: the true elevation of the simulated movement, at its highest.
    truth = np.degrees(therapists.truth.angle_rad("thorax_humerus_right_yxy_elevation"))
    assert max(v for v in main["mean"] if v is not None) == pytest.approx(truth.max(), abs=4.0)
    with read_only(engine) as session:
        assert session.scalars(select(TemplateVersion)).all() == []


def test_a_repetition_left_out_by_hand_does_not_count(
    therapist: Any, store: Any, therapists: SimulatedSession
) -> None:
    session_id = store(therapists, purpose="template")
    body = {"session_id": session_id, "dropped": [2], "tolerance_scale": {}}
    content = therapist.post("/api/templates/preview", json=body).json()
    assert [r["number"] for r in content["repetitions"] if not r["is_kept"]] == [2]
    assert content["repetitions"][1]["reason"] == "Excluded by hand."
    channel = MAIN.removeprefix("range:")

    def width(tolerance_scale: dict[str, float]) -> float:
        body["tolerance_scale"] = tolerance_scale
        curves = therapist.post("/api/templates/preview", json=body).json()["curves"]
        curve = next(c for c in curves if c["channel"] == channel)
        return float(curve["high"][50] - curve["mean"][50])

    assert width({channel: 2.0}) == pytest.approx(2 * width({}), rel=1e-3)
    for wrong, says in [({"dropped": [9]}, "no repetition 9"), ({"dropped": [1, 2, 3, 4]}, "at least two")]:
        answer = therapist.post("/api/templates/preview", json={**body, **wrong})
        assert answer.status_code == 422
        assert says in answer.json()["message"]
    answer = therapist.post("/api/templates/preview", json={**body, "tolerance_scale": {channel: -1.0}})
    assert answer.status_code == 422


def test_a_person_may_keep_what_the_service_would_leave_out(
    therapist: Any, store: Any, therapists: SimulatedSession, world: Any
) -> None:
    start_s, end_s = therapists.truth.repetitions_s[2]
    middle_s = 0.5 * (start_s + end_s)
    session_id = store(therapists, purpose="template", lost_s=(middle_s - 0.4, middle_s + 0.4))
    body: dict[str, Any] = {"session_id": session_id}

    def left_out(dropped: list[int] | None) -> dict[int, str]:
        answer = therapist.post("/api/templates/preview", json={**body, "dropped": dropped})
        assert answer.status_code == 200, answer.text
        return {r["number"]: r["reason"] for r in answer.json()["repetitions"] if not r["is_kept"]}

    automatic = left_out(None)
    assert list(automatic) == [3]
    assert "lost track" in automatic[3]
    assert left_out([]) == {}
    assert left_out([1]) == {1: "Excluded by hand."}
    assert left_out([3]) == automatic, "the reason stays visible"
    body |= {"exercise_id": world.exercise_id, "name": "All of them", "dropped": []}
    stored = therapist.post("/api/templates", json=body).json()
    assert stored["repetition_count"] == 5
    again = therapist.get(f"/api/template-versions/{stored['id']}").json()
    assert all(r["is_kept"] and not r["reason"] for r in again["content"]["repetitions"])
    main = next(c for c in again["content"]["curves"] if c["channel"] == MAIN.removeprefix("range:"))
    assert sum(value is not None for value in main["mean"]) > 90


def test_versions_of_a_template_are_kept_beside_each_other(
    therapist: Any, world: Any, template_version: dict[str, Any]
) -> None:
    assert template_version["number"] == 1
    assert template_version["repetition_count"] == 5
    answer = therapist.post(
        "/api/templates",
        json={
            "session_id": template_version["source_session_id"],
            "exercise_id": world.exercise_id,
            "template_id": template_version["template_id"],
            "name": "Reach, wider",
            "dropped": [1],
        },
    )
    assert answer.status_code == 201, answer.text
    second = answer.json()
    stored = therapist.get(f"/api/template-versions/{second['id']}").json()["content"]["repetitions"][0]
    assert (stored["reason"], stored["sentences"]["reason"]["code"]) == (
        "Excluded by hand.",
        "template.by_hand",
    )
    assert (second["number"], second["repetition_count"]) == (2, 4)
    first = therapist.get(f"/api/template-versions/{template_version['id']}").json()
    assert first["content"] == template_version["content"]
    listed = therapist.get("/api/templates", params={"exercise_id": world.exercise_id}).json()
    assert [t["name"] for t in listed] == ["Reach, wider"]
    assert [v["number"] for v in listed[0]["versions"]] == [2, 1]


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
    assert len(rows) == 4
    assert {row.unit for row in rows} == {"deg"}
    assert np.mean([row.value for row in rows]) == pytest.approx(main["value"])


def test_what_the_therapist_draws_decides_what_is_outside(
    therapist: Any, world: Any, store: Any, patients: SimulatedSession, template_version: dict[str, Any]
) -> None:
    """The same recording of somebody who leans 12 degrees, judged by four bands."""
    lean = "trunk_lean_forward_rad"

    def drawn(**design: Any) -> str:
        answer = therapist.post(
            f"/api/templates/{template_version['template_id']}/versions",
            json={"based_on": template_version["id"], "design": design, "reason": "lean"},
        )
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])

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


def test_who_sees_templates_and_comparisons(
    sign_in: Any,
    nobody: Any,
    therapist: Any,
    world: Any,
    store: Any,
    patients: SimulatedSession,
    template_version: dict[str, Any],
) -> None:
    path = f"/api/template-versions/{template_version['id']}"
    session_id = store(patients)
    compared = therapist.post(
        f"/api/sessions/{session_id}/comparisons", json={"template_version_id": template_version["id"]}
    ).json()
    # A template of the clinic: colleagues may use it, without the single repetitions of a patient that is
    # not theirs; nobody outside.
    colleague = sign_in("colleague").get(path)
    assert colleague.status_code == 200
    assert all(curve["repetitions"] == [] for curve in colleague.json()["content"]["curves"])
    for name in ("other_patient", "foreign_therapist", "foreign_administrator"):
        assert sign_in(name).get(path).status_code == 404, name
        assert sign_in(name).get("/api/templates").json() == [], name
    # Compared with it, so the patient may see it.
    assert sign_in("patient").get(path).status_code == 200
    for name in ("colleague", "former", "other_patient", "foreign_therapist"):
        stranger = sign_in(name)
        assert stranger.get(f"/api/comparisons/{compared['id']}").status_code == 404, name
        assert stranger.get(f"/api/sessions/{session_id}/comparisons").status_code == 404, name
        body = {"template_version_id": template_version["id"]}
        assert stranger.post(f"/api/sessions/{session_id}/comparisons", json=body).status_code == 404, name
        body = {"session_id": session_id, "exercise_id": world.exercise_id, "name": "stolen"}
        assert stranger.post("/api/templates", json=body).status_code == 404, name
        assert stranger.post("/api/templates/preview", json={"session_id": session_id}).status_code == 404
    body = {"session_id": session_id, "exercise_id": world.exercise_id, "name": "mine"}
    assert sign_in("patient").post("/api/templates", json=body).status_code == 403
    assert nobody.get(path).status_code == 401


def test_a_template_for_one_patient_is_that_patients_data(
    sign_in: Any, therapist: Any, world: Any, store: Any, therapists: SimulatedSession
) -> None:
    source = store(therapists, purpose="template")
    body = {
        "session_id": source,
        "exercise_id": world.exercise_id,
        "patient_id": world.patient_id,
        "name": "For Ada",
    }
    made = therapist.post("/api/templates", json=body).json()
    assert therapist.get("/api/templates").json() == []
    listed = therapist.get("/api/templates", params={"patient_id": world.patient_id}).json()
    assert [t["name"] for t in listed] == ["For Ada"]
    assert sign_in("reader").get(f"/api/template-versions/{made['id']}").status_code == 200
    for name in ("colleague", "other_patient", "foreign_therapist"):
        assert sign_in(name).get(f"/api/template-versions/{made['id']}").status_code == 404, name
    body = {**body, "patient_id": world.other_patient_id, "template_id": made["template_id"]}
    assert therapist.post("/api/templates", json=body).status_code == 422
