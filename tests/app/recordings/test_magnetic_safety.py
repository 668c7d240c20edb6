"""Nobody with a pacemaker near a source: confirmed for each session, by a therapist, before a gateway gets in."""

from collections.abc import Callable
from datetime import datetime, timedelta
from typing import Any

import pytest
from sqlalchemy import Engine, select

from app.accounts.credentials.tickets import issue_ticket
from app.accounts.models import AuditEvent
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import SafetyUnconfirmed
from app.kinds.magnetic.safety import CONFIRMATION_HOURS, EVENT
from app.live.repository import open_by_ticket, source_refusal
from app.recordings.models import SessionEvent
from estimators.pipelines import SessionSetup

SAID = {"patient_has_no_implant": True, "people_nearby_have_none": True}


@pytest.fixture
def magnetic(therapist: Any, world: Any) -> str:
    answer = therapist.post(
        "/api/sessions",
        json={
            "patient_id": world.patient_id,
            "pipeline": "relative_pose",
            "placements": ["pelvis", "sternum"],
            "rate_hz": 120.0,
        },
    )
    assert answer.status_code == 201, answer.text
    assert answer.json()["layout"]["points"] == ["pelvis", "sternum"]
    return answer.json()["id"]


def test_no_gateway_gets_in_before_the_therapist_has_confirmed(
    therapist: Any, magnetic: str, engine: Engine, world: Any
) -> None:
    shown = therapist.get(f"/api/sessions/{magnetic}/magnetic-safety").json()
    assert (shown["required"], shown["confirmed"], shown["source"]) == (True, False, "pelvis")
    assert "pacemaker" in shown["warning"]
    assert 0.05 < shown["keep_away_m"] < 1.0
    refused = therapist.post(f"/api/sessions/{magnetic}/ticket", json={"purpose": "ingest"})
    assert refused.status_code == 409
    assert refused.json()["code"] == "safety_unconfirmed"
    assert magnetic in refused.json()["details"]["confirm"]
    # Looking is harmless.
    assert therapist.post(f"/api/sessions/{magnetic}/ticket", json={"purpose": "live"}).status_code == 200
    told = therapist.post(f"/api/sessions/{magnetic}/magnetic-safety", json=SAID)
    assert told.status_code == 200, told.text
    assert told.json()["confirmed"] is True
    assert told.json()["confirmed_by"]
    assert told.json()["confirmed_at"]
    assert therapist.post(f"/api/sessions/{magnetic}/magnetic-safety", json=SAID).json() == told.json()
    assert therapist.post(f"/api/sessions/{magnetic}/ticket", json={"purpose": "ingest"}).status_code == 200
    with read_only(engine) as session:
        noted = session.scalars(
            select(AuditEvent).where(AuditEvent.action == "session.implants_excluded")
        ).all()
    assert [(event.resource_id, event.patient_id) for event in noted] == [(magnetic, world.patient_id)]
    assert noted[0].details == SAID
    assert noted[0].subject_id


@pytest.mark.parametrize(
    "said",
    [
        {},
        {"patient_has_no_implant": True},
        {"patient_has_no_implant": True, "people_nearby_have_none": False},
    ],
)
def test_half_a_confirmation_is_none(therapist: Any, magnetic: str, said: dict[str, bool]) -> None:
    assert therapist.post(f"/api/sessions/{magnetic}/magnetic-safety", json=said).status_code == 422
    assert therapist.get(f"/api/sessions/{magnetic}/magnetic-safety").json()["confirmed"] is False


def test_the_patient_may_not_confirm_and_other_sessions_have_nothing_to(
    therapist: Any, patient: Any, magnetic: str, new_session: Callable[..., str]
) -> None:
    assert patient.post(f"/api/sessions/{magnetic}/magnetic-safety", json=SAID).status_code == 403
    arm = new_session()
    assert therapist.get(f"/api/sessions/{arm}/magnetic-safety").json()["required"] is False
    assert therapist.post(f"/api/sessions/{arm}/magnetic-safety", json=SAID).status_code == 409
    assert therapist.get(f"/api/sessions/{arm}/source-use").status_code == 409


def test_a_ticket_from_elsewhere_does_not_help(
    engine: Engine, new_session: Callable[..., str], world: Any
) -> None:
    session_id = new_session(
        setup=SessionSetup("relative_pose", ("pelvis", "sternum"), 120.0), state="created"
    )
    account = world.accounts["therapist"]
    who = Subject("account", account, account, world.clinic_id, "therapist", None)
    with unit_of_work(engine) as session:
        ticket, _ = issue_ticket(session, who, "ingest", session_id)
    with pytest.raises(SafetyUnconfirmed):
        open_by_ticket(engine, ticket)


def test_a_therapist_takes_the_word_back_and_the_gateway_stays_out_until_it_is_given_again(
    therapist: Any, patient: Any, magnetic: str, engine: Engine, world: Any
) -> None:
    path = f"/api/sessions/{magnetic}/magnetic-safety"
    assert therapist.delete(path).status_code == 409, "nothing to take back"
    therapist.post(path, json=SAID)
    assert patient.delete(path).status_code == 403
    told = therapist.delete(path)
    assert told.status_code == 200, told.text
    assert told.json()["confirmed"] is False
    assert told.json()["withdrawn_at"]
    assert told.json()["withdrawn_by"] == told.json()["confirmed_by"]
    refused = therapist.post(f"/api/sessions/{magnetic}/ticket", json={"purpose": "ingest"})
    assert refused.json()["code"] == "safety_unconfirmed"
    assert "withdrawn" in refused.json()["message"]
    again = therapist.post(path, json=SAID).json()
    assert (again["confirmed"], again["withdrawn_at"]) == (True, None)
    assert again["confirmed_at"] > told.json()["confirmed_at"]
    assert therapist.post(f"/api/sessions/{magnetic}/ticket", json={"purpose": "ingest"}).status_code == 200
    with read_only(engine) as session:
        actions = session.scalars(
            select(AuditEvent.action)
            .where(AuditEvent.action.like("session.implants%"))
            .order_by(AuditEvent.number)
        ).all()
    assert actions == [
        "session.implants_excluded",
        "session.implants_withdrawn",
        "session.implants_excluded",
    ]


def test_the_word_of_yesterday_is_asked_for_again(therapist: Any, magnetic: str, engine: Engine) -> None:
    path = f"/api/sessions/{magnetic}/magnetic-safety"
    first = therapist.post(path, json=SAID).json()
    with unit_of_work(engine) as session:
        event = session.scalars(select(SessionEvent).where(SessionEvent.kind == EVENT)).one()
        event.details = event.details | {
            "at": (utc_now() - timedelta(hours=CONFIRMATION_HOURS, minutes=1)).isoformat()
        }
    old = therapist.get(path).json()
    assert (old["confirmed"], old["withdrawn_at"]) == (False, None)
    assert old["expires_at"] < first["confirmed_at"]
    refused = therapist.post(f"/api/sessions/{magnetic}/ticket", json={"purpose": "ingest"})
    assert "expired" in refused.json()["message"]
    assert source_refusal(engine, magnetic, CONFIRMATION_HOURS) == refused.json()["message"]
    assert source_refusal(engine, magnetic, CONFIRMATION_HOURS + 1.0) is None
    again = therapist.post(path, json=SAID).json()
    assert again["confirmed"] is True
    lasts = datetime.fromisoformat(again["expires_at"]) - datetime.fromisoformat(again["confirmed_at"])
    assert lasts == timedelta(hours=CONFIRMATION_HOURS)


@pytest.mark.parametrize("wrong", [{"current_limit_a": "x"}, {"passes": None}, {"current_limit_a": 500.0}])
def test_parameters_that_cannot_be_are_refused_in_words(
    therapist: Any, world: Any, wrong: dict[str, Any]
) -> None:
    wanted = {
        "patient_id": world.patient_id,
        "pipeline": "relative_pose",
        "placements": ["pelvis", "sternum"],
        "rate_hz": 120.0,
        "orientation_parameters": wrong,
    }
    answer = therapist.post("/api/sessions", json=wanted)
    assert answer.status_code == 422, answer.text
    assert answer.json()["code"] == "invalid_input"
