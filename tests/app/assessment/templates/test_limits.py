"""A limit, a stop rule or a band that the recording itself or the patient at rest breaks is refused, with the value."""

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.assessment import practice
from app.assessment.design import limits, prescribing, shown
from app.assessment.design.compiled import apply_design
from app.assessment.design.limits import Reached, narrow_band, troubles_of
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.design import KnotDesign, StopDesign, TemplateDesign, ToleranceDesign
from app.exercises.models import Prescription, TemplateVersion
from estimators.comparison import mirror_template, template_from_bytes
from estimators.guidance import farthest, nearest_limit, proposed_limit
from tests.said import codes

from .drawing import ELEVATION, FORWARD, MAIN, planar_template, store_template


@pytest.fixture
def stored(engine: Engine, world: Any) -> tuple[str, str]:
    return store_template(engine, world, world.patient_id)


def extreme(channel: str, side: str) -> float:
    return farthest(side, planar_template().mean[:, planar_template().channels.index(channel)])


def limit(channel: str, value: float, side: str = "above") -> dict[str, Any]:
    return {"kind": "limit", "channel": channel, "limit": value, "side": side, "hold_s": 0.05}


@pytest.mark.parametrize("side", ["above", "below"])
def test_every_limit_of_every_angle_is_held_against_the_recording(side: str) -> None:
    sign = 1.0 if side == "above" else -1.0
    recorded = planar_template()
    mirrored = mirror_template(recorded)
    measured = [
        name
        for name, values in zip(recorded.channels, recorded.mean.T, strict=True)
        if "." not in name and np.isfinite(values).any()
    ]
    assert len(measured) > 1
    for template, name in [
        *((recorded, one) for one in measured),
        *((mirrored, one.replace("right", "left")) for one in measured),
    ]:
        values = template.mean[:, template.channels.index(name)]
        tight = nearest_limit(name, side, farthest(side, values))
        for value, is_refused in ((tight, False), (tight - sign * 0.02, True), (tight + sign * 0.02, False)):
            stop = StopDesign.model_validate(limit(name, value, side))
            assert bool(list(troubles_of([stop], Reached(template)))) is is_refused, name
        # What is proposed can be kept, and lies at least a margin beyond what was done.
        proposed = proposed_limit(name, side, values)
        margin = 0.05 if name.endswith("_m") else math.radians(10)
        assert sign * (proposed - farthest(side, values)) >= margin - 1e-9, name
        kept = StopDesign.model_validate(limit(name, proposed, side))
        assert not list(troubles_of([kept], Reached(template))), name


def test_own_repetitions_count_beside_their_mean() -> None:
    further = planar_template().mean + np.radians(20.0)
    stop = StopDesign.model_validate(limit(MAIN, extreme(MAIN, "above") + np.radians(15.0)))
    assert not list(troubles_of([stop], Reached(planar_template())))
    ((_, said),) = troubles_of([stop], Reached(planar_template(), [planar_template().mean, further]))
    assert said.code == "design.limit_above"
    value = said.parameters["value"].parameters["value_rad"]
    assert value == pytest.approx(extreme(MAIN, "above") + np.radians(20.0))


def test_a_patient_at_rest_breaks_a_limit_that_the_recording_keeps() -> None:
    value = extreme(MAIN, "above") + np.radians(10.0)
    stop = StopDesign.model_validate(limit(MAIN, value))
    ((_, said),) = troubles_of([stop], Reached(planar_template(), rest={MAIN: value + 0.1}))
    assert said.code == "design.rest_above"
    below = StopDesign.model_validate(limit(FORWARD, extreme(FORWARD, "below") - 0.2, "below"))
    ((_, said),) = troubles_of([below], Reached(planar_template(), rest={FORWARD: -1.0}))
    assert said.code == "design.rest_below"


def test_a_band_that_its_own_repetitions_leave_is_too_narrow() -> None:
    # Repetitions on either side of the mean, each well within the recorded band and outside a tenth of it.
    own = [
        planar_template().mean + factor * planar_template().tolerance for factor in (0.4, -0.4, 0.45, 0.02)
    ]
    column = planar_template().channels.index(FORWARD)
    for one in own:
        kept = one[:, column].copy()
        one[:] = planar_template().mean
        one[:, column] = kept
    tenth = TemplateDesign(
        tolerances=[ToleranceDesign(channel=FORWARD, knots=[KnotDesign(phase=0.0, below=0.1, above=0.1)])]
    )
    said = narrow_band(Reached(apply_design(planar_template(), tenth), own), planar_template())
    assert said is not None
    assert said.code == "design.band_narrow"
    assert (said.parameters["left"], said.parameters["of"]) == (3, 4)
    assert said.parameters["excess"].parameters["value_rad"] == pytest.approx(
        0.35 * np.nanmax(planar_template().tolerance[:, column]), rel=0.1
    )
    half = TemplateDesign(
        tolerances=[ToleranceDesign(channel=FORWARD, knots=[KnotDesign(phase=0.0, below=0.5, above=0.5)])]
    )
    assert narrow_band(Reached(apply_design(planar_template(), half), own), planar_template()) is None
    # The same by a prescription's factor on the whole band, and not of what is only watched.
    assert (
        narrow_band(Reached(apply_design(planar_template(), TemplateDesign(), 0.1), own), planar_template())
        is not None
    )
    watched = TemplateDesign(tolerances=tenth.tolerances, watched=[FORWARD])
    assert narrow_band(Reached(apply_design(planar_template(), watched), own), planar_template()) is None


def draw(
    client: Any, stored: tuple[str, str], stops: list[dict[str, Any]], based_on: str | None = None
) -> Any:
    body = {"based_on": based_on or stored[1], "design": {"stops": stops}, "reason": "A limit"}
    return client.post(f"/api/templates/{stored[0]}/versions", json=body)


@pytest.mark.parametrize(
    ("made", "code"),
    [
        (lambda: limit(MAIN, extreme(MAIN, "above") - 0.5), "design.limit_above"),
        (lambda: limit(ELEVATION, extreme(ELEVATION, "below") + 0.5, "below"), "design.limit_below"),
        (lambda: {"kind": "time", "limit": 0.3, "hold_s": 0.0}, "design.time_short"),
    ],
)
def test_rest_of_the_editor_refuses_a_rule_that_its_template_breaks(
    therapist: Any, stored: tuple[str, str], world: Any, made: Callable[[], dict[str, Any]], code: str
) -> None:
    rule = made()
    answer = draw(therapist, stored, [rule])
    assert answer.status_code == 422, answer.text
    error = answer.json()
    assert code in answer.text
    if rule["kind"] == "limit":
        assert f"{np.degrees(extreme(rule['channel'], rule['side'])):.0f}°".replace("-", "−") in answer.text
    assert "design.stops.0" in str(error)
    (listed,) = therapist.get("/api/templates", params={"patient_id": world.patient_id}).json()
    assert len(listed["versions"]) == 1


def prescribe(client: Any, world: Any, template_id: str, **more: Any) -> Any:
    body = {"exercise_id": world.exercise_id, "template_id": template_id, **more}
    return client.post(f"/api/patients/{world.patient_id}/prescriptions", json=body)


def test_rest_of_the_prescription_refuses_it_alike_when_made_and_when_changed(
    therapist: Any, stored: tuple[str, str], world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    bad = limit(MAIN, extreme(MAIN, "above") - 0.3)
    assert "design.limit_above" in prescribe(therapist, world, stored[0], stops=[bad]).text
    elsewhere = limit("thigh_shank_right_zxy_flexion", 3.0)
    assert "design.limit_channel" in prescribe(therapist, world, stored[0], stops=[elsewhere]).text
    good = limit(
        MAIN, proposed_limit(MAIN, "above", planar_template().mean[:, planar_template().channels.index(MAIN)])
    )
    made = prescribe(therapist, world, stored[0], stops=[good])
    assert made.status_code == 201, made.text
    assert made.json()["troubles"] == []
    path = f"/api/prescriptions/{made.json()['id']}"
    assert "design.limit_above" in therapist.patch(path, json={"number": 1, "stops": [bad]}).text
    # This patient rests beyond it, as her last compared session shows.
    monkeypatch.setattr(prescribing, "resting_pose", lambda *_: {MAIN: good["limit"] + 0.2})
    assert "design.rest_above" in therapist.patch(path, json={"number": 1, "stops": [good]}).text
    assert therapist.get(f"/api/patients/{world.patient_id}/prescriptions").json()[0]["number"] == 1


def test_a_rule_that_was_stored_before_is_said_where_it_is_shown(
    therapist: Any, stored: tuple[str, str], world: Any, engine: Engine
) -> None:
    made = prescribe(therapist, world, stored[0])
    bad = limit(MAIN, extreme(MAIN, "above") - 0.3)
    with unit_of_work(engine) as session:
        session.get_one(TemplateVersion, stored[1]).design = {"stops": [copy.deepcopy(bad)]}
        session.get_one(Prescription, made.json()["id"]).stops = [copy.deepcopy(bad)]
    shown_version = therapist.get(f"/api/template-versions/{stored[1]}").json()
    assert [one["code"] for one in shown_version["sentences"]["troubles"]] == ["design.limit_above"]
    (listed,) = therapist.get(f"/api/patients/{world.patient_id}/prescriptions").json()
    assert [one["code"] for one in listed["sentences"]["troubles"]] == [
        "prescription.of_template",
        "design.limit_above",
    ]
    assert "In its template: Stop rule 1" in listed["troubles"][0]


def test_a_template_is_held_against_the_rest_of_whom_it_is_prescribed_to(
    therapist: Any, stored: tuple[str, str], world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A limit that the recording keeps, and that this patient breaks before any movement."""
    good = limit(
        MAIN, proposed_limit(MAIN, "above", planar_template().mean[:, planar_template().channels.index(MAIN)])
    )
    with unit_of_work(engine) as session:
        session.get_one(TemplateVersion, stored[1]).design = {"stops": [copy.deepcopy(good)]}
    assert prescribe(therapist, world, stored[0]).json()["troubles"] == []
    monkeypatch.setattr(practice, "resting_pose", lambda *_: {MAIN: good["limit"] + 0.2})
    (listed,) = therapist.get(f"/api/patients/{world.patient_id}/prescriptions").json()
    (said,) = listed["sentences"]["troubles"]
    assert said["code"] == "prescription.of_template"
    assert said["params"]["trouble"]["code"] == "design.rest_above"


def test_what_no_recording_shows_is_not_asked_for(
    engine: Engine, world: Any, stored: tuple[str, str]
) -> None:
    with read_only(engine) as session:
        version = session.get_one(TemplateVersion, stored[1])
        reached = shown.reached_of(
            session, world.subjects["therapist"], version, template_from_bytes(version.content)
        )
        assert list(reached.own) == []
        assert limits.resting_pose(session, world.patient_id, world.exercise_id) == {}
    assert codes([text for _, text in troubles_of([], reached)]) == []
