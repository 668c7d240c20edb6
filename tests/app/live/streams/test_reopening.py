"""A session that ended by itself takes what its gateway still had, and is found as if nothing had been late."""

from typing import Any

import pytest
from sqlalchemy import Engine, select

from app.database.base import utc_now
from app.database.unit_of_work import read_only
from app.gateway import DeviceStream, stream_of
from app.live.housekeeping import Housekeeping
from app.network.packet import PacketFlag, with_flags
from app.recordings.models import MotionSession
from app.recordings.signals.store import read_packets
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.app.live.streams.test_closing import hello, new_session, receive_until, state_of, wait_for_state

BEFORE = 40
"""Packets that came before the link broke."""


@pytest.fixture(scope="module")
def stream() -> DeviceStream:
    scenario = ArmScenario(schedule=Schedule(n_pose_s=4.0, repetitions=1), seed=7)
    return stream_of(simulate_arm(scenario).recording)


def send(client: Any, session_id: str, stream: DeviceStream, numbers: range, flags: PacketFlag) -> None:
    with client.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(client, session_id, stream))
        for number in numbers:
            socket.send_bytes(with_flags(stream.packet(number), flags))
        receive_until(socket, lambda message: message.get("acknowledged") == numbers[-1])


def end(client: Any, session_id: str) -> None:
    client.post(f"/api/sessions/{session_id}/close")
    wait_for_state(client, session_id, {"analysed"})


def test_an_ended_session_takes_the_rest_and_is_analysed_whole(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine
) -> None:
    late, whole = (new_session(therapist, world.patient_id, stream) for _ in range(2))
    send(therapist, late, stream, range(BEFORE), PacketFlag(0))
    end(therapist, late)
    first = therapist.get(f"/api/sessions/{late}").json()

    answer = therapist.post(f"/api/sessions/{late}/reopen").json()
    assert (answer["state"], answer["sentences"]["reason"]["code"]) == ("link_lost", "live.reopened")
    # Twice is once.
    assert therapist.post(f"/api/sessions/{late}/reopen").json()["state"] == "link_lost"
    send(therapist, late, stream, range(BEFORE, stream.packet_count), PacketFlag.BACKFILLED)
    end(therapist, late)

    send(therapist, whole, stream, range(stream.packet_count), PacketFlag(0))
    end(therapist, whole)
    stored = [sorted((p.sequence, p.payload) for p in read_packets(engine, one)) for one in (late, whole)]
    assert stored[0] == stored[1]
    found, undisturbed = (therapist.get(f"/api/sessions/{one}").json() for one in (late, whole))
    assert found["duration_s"] == undisturbed["duration_s"] > first["duration_s"]
    assert found["main_result_id"] != first["main_result_id"]
    assert found["packets_missing"] == 0
    # What was found before stays.
    assert first["main_result_id"] in {one["id"] for one in found["results"]}


@pytest.mark.parametrize("ended_by", ["session", "person"])
def test_a_recording_goes_on_where_only_the_end_of_the_session_has_ended_it(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine, ended_by: str
) -> None:
    session_id = new_session(therapist, world.patient_id, stream)
    send(therapist, session_id, stream, range(BEFORE), PacketFlag(0))
    end(therapist, session_id)
    table = MotionSession.__table__
    with engine.begin() as connection:
        end_s = connection.execute(select(table.c.duration_s).where(table.c.id == session_id)).scalar_one()
        stopped_s = end_s if ended_by == "session" else end_s - 2.0
        recorded = {"recording_start_s": 1.0, "recording_end_s": stopped_s}
        connection.execute(table.update().where(table.c.id == session_id).values(**recorded))
    therapist.post(f"/api/sessions/{session_id}/reopen")
    send(therapist, session_id, stream, range(BEFORE, stream.packet_count), PacketFlag.BACKFILLED)
    end(therapist, session_id)
    with read_only(engine) as session:
        found = session.get_one(MotionSession, session_id)
        assert found.recording_start_s == 1.0
        if ended_by == "person":
            assert found.recording_end_s == stopped_s
        else:
            assert found.recording_end_s == pytest.approx(found.duration_s, abs=0.1)
            assert found.duration_s > end_s + 1.0


def test_one_of_which_nothing_had_come_takes_all(therapist: Any, world: Any, stream: DeviceStream) -> None:
    session_id = new_session(therapist, world.patient_id, stream)
    # Still open: it stays as it is.
    assert therapist.post(f"/api/sessions/{session_id}/reopen").json()["reason"] == ""
    therapist.post(f"/api/sessions/{session_id}/close")
    wait_for_state(therapist, session_id, {"failed"})
    assert therapist.post(f"/api/sessions/{session_id}/reopen").json()["state"] == "created"
    send(therapist, session_id, stream, range(stream.packet_count), PacketFlag.BACKFILLED)
    end(therapist, session_id)


def test_what_is_closed_without_anything_new_is_not_analysed_again(
    therapist: Any, world: Any, stream: DeviceStream
) -> None:
    session_id = new_session(therapist, world.patient_id, stream)
    send(therapist, session_id, stream, range(BEFORE), PacketFlag(0))
    end(therapist, session_id)
    before = therapist.get(f"/api/sessions/{session_id}").json()
    for connects in (False, True):
        therapist.post(f"/api/sessions/{session_id}/reopen")
        if connects:
            send(therapist, session_id, stream, range(BEFORE - 1, BEFORE), PacketFlag.BACKFILLED)
        end(therapist, session_id)
    after = therapist.get(f"/api/sessions/{session_id}").json()
    assert [one["id"] for one in after["results"]] == [one["id"] for one in before["results"]]
    assert (after["main_result_id"], after["duration_s"]) == (before["main_result_id"], before["duration_s"])


def test_only_one_that_had_ended_ends_where_no_gateway_comes(
    therapist: Any, world: Any, stream: DeviceStream, monkeypatch: pytest.MonkeyPatch
) -> None:
    noted: list[str] = []
    monkeypatch.setattr(Housekeeping, "abandoned", lambda _, session_id: noted.append(session_id))
    planned, ended = (new_session(therapist, world.patient_id, stream) for _ in range(2))
    send(therapist, ended, stream, range(BEFORE), PacketFlag(0))
    end(therapist, ended)
    for session_id in (planned, ended):
        assert therapist.post(f"/api/sessions/{session_id}/reopen").status_code == 200
    assert noted == [ended]


def test_an_upload_is_refused(therapist: Any, world: Any, stream: DeviceStream, engine: Engine) -> None:
    session_id = new_session(therapist, world.patient_id, stream)
    table = MotionSession.__table__
    with engine.begin() as connection:
        uploaded = {"source": "upload", "state": "analysed", "ended_at": utc_now()}
        connection.execute(table.update().where(table.c.id == session_id).values(**uploaded))
    refused = therapist.post(f"/api/sessions/{session_id}/reopen")
    assert (refused.status_code, refused.json()["code"]) == (409, "conflict")
    assert state_of(therapist, session_id) == "analysed"
