"""The library: found by words and tags, retired and restored, copied for the other side."""

from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.accounts.models import AuditEvent
from app.assessment.design.compiled import effective_template
from app.assessment.design.prescribed import exercise_side
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Exercise, TemplateVersion
from app.recordings.models import MotionSession
from estimators.comparison import compare, mirror_trajectory
from tests.estimators.comparison.conftest import make_planar

from .drawing import DESIGN, LATERAL, MAIN, store_template


@pytest.fixture
def of_clinic(engine: Engine, world: Any) -> tuple[str, str]:
    with unit_of_work(engine) as session:
        session.get_one(Exercise, world.exercise_id).primary_angle = MAIN
    return store_template(engine, world, None, "Reach to the shelf")


def names(client: Any, **query: Any) -> list[str]:
    return [one["name"] for one in client.get("/api/templates", params=query).json()]


def test_templates_are_found_by_names_and_tags(
    therapist: Any, of_clinic: tuple[str, str], engine: Engine, world: Any
) -> None:
    store_template(engine, world, None, "Drink")
    answer = therapist.patch(
        f"/api/templates/{of_clinic[0]}/entry", json={"tags": [" Kühe ", "stroke", "Stroke"]}
    )
    assert answer.status_code == 200, answer.text
    assert answer.json()["tags"] == ["kühe", "stroke"]
    assert answer.json()["name"] == "Reach to the shelf"
    assert names(therapist) == ["Drink", "Reach to the shelf"]
    for words in ("SHELF", "stroke", "kÜhe", "shelf stroke", "reach"):
        assert "Reach to the shelf" in names(therapist, words=words), words
    assert names(therapist, words="stroke drink") == []
    assert names(therapist, words="%") == []
    renamed = therapist.patch(f"/api/templates/{of_clinic[0]}/entry", json={"name": "Shelf"}).json()
    assert (renamed["name"], renamed["tags"]) == ("Shelf", ["kühe", "stroke"])


def test_a_retired_template_is_not_offered_and_comes_back(
    therapist: Any, of_clinic: tuple[str, str], world: Any, engine: Engine
) -> None:
    path, body = (
        f"/api/patients/{world.patient_id}/prescriptions",
        {
            "exercise_id": world.exercise_id,
            "template_id": of_clinic[0],
        },
    )
    therapist.patch(f"/api/templates/{of_clinic[0]}/entry", json={"is_retired": True})
    assert names(therapist) == []
    assert names(therapist, is_retired=True) == ["Reach to the shelf"]
    refused = therapist.post(path, json=body)
    assert (refused.status_code, refused.json()["details"]["field"]) == (422, "template_id")
    restored = therapist.patch(f"/api/templates/{of_clinic[0]}/entry", json={"is_retired": False}).json()
    assert restored["retired_at"] is None
    assert therapist.post(path, json=body).status_code == 201
    with read_only(engine) as session:
        actions = session.scalars(
            select(AuditEvent.action).where(AuditEvent.action.like("template.re%"))
        ).all()
    assert actions == ["template.retire", "template.restore"]


def test_who_has_it_prescribed_goes_on_with_a_retired_one(
    therapist: Any, patient: Any, of_clinic: tuple[str, str], world: Any
) -> None:
    therapist.post(
        f"/api/patients/{world.patient_id}/prescriptions",
        json={"exercise_id": world.exercise_id, "template_id": of_clinic[0]},
    )
    therapist.patch(f"/api/templates/{of_clinic[0]}/entry", json={"is_retired": True})
    assert names(patient) == ["Reach to the shelf"]
    assert patient.patch(f"/api/templates/{of_clinic[0]}/entry", json={"name": "Mine"}).status_code == 403


def test_a_copy_for_the_other_side_is_the_mirrored_movement(
    therapist: Any, of_clinic: tuple[str, str], world: Any, engine: Engine
) -> None:
    drawn = therapist.post(
        f"/api/templates/{of_clinic[0]}/versions",
        json={"based_on": of_clinic[1], "design": DESIGN, "reason": "narrower"},
    ).json()
    answer = therapist.post(
        f"/api/template-versions/{drawn['id']}/copies",
        json={"name": "Reach, left", "reason": "other arm"},
    )
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert (made["side"], made["number"], made["reason"]) == ("left", 1, "other arm")
    assert made["primary_channel"] == MAIN.replace("right", "left")
    with read_only(engine) as session:
        exercise = session.get_one(Exercise, made["exercise_id"])
        assert (exercise.side, exercise.primary_angle) == ("left", made["primary_channel"])
        here = effective_template(session.get_one(TemplateVersion, drawn["id"]))
        across = effective_template(session.get_one(TemplateVersion, made["id"]))
    column = here.channels.index(LATERAL)
    assert np.array_equal(across.mean[:, column], -here.mean[:, column])
    assert np.array_equal(across.above[:, column], here.below[:, column])
    # Who moves as the template does, mirrored, is judged alike by the copy.
    moved = make_planar(repetitions=3, sizes=[1.0, 0.7, 1.0])
    judged = compare(moved.trajectory, here, "right", 0.55, repetitions=moved.truth)
    mirrored = compare(mirror_trajectory(moved.trajectory), across, "left", 0.55, repetitions=moved.truth)
    renamed = [
        {name.replace("right", "left"): runs for name, runs in one.outside.items()}
        for one in judged.repetitions
    ]
    assert renamed == [one.outside for one in mirrored.repetitions]
    assert any(renamed)
    # A second copy finds the exercise that the first one added.
    again = therapist.post(
        f"/api/template-versions/{drawn['id']}/copies",
        json={"name": "Reach, left, again", "reason": "once more"},
    ).json()
    assert again["exercise_id"] == made["exercise_id"]


def test_a_patients_template_stays_that_patients(
    therapist: Any, engine: Engine, world: Any, of_clinic: tuple[str, str]
) -> None:
    own = store_template(engine, world, world.patient_id)
    path = f"/api/template-versions/{own[1]}/copies"
    body = {"name": "For all", "reason": "good one"}
    assert therapist.post(path, json=body).status_code == 422
    other = {**body, "patient_id": world.other_patient_id}
    assert therapist.post(path, json=other).status_code == 422
    assert therapist.post(path, json={**body, "patient_id": world.patient_id}).status_code == 201


@pytest.mark.parametrize(
    ("angle", "worn", "side"),
    [
        (MAIN, {"upper_arm_left", "thigh_right"}, "left"),
        ("thigh_shank_right_zxy_flexion", {"upper_arm_left", "thigh_right", "shank_right"}, "right"),
        ("thigh_shank_right_zxy_flexion", {"pelvis", "thigh_left", "shank_left"}, "left"),
        ("thigh_shank_right_zxy_flexion", {"sternum"}, "right"),
    ],
)
def test_the_side_is_that_of_the_exercise_unless_only_the_other_limb_is_worn(
    engine: Engine, world: Any, angle: str, worn: set[str], side: str
) -> None:
    found = MotionSession(exercise_id=world.exercise_id, patient_id=world.patient_id)
    with unit_of_work(engine) as session:
        session.get_one(Exercise, world.exercise_id).primary_angle = angle
        assert exercise_side(session, found, frozenset(worn)) == side
