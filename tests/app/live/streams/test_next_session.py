"""A gateway that knows nothing but its token finds the session to join."""

import pytest
from sqlalchemy import select

from app.accounts.models import AuditEvent
from app.database.unit_of_work import read_only, unit_of_work
from app.live.repository import open_by_ticket
from app.recordings.models import MotionSession

PATH = "/api/devices/next-session"
PLACEMENTS = ["sternum", "upper_arm_right", "forearm_right"]


@pytest.fixture
def begin(therapist):
    def make(patient_id, **more):
        answer = therapist.post(
            "/api/sessions", json={"patient_id": patient_id, "placements": PLACEMENTS} | more
        )
        assert answer.status_code == 201, answer.text
        return answer.json()["id"]

    return make


def test_the_newest_open_session_comes_with_its_placements_and_a_ticket(begin, device_client, world, engine):
    gateway = device_client(world.patient_id)
    refused = gateway.post(PATH)
    assert (refused.status_code, refused.json()["code"]) == (404, "no_open_session")
    begin(world.patient_id)
    newest = begin(world.patient_id)
    found = gateway.post(PATH)
    assert found.status_code == 200, found.text
    answer = found.json()
    assert (answer["session_id"], answer["state"], answer["placements"]) == (newest, "created", PLACEMENTS)
    # The ticket opens this session, once.
    subject, stored = open_by_ticket(engine, answer["ticket"])
    assert (subject.kind, stored.id) == ("device", newest)
    with read_only(engine) as session:
        events = session.scalars(select(AuditEvent).where(AuditEvent.action == "session.ticket")).all()
        assert [(one.patient_id, one.resource_id) for one in events] == [(world.patient_id, newest)]


def test_a_gateway_that_comes_back_finds_its_session_and_none_that_is_over(
    begin, device_client, world, engine
):
    gateway = device_client(world.patient_id)
    session_id = begin(world.patient_id)
    for state, is_open in (("link_lost", True), ("recording", True), ("failed", False), ("analysed", False)):
        with unit_of_work(engine) as session:
            session.get_one(MotionSession, session_id).state = state
        assert gateway.post(PATH).status_code == (200 if is_open else 404), state


def test_only_the_own_patient_and_only_devices(begin, device_client, therapist, world):
    begin(world.patient_id)
    assert device_client(world.foreign_patient_id).post(PATH).status_code in {403, 404}
    refused = therapist.post(PATH)
    assert refused.status_code == 403
    assert "device token" in refused.json()["message"]


def test_without_consent_nothing_is_joined(begin, device_client, therapist, world):
    begin(world.patient_id)
    therapist.put(
        f"/api/patients/{world.patient_id}/consents", json={"purpose": "home_streaming", "granted": False}
    )
    assert device_client(world.patient_id).post(PATH).status_code == 403
