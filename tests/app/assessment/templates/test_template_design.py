"""What a therapist draws on a template: stored as a version, the same for everybody, refused where it cannot hold."""

import copy
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.accounts.models import AuditEvent
from app.assessment.design.compiled import effective_template, guidance_of, mirrored_design
from app.assessment.design.rules import said
from app.database.unit_of_work import read_only
from app.exercises.design import StopDesign, TemplateDesign
from app.exercises.models import TemplateVersion
from estimators.comparison import mirror_template, template_from_bytes
from estimators.guidance import Guide
from estimators.sentences import Sentence

from .drawing import DESIGN, ELEVATION, FORWARD, LATERAL, MAIN, planar_template, store_template


@pytest.fixture
def stored(engine: Engine, world: Any) -> tuple[str, str]:
    return store_template(engine, world, world.patient_id)


def draw(client: Any, stored: tuple[str, str], design: dict[str, Any], reason: str = "Leans early") -> Any:
    body = {"based_on": stored[1], "design": design, "reason": reason}
    return client.post(f"/api/templates/{stored[0]}/versions", json=body)


def version_of(engine: Engine, version_id: str) -> TemplateVersion:
    with read_only(engine) as session:
        version = session.get_one(TemplateVersion, version_id)
        session.expunge(version)
    return version


def test_a_drawing_makes_a_version_with_who_when_and_why(
    therapist: Any, stored: tuple[str, str], world: Any, engine: Engine
) -> None:
    before = therapist.get(f"/api/template-versions/{stored[1]}").json()
    answer = draw(therapist, stored, DESIGN)
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert (made["number"], made["reason"], made["template_id"]) == (2, "Leans early", stored[0])
    assert made["made_by"]
    assert made["created_at"] >= before["created_at"]
    again = therapist.get(f"/api/template-versions/{made['id']}").json()
    assert again == made
    assert again["design"]["phases"] == DESIGN["phases"]
    assert again["design"]["tolerances"] == DESIGN["tolerances"]
    # The version before is as it was, and has the recorded band.
    assert therapist.get(f"/api/template-versions/{stored[1]}").json() == before
    old = next(c for c in before["content"]["curves"] if c["channel"] == FORWARD)
    new = next(c for c in made["content"]["curves"] if c["channel"] == FORWARD)
    assert new["mean"] == old["mean"]
    assert new["width"] == old["width"]
    width = old["width"][30]
    assert old["high"][30] - old["mean"][30] == pytest.approx(width, abs=1e-4)
    assert new["high"][30] - new["mean"][30] == pytest.approx(0.4 * width, abs=1e-4)
    assert new["mean"][30] - new["low"][30] == pytest.approx(width, abs=1e-4)
    assert new["low"][70] is None, "free"
    assert [c["channel"] for c in made["content"]["curves"] if not c["is_judged"]] == [ELEVATION]
    listed = therapist.get("/api/templates", params={"patient_id": world.patient_id}).json()
    assert [v["number"] for v in listed[0]["versions"]] == [2, 1]
    assert [v["reason"] for v in listed[0]["versions"]] == ["Leans early", ""]
    with read_only(engine) as session:
        event = session.scalars(select(AuditEvent).where(AuditEvent.action == "template.publish")).one()
        assert event.patient_id == world.patient_id
        assert event.details["number"] == 2


def test_rules_of_the_house_are_written_out_for_whoever_edits(
    therapist: Any, stored: tuple[str, str]
) -> None:
    design = therapist.get(f"/api/template-versions/{stored[1]}").json()["design"]
    assert [one["kind"] for one in design["stops"]] == ["lost", "unsure", "wrong_in_a_row"]
    assert {one["sentence"] for one in design["cues"]} >= {"guidance.stand_tall", "guidance.slower"}
    # Sent back as it came, it changes nothing.
    again = draw(therapist, stored, design).json()
    assert again["design"] == design


def test_everybody_gets_the_same_band_and_rules(
    therapist: Any, stored: tuple[str, str], engine: Engine
) -> None:
    version = version_of(engine, draw(therapist, stored, DESIGN).json()["id"])
    template = effective_template(version)
    column = template.channels.index(FORWARD)
    recorded = template_from_bytes(version.content)
    assert template.above[30, column] == pytest.approx(0.4 * recorded.tolerance[30, column])
    assert np.isinf(template.below[60, column])
    made = guidance_of(version, "right", 0.6)
    assert np.array_equal(made.ready.above, template.above * np.where(_is_point(template), 0.6 / 0.55, 1.0))
    tall, slow, watched = made.rules
    assert (tall.sentence, tall.side, tall.tolerance) == ("Keep your back on the chair", "above", None)
    assert isinstance(said(slow.sentence), Sentence)
    assert said(tall.sentence) == "Keep your back on the chair"
    assert not slow.is_on
    assert not watched.is_on, "what is only watched is not spoken of"
    # The pauses without which nothing can be judged are always there.
    assert [rule.kind for rule in made.stops] == ["limit", "lost", "unsure"]
    Guide(made.ready, 0.01, rules=made.rules, stops=made.stops, pace=made.pace, valid_share=made.valid_share)


def test_a_wider_prescription_widens_the_whole_band_and_adds_its_stops(
    therapist: Any, stored: tuple[str, str], engine: Engine
) -> None:
    version = version_of(engine, draw(therapist, stored, DESIGN).json()["id"])
    once, twice = effective_template(version), effective_template(version, scale=2.0)
    assert np.allclose(twice.above, 2.0 * once.above, equal_nan=True)
    assert np.allclose(twice.below, 2.0 * once.below, equal_nan=True)
    own = StopDesign(kind="limit", channel=MAIN, limit=1.0)
    made = guidance_of(version, "right", 0.55, scale=2.0, more_stops=[own])
    assert made.stops[0].channel == MAIN
    assert np.allclose(made.ready.above, twice.above, equal_nan=True)


def test_the_other_side_gets_the_mirrored_band_rules_and_limits(
    therapist: Any, stored: tuple[str, str], engine: Engine
) -> None:
    version = version_of(engine, draw(therapist, stored, DESIGN).json()["id"])
    here, across = guidance_of(version, "right", 0.55), guidance_of(version, "left", 0.55)
    column = here.ready.channels.index(LATERAL)
    assert np.array_equal(across.ready.above[:, column], here.ready.below[:, column])
    assert np.array_equal(across.ready.mean[:, column], -here.ready.mean[:, column])
    assert (across.rules[0].channel, across.rules[0].side) == (LATERAL, "below")
    assert across.rules[2].channel == "thorax_humerus_left_yxy_elevation"
    assert (across.stops[0].limit, across.stops[0].side) == (-0.5, "below")
    # A design that was mirrored and stored on the mirrored recording is the same thing.
    recorded = planar_template()
    mirrored = mirrored_design(TemplateDesign.model_validate(DESIGN), recorded)
    assert mirrored.cues is not None
    assert mirrored.cues[0].words == "Keep your back on the chair"
    twice = mirrored_design(mirrored, mirror_template(recorded))
    assert twice == TemplateDesign.model_validate(DESIGN)


def _is_point(template: Any) -> np.ndarray:
    return np.array(["." in name for name in template.channels])


def wrong(**changes: Any) -> dict[str, Any]:
    return {**copy.deepcopy(DESIGN), **changes}


@pytest.mark.parametrize(
    ("design", "field"),
    [
        (wrong(watched=["nothing"]), "design"),
        (wrong(watched=[MAIN]), "design.watched"),
        (
            wrong(
                phases=[
                    {"name": "Lift", "start": 0.0, "end": 0.6},
                    {"name": "Lower", "start": 0.5, "end": 1.0},
                ]
            ),
            "design.phases",
        ),
        (wrong(phases=[{"name": "  ", "start": 0.0, "end": 0.6}]), "design.phases"),
        (
            wrong(tolerances=[{"channel": FORWARD, "knots": [{"phase": 0.5}, {"phase": 0.2}]}]),
            "design.tolerances",
        ),
        (wrong(tolerances=[{"channel": FORWARD, "knots": [{"phase": 0.5}]}] * 2), "design.tolerances"),
        (wrong(stops=[{"kind": "limit", "channel": "wrist_right.x", "limit": 1.0}]), "design.stops.0"),
        (wrong(stops=[{"kind": "time", "limit": 0.0}]), "design.stops.0"),
        (wrong(cues=[{"quantity": "fast", "sentence": "guidance.slower"}]), "design.cues.0"),
        (
            wrong(cues=[{"quantity": "slow", "sentence": "guidance.nothing", "tolerance": 1.0}]),
            "design.cues.0",
        ),
    ],
)
def test_what_cannot_hold_is_refused(
    therapist: Any, stored: tuple[str, str], design: dict[str, Any], field: str
) -> None:
    answer = draw(therapist, stored, design)
    assert answer.status_code == 422
    assert answer.json()["details"]["field"] == field, answer.text


def test_a_version_of_another_template_is_no_base(
    therapist: Any, stored: tuple[str, str], engine: Engine, world: Any
) -> None:
    other = store_template(engine, world, None, "Another")
    assert draw(therapist, (stored[0], other[1]), {}).status_code == 422
    assert draw(therapist, other, {}).status_code == 201, "of the clinic"


def test_only_who_treats_draws(
    sign_in: Any, patient: Any, stored: tuple[str, str], engine: Engine, world: Any
) -> None:
    assert draw(sign_in("reader"), stored, {}).status_code == 403
    assert draw(patient, stored, {}).status_code == 403
    of_clinic = store_template(engine, world, None, "Of the clinic")
    assert draw(patient, of_clinic, {}).status_code == 404
