"""From a therapist's recording to a template, and who sees it."""

from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.database.unit_of_work import read_only
from app.exercises.models import TemplateVersion
from estimators.simulation import SimulatedSession

from .conftest import MAIN

pytestmark = pytest.mark.usefixtures("quiet_queue")


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
    for wrong, says in [({"dropped": [9]}, "the number 9"), ({"dropped": [1, 2, 3, 4]}, "at least two")]:
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


def test_a_template_begins_with_the_phases_it_is_given(
    therapist: Any, store: Any, world: Any, therapists: SimulatedSession
) -> None:
    body = {
        "session_id": store(therapists, purpose="template"),
        "exercise_id": world.exercise_id,
        "name": "In two parts",
    }
    halves = [{"name": "Out", "start": 0.0, "end": 0.5}, {"name": "Back", "start": 0.5, "end": 1.0}]
    made = therapist.post("/api/templates", json=body | {"phases": halves}).json()
    assert made["design"]["phases"] == halves
    assert [one["name"] for one in made["content"]["phases"]] == ["Out", "Back"]
    refused = therapist.post("/api/templates", json=body | {"phases": halves[::-1]})
    assert (refused.status_code, refused.json()["details"]["field"]) == (422, "design.phases")
    assert therapist.post("/api/templates", json=body).json()["design"]["phases"] == []


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
