"""The template of a walk through the service: recorded, drawn on, prescribed, compared, copied for the other foot."""

from dataclasses import replace
from typing import Any

import pytest
from sqlalchemy import Engine, select

from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Exercise, TemplateVersion
from app.patients.models import Patient
from app.recordings.models import MotionSession
from estimators.comparison import foot_channels
from estimators.simulation import WalkStyle

from .walked import both, until, walked

pytestmark = pytest.mark.usefixtures("quiet_queue")
_, HEIGHT, SPEED = foot_channels("right")


@pytest.fixture
def exercise_id(therapist: Any) -> str:
    answer = therapist.post("/api/exercises", json={"name": "Walk ten metres", "movement": "walk"})
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


@pytest.fixture
def walk(store: Any, exercise_id: str) -> Any:
    """Store a walk of both feet; returns its session."""

    def make(style: WalkStyle | None = None, seed: int = 1, **declared: Any) -> str:
        return str(store(walked(style, seed), exercise_id=exercise_id, pipeline="gait", **declared))

    return make


@pytest.fixture
def version(therapist: Any, walk: Any, exercise_id: str) -> dict[str, Any]:
    body = {
        "session_id": walk(purpose="template"),
        "exercise_id": exercise_id,
        "name": "My walk",
        "phases": [
            {"name": "Stand", "start": 0.0, "end": 0.62},
            {"name": "Schwung", "start": 0.62, "end": 1.0},
        ],
    }
    answer = therapist.post("/api/templates", json=body)
    assert answer.status_code == 201, answer.text
    found: dict[str, Any] = answer.json()
    return found


def compared(therapist: Any, session_id: str, version_id: str) -> dict[str, Any]:
    answer = therapist.post(
        f"/api/sessions/{session_id}/comparisons", json={"template_version_id": version_id}
    )
    assert answer.status_code == 201, answer.text
    found: dict[str, Any] = therapist.get(f"/api/comparisons/{answer.json()['id']}").json()
    return found


def test_a_preview_shows_the_strides_of_the_walk(
    therapist: Any, walk: Any, engine: Engine, world: Any
) -> None:
    session_id = walk(purpose="template")
    content = therapist.post("/api/templates/preview", json={"session_id": session_id}).json()
    strides = {
        foot["side"]: foot["strides"]
        for foot in therapist.get(f"/api/sessions/{session_id}/gait").json()["feet"]
    }
    assert (content["side"], content["sides"]) == ("right", ["left", "right"])
    counted = {one["number"]: one["is_counted"] for one in strides["right"] if one["duration_s"] is not None}
    assert {one["number"]: one["is_kept"] for one in content["repetitions"]} == counted
    assert [one["reason"] for one in content["repetitions"] if not one["is_kept"]] == [
        "The last stride before standing still."
    ]
    assert (content["phases"][0]["name"], content["phases"][0]["start"]) == ("Stance", 0.0)
    assert content["phases"][1]["name"] == "Swing"
    curves = {one["channel"]: one for one in content["curves"]}
    assert [(one["label"], one["unit"], one["is_judged"]) for one in curves.values()] == [
        ("Foot pitch", "deg", True),
        ("Foot height", "m", True),
        ("Forward speed of the foot", "m/s", False),
    ]
    body = {"session_id": session_id, "side": "left", "dropped": [3]}
    left = therapist.post("/api/templates/preview", json=body).json()
    assert left["side"] == "left"
    assert [one["number"] for one in left["repetitions"] if not one["is_kept"]] == [3]
    with unit_of_work(engine) as session:
        session.get_one(Patient, world.patient_id).affected_side = "left"
    assert therapist.post("/api/templates/preview", json={"session_id": session_id}).json()["side"] == "left"


def test_a_template_of_a_walk_is_drawn_on_like_others(
    therapist: Any, version: dict[str, Any], engine: Engine
) -> None:
    found = therapist.get(f"/api/template-versions/{version['id']}").json()
    assert found["is_guided"] is False
    assert (found["side"], found["primary_channel"]) == ("right", HEIGHT)
    assert [one["name"] for one in found["design"]["phases"]] == ["Stand", "Schwung"]
    assert found["design"]["watched"] == [SPEED]
    assert (found["design"]["stops"], found["design"]["cues"]) == ([], [])
    # Every stride has its curve beside the mean.
    height = next(one for one in found["content"]["curves"] if one["channel"] == HEIGHT)
    assert len(height["repetitions"]) == len(found["content"]["repetitions"])
    assert sum(value is not None for value in height["repetitions"][0]) == 101
    design = found["design"] | {
        "watched": [],
        "tolerances": [{"channel": HEIGHT, "knots": [{"phase": 0.0, "below": 2.0}]}],
    }
    answer = therapist.post(
        f"/api/templates/{found['template_id']}/versions",
        json={"based_on": version["id"], "design": design, "reason": "Higher is fine"},
    )
    assert answer.status_code == 201, answer.text
    drawn = next(one for one in answer.json()["content"]["curves"] if one["channel"] == height["channel"])
    middle = 80
    assert drawn["mean"][middle] - drawn["low"][middle] == pytest.approx(
        2.0 * drawn["width"][middle], abs=1e-4
    )
    with read_only(engine) as session:
        assert len(session.scalars(select(TemplateVersion)).all()) == 2


def test_a_prescribed_walk_is_compared_when_it_is_analysed(
    therapist: Any, walk: Any, version: dict[str, Any], exercise_id: str, world: Any, engine: Engine
) -> None:
    answer = therapist.post(
        f"/api/patients/{world.patient_id}/prescriptions",
        json={"exercise_id": exercise_id, "template_id": version["template_id"]},
    )
    assert answer.status_code == 201, answer.text
    low = walk(both(clearance_m=0.02), 2, prescription_id=answer.json()["id"])
    (one,) = therapist.get(f"/api/sessions/{low}/comparisons").json()
    found = therapist.get(f"/api/comparisons/{one['id']}").json()
    said = [text for text in found["findings"] if text.startswith("The foot was lifted less")]
    assert len(said) == 1
    assert said[0].endswith("Mostly in: Schwung.")
    kept = [stride for stride in found["repetitions"] if stride["repetition"]["is_kept"]]
    assert len(kept) >= 5
    assert all(list(stride["outside_band"]) == [HEIGHT] for stride in kept)
    last = next(one["repetition"] for one in found["repetitions"] if not one["repetition"]["is_kept"])
    assert last["sentences"]["reason"]["code"] == "stride.last", "it can be said in every language"
    measured = {one["measure"]: one for one in found["summary"]}
    assert measured["duration_ratio"]["value"] == pytest.approx(1.0, abs=0.02)
    assert measured[f"range:{HEIGHT}"]["unit"] == "m"
    # Progress has the numbers of the walk and those beside the template, and tells when the template was made.
    path = f"/api/patients/{world.patient_id}/progress"
    progress = therapist.get(path, params={"exercise_id": exercise_id}).json()
    names = [one["measure"] for one in progress["measures"]]
    assert names[0].startswith("walk:")
    assert {f"range:{HEIGHT}", "inside_band", "duration"} <= set(names)
    assert "template" in [one["kind"] for one in progress["events"]]
    with read_only(engine) as session:
        assert session.get_one(MotionSession, low).valid_repetitions == 0
        assert session.get_one(MotionSession, low).active_s > 5.0


def test_the_affected_foot_is_compared(
    therapist: Any, walk: Any, version: dict[str, Any], engine: Engine, world: Any
) -> None:
    with unit_of_work(engine) as session:
        session.get_one(Patient, world.patient_id).affected_side = "left"
    found = compared(therapist, walk(seed=3), version["id"])
    assert [one["channel"] for one in found["curves"]] == list(foot_channels("left"))
    assert found["findings"] == ["The movement matched the template within what can be measured."]


def test_a_copy_is_of_the_other_foot_of_the_same_exercise(
    therapist: Any, version: dict[str, Any], exercise_id: str
) -> None:
    answer = therapist.post(
        f"/api/template-versions/{version['id']}/copies",
        json={"patient_id": None, "name": "Other foot", "reason": "The left one"},
    )
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert (made["side"], made["exercise_id"]) == ("left", exercise_id)
    assert made["design"]["watched"] == [foot_channels("left")[2]]
    own = {one["channel"]: one for one in made["content"]["curves"]}
    recorded = {one["channel"]: one for one in version["content"]["curves"]}
    for mine, theirs in zip(foot_channels("left"), foot_channels("right"), strict=True):
        assert own[mine]["mean"] == recorded[theirs]["mean"]
        assert own[mine]["repetitions"] == recorded[theirs]["repetitions"]


def test_too_short_a_walk_is_refused_in_words_of_walking(
    therapist: Any, store: Any, version: dict[str, Any], exercise_id: str
) -> None:
    def cut(seconds: float) -> str:
        whole = walked(seed=2)
        recording = until(whole.recording, seconds)
        return str(store(replace(whole, recording=recording), exercise_id=exercise_id, pipeline="gait"))

    def refused(path: str, body: dict[str, Any]) -> str:
        answer = therapist.post(path, json=body)
        assert answer.status_code == 422, answer.text
        return str(answer.json()["sentences"]["message"]["code"])

    standing, one_step = cut(2.5), cut(5.2)
    body = {"template_version_id": version["id"]}
    assert refused(f"/api/sessions/{standing}/comparisons", body) == "walk.no_stride"
    assert refused("/api/templates/preview", {"session_id": standing}) == "walk.no_stride"
    assert refused("/api/templates/preview", {"session_id": one_step}) == "template.few_strides"
    (said,) = compared(therapist, one_step, version["id"])["findings"]
    assert said.startswith("No stride from one contact")


def test_walks_and_other_movements_do_not_mix(
    therapist: Any,
    walk: Any,
    store: Any,
    therapists: Any,
    version: dict[str, Any],
    template_version: dict[str, Any],
    exercise_id: str,
    world: Any,
) -> None:
    walked_id, reached_id = walk(seed=2), store(therapists)

    def refused(path: str, body: dict[str, Any]) -> str:
        answer = therapist.post(path, json=body)
        assert answer.status_code == 422, answer.text
        return str(answer.json()["message"])

    for session_id, other in ((walked_id, template_version), (reached_id, version)):
        path = f"/api/sessions/{session_id}/comparisons"
        assert "template of the same kind" in refused(path, {"template_version_id": other["id"]})
    body = {"patient_id": None, "name": "No", "exercise_id": exercise_id, "reason": "No"}
    path = f"/api/template-versions/{template_version['id']}/copies"
    assert "template of the same kind" in refused(path, body)
    body = {"name": "No", "session_id": reached_id, "exercise_id": exercise_id}
    assert "choose a recording of a walk" in refused("/api/templates", body)
    body = {"name": "No", "session_id": walked_id, "exercise_id": world.exercise_id}
    assert "was not measured" in refused("/api/templates", body)


def test_walks_of_no_exercise_are_not_on_one_axis_with_other_movements(
    therapist: Any,
    walk: Any,
    store: Any,
    therapists: Any,
    version: dict[str, Any],
    template_version: dict[str, Any],
    world: Any,
) -> None:
    def names() -> list[str]:
        progress = therapist.get(f"/api/patients/{world.patient_id}/progress").json()
        assert progress["exercise_id"] is None
        return [one["measure"] for one in progress["measures"]]

    compared(therapist, str(store(walked(seed=2), exercise_id=None, pipeline="gait")), version["id"])
    compared(therapist, str(store(therapists, exercise_id=None)), template_version["id"])
    reached = names()
    assert "range:humerus_forearm_right_zxy_flexion" in reached
    assert [name for name in reached if "foot" in name or name.startswith("walk:")] == []
    store(walked(seed=3), exercise_id=None, pipeline="gait")
    of_walks = names()
    assert {"walk:speed:left", f"range:{HEIGHT}"} <= set(of_walks)
    assert [name for name in of_walks if "humerus" in name or "trunk" in name] == []


def test_steps_in_another_exercise_are_no_repetitions_of_it(
    therapist: Any, store: Any, world: Any, engine: Engine
) -> None:
    with read_only(engine) as session:
        angle = session.get_one(Exercise, world.exercise_id).primary_angle
    body = {"name": "Balance", "movement": "other", "side": "right", "primary_angle": angle}
    balance = therapist.post("/api/exercises", json=body).json()["id"]
    stepped = store(walked(seed=2), exercise_id=balance, pipeline="gait")
    reached = store(walked(seed=2), exercise_id=world.exercise_id, pipeline="gait")
    with read_only(engine) as session:
        assert session.get_one(MotionSession, stepped).valid_repetitions == 0
        assert session.get_one(MotionSession, reached).valid_repetitions == 0
        assert session.get_one(MotionSession, reached).active_s == 0.0
