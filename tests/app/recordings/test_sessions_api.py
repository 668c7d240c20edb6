"""Sessions over HTTP: what is shown to whom, and what leaves an audit event."""

import struct
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app import readers
from app.accounts.models import AuditEvent
from app.database.unit_of_work import read_only, unit_of_work
from app.patients.models import Mounting
from app.recordings.analysis.jobs import run_job
from app.recordings.analysis.reprocess import reprocess
from app.recordings.models import Job, MotionSession, SignalChunk
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Settings
from estimators import orientation
from estimators.pipelines import Calibration, SessionSetup
from estimators.simulation import ArmScenario, Schedule, simulate_arm

ARM = ("sternum", "upper_arm_right", "forearm_right")


@pytest.fixture
def analysed(engine: Engine, settings: Settings, new_session: Callable[..., str]) -> str:
    """A stored and analysed session of the patient of `world`."""
    recording = simulate_arm(
        ArmScenario(placements=ARM, schedule=Schedule(n_pose_s=5.0, repetitions=1, pause_s=0.2), seed=1)
    ).recording
    prepared = readers.packets_of(recording)
    session_id = new_session(state="analysed", hello=prepared.declaration.to_dict())
    writer = GroupCommitWriter(engine, commit_interval_s=0.01)
    writer.start()
    writer.open_session(session_id)
    for packet in prepared.packets(77):
        writer.append_packet(session_id, packet)
    writer.add_event(session_id, "calibration", 1.0, duration_s=3.0, text="Pose held.")
    writer.flush(session_id).result(10)
    writer.close()
    with unit_of_work(engine) as session:
        job = Job(session_id=session_id, kind="reprocess", arguments={}, created_by="x")
        session.add(job)
    assert run_job(engine, settings, job.id, reprocess).status == "complete"
    return session_id


def wanted(world: Any, **changes: Any) -> dict[str, Any]:
    return {
        "patient_id": world.patient_id,
        "exercise_id": world.exercise_id,
        "placements": list(ARM),
        **changes,
    }


def actions(engine: Engine) -> list[str]:
    with read_only(engine) as session:
        return list(session.scalars(select(AuditEvent.action).order_by(AuditEvent.number)))


def test_a_session_is_created_listed_and_shown(therapist: Any, world: Any, engine: Engine) -> None:
    answer = therapist.post("/api/sessions", json=wanted(world))
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert (made["state"], made["source"], made["calibration"], made["results"]) == (
        "created",
        "stream",
        None,
        [],
    )
    assert made["exercise_name"] == "Reach forward"
    assert made["may_treat"] is True
    # The columns are known before the first packet.
    assert "humerus_forearm_right_zxy_flexion" in made["layout"]["angles"]
    assert therapist.get(f"/api/sessions/{made['id']}").json() == made
    listed = therapist.get(f"/api/patients/{world.patient_id}/sessions").json()
    assert [row["id"] for row in listed] == [made["id"]]
    # What is measured names a session without an exercise, in the list as on its page.
    assert [row["pipeline"] for row in listed] == [made["pipeline"]] == ["arm"]
    assert {"session.create", "session.read", "session.list"} <= set(actions(engine))


def test_body_dimensions_of_the_patient_enter_the_setup(therapist: Any, world: Any, engine: Engine) -> None:
    therapist.patch(
        f"/api/patients/{world.patient_id}", json={"body_dimensions": {"stature_m": 1.9, "forearm_m": 0.31}}
    )
    made = therapist.post("/api/sessions", json=wanted(world)).json()
    with read_only(engine) as session:
        body = session.get_one(MotionSession, made["id"]).setup["body"]
    assert body["forearm_m"] == 0.31
    assert body["upper_arm_m"] == pytest.approx(0.186 * 1.9)


@pytest.mark.parametrize(
    ("changes", "status", "says"),
    [
        ({"placements": ["hand_right"]}, 422, "upper arm or a forearm"),
        ({"placements": ["nose"]}, 422, "placements"),
        ({"placements": ["forearm_right", "forearm_right"]}, 422, "twice"),
        ({"orientation": "magic"}, 422, "magic"),
        ({"orientation_parameters": {"speed": 3}}, 422, "speed"),
        ({"exercise_id": "0" * 32}, 422, "Exercise not found"),
        ({"prescription_id": "0" * 32}, 422, "prescription"),
        ({"patient_id": "0" * 32}, 404, "Patient not found"),
    ],
)
def test_a_session_that_cannot_be_is_refused_in_words(
    therapist: Any, world: Any, changes: dict[str, Any], status: int, says: str
) -> None:
    answer = therapist.post("/api/sessions", json=wanted(world, **changes))
    assert answer.status_code == status, answer.text
    assert says in answer.json()["message"]


def test_a_patient_exercises_but_records_no_templates(patient: Any, world: Any) -> None:
    assert patient.post("/api/sessions", json=wanted(world)).status_code == 201
    assert patient.post("/api/sessions", json=wanted(world, purpose="template")).status_code == 403


def blocks(content: bytes) -> tuple[dict[str, float], np.ndarray]:
    magic, ticks, columns, first, start_s, step_s, _ = struct.unpack_from("<4sIIIddd", content)
    assert magic == b"TMF1"
    table = np.frombuffer(content, "<f4", offset=40).reshape(ticks, columns)
    return {"first": first, "start_s": start_s, "step_s": step_s}, table


def test_frames_come_in_the_columns_of_the_layout(therapist: Any, analysed: str, engine: Engine) -> None:
    answer = therapist.get(f"/api/sessions/{analysed}/frames", params={"start_s": 1, "end_s": 3})
    assert answer.status_code == 200
    layout = therapist.get(answer.headers["X-Columns-Url"]).json()
    head, table = blocks(answer.content)
    assert head == {"first": 100, "start_s": 1.0, "step_s": 0.01}
    assert table.shape == (200, len(layout["columns"]))
    # The pose was held there: the elbow is straight within the N-pose's own tolerance.
    flexion = np.degrees(table[:, layout["columns"].index("humerus_forearm_right_zxy_flexion")])
    assert np.abs(flexion).max() < 5.0
    head, table = blocks(
        therapist.get(f"/api/sessions/{analysed}/frames", params={"max_points": 100}).content
    )
    assert table.shape[0] <= 100
    assert head["step_s"] == pytest.approx(0.01 * round(head["step_s"] / 0.01))
    assert "session.frames" in actions(engine)


def test_the_download_can_be_uploaded_again(
    therapist: Any, analysed: str, tmp_path: Path, engine: Engine
) -> None:
    answer = therapist.get(f"/api/sessions/{analysed}/raw")
    assert answer.status_code == 200
    assert analysed[:8] in answer.headers["content-disposition"]
    path = tmp_path / "again.tmlog"
    path.write_bytes(answer.content)
    log = readers.LogReader(path)
    packets = [raw for raw, _ in log.packets()]
    with read_only(engine) as session:
        stored = session.get_one(MotionSession, analysed).packets_stored
    assert len(packets) == stored
    assert log.damaged == 0
    assert {packet.arrival_ns for packet in packets} == {77}
    assert "session.download" in actions(engine)


def test_deleting_takes_everything_but_the_audit(therapist: Any, analysed: str, engine: Engine) -> None:
    assert therapist.delete(f"/api/sessions/{analysed}").status_code == 204
    assert therapist.get(f"/api/sessions/{analysed}").status_code == 404
    with read_only(engine) as session:
        assert session.scalars(select(SignalChunk.sequence)).all() == []
    assert "session.delete" in actions(engine)


def test_a_live_session_is_not_deleted(therapist: Any, new_session: Callable[..., str]) -> None:
    answer = therapist.delete(f"/api/sessions/{new_session(state='recording')}")
    assert answer.status_code == 409


ROUTES = [
    ("GET", "/api/sessions/{id}"),
    ("GET", "/api/sessions/{id}/frames"),
    ("GET", "/api/sessions/{id}/layout"),
    ("GET", "/api/sessions/{id}/raw"),
    ("GET", "/api/sessions/{id}/jobs"),
    ("POST", "/api/sessions/{id}/reprocess"),
    ("DELETE", "/api/sessions/{id}"),
]


def test_strangers_get_nothing_from_any_route(sign_in: Any, nobody: Any, analysed: str, world: Any) -> None:
    strangers = ["colleague", "former", "expired", "integrator", "other_patient", "foreign_therapist"]
    for method, path in ROUTES:
        body = {"json": {"orientation": "vqf"}} if method == "POST" else {}
        url = path.format(id=analysed)
        assert nobody.request(method, url, **body).status_code == 401, path
        for name in strangers:
            answer = sign_in(name).request(method, url, **body)
            assert answer.status_code == 404, (name, path)
            assert analysed not in answer.text
    assert sign_in("colleague").get(f"/api/patients/{world.patient_id}/sessions").status_code == 404


def test_a_reader_reads_but_changes_nothing(sign_in: Any, analysed: str) -> None:
    reader = sign_in("reader")
    for method, path in ROUTES:
        body = {"json": {"orientation": "vqf"}} if method == "POST" else {}
        status = reader.request(method, path.format(id=analysed), **body).status_code
        assert status == (200 if method == "GET" else 403), path
    assert reader.get(f"/api/sessions/{analysed}").json()["may_treat"] is False


def test_the_estimators_are_listed_with_their_parameters(therapist: Any) -> None:
    listed = therapist.get("/api/estimators").json()
    assert listed[0]["name"] == orientation.DEFAULT
    assert all(row["parameters"] and row["description"] for row in listed)
    assert [row["name"] for row in listed if row["is_offline"]] == ["telemotion_smoother"]


def test_a_smoother_is_not_for_recording_live(therapist: Any, world: Any) -> None:
    wanted = {"patient_id": world.patient_id, "purpose": "exercise", "pipeline": "arm"}
    wanted |= {"placements": ["forearm_right", "upper_arm_right"], "orientation": "telemotion_smoother"}
    answer = therapist.post("/api/sessions", json=wanted)
    assert answer.status_code == 422
    assert answer.json()["sentences"]["message"]["code"] == "session.offline_estimator"


def test_of_a_remembered_mounting_only_the_mounting_is_used(
    therapist: Any, world: Any, engine: Engine
) -> None:
    """Facing, headings between sensors and gyroscope biases of another day would be wrong, unflagged."""
    quarter = (0.7071067811865476, 0.0, 0.0, 0.7071067811865476)
    day_before = Calibration(
        dict.fromkeys(ARM, quarter),
        dict.fromkeys(ARM, (0.01, 0.02, 0.03)),
        facing_rad=0.6,
        heading_offset_rad={"forearm_right": 0.4},
        method="level, n_pose",
        score=0.9,
    )
    first = therapist.post("/api/sessions", json=wanted(world)).json()
    with unit_of_work(engine) as session:
        stored = asdict(day_before)
        session.add(Mounting(patient_id=world.patient_id, session_id=first["id"], calibration=stored))
    made = therapist.post("/api/sessions", json=wanted(world)).json()
    assert made["calibration"] == {
        "method": "n_pose",
        "score": 0.9,
        "reasons": [],
        "sentences": {},
        "needs_headings": True,
    }
    with read_only(engine) as session:
        setup = SessionSetup.from_dict(session.get_one(MotionSession, made["id"]).setup)
    assert setup.calibration == Calibration(dict.fromkeys(ARM, quarter), {}, score=0.9, unknown_headings=ARM)
    other = therapist.post("/api/sessions", json=wanted(world, use_mounting=False)).json()
    assert other["calibration"] is None
