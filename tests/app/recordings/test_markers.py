"""Markers through the service: uploaded to a session, fused with its sensor, reported, exported, erased."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app import readers
from app.accounts.models import AuditEvent
from app.database.unit_of_work import read_only, unit_of_work
from app.ingest.marker_task import fuse
from app.ingest.upload_task import _write_packets
from app.recordings.analysis.jobs import JobContext, JobRunner, run_job
from app.recordings.models import MotionSession, SignalChunk
from app.services import Services
from app.settings import Settings
from estimators.pipelines import SessionSetup
from estimators.recording import Recording, SensorSignals
from validation.optical.scenes import free_motion

OFFSET_S = 2.5


@pytest.fixture
def worn(engine: Engine, settings: Settings, services: Services, new_session: Any) -> tuple[str, Any]:
    """Return an analysed session of one sensor on the hand, and what it truly did."""
    # The tests run the queued tasks themselves; the service's own runner would take them first on a busy machine.
    services.get(JobRunner).stop()
    scene = free_motion(5, 15.0)
    signals = SensorSignals(scene.time_s, scene.chunk.gyroscope_radps, scene.chunk.accelerometer_mps2)
    prepared = readers.packets_of(Recording({"hand_right": signals}, 100.0))
    setup = SessionSetup("orientation", ("hand_right",), 100.0)
    session_id = new_session(setup=setup, state="analysed", hello=prepared.declaration.to_dict())
    context = JobContext(engine, settings, "none", session_id, None, {})  # type: ignore[arg-type]
    _write_packets(context, prepared.packets(5), lambda packet: 0.0)
    return session_id, scene


def marker_csv(scene: Any) -> bytes:
    """Return a CSV of the marker, millimetres, on a clock of its own, hidden for a second."""
    rows = ["time_s,HAND_x,HAND_y,HAND_z"]
    for t, (x, y, z) in zip(scene.time_s, scene.chunk.marker_m * 1e3, strict=True):
        place = ",," if 9.0 <= t < 10.0 else f"{x:.3f},{y:.3f},{z:.3f}"
        rows.append(f"{t + OFFSET_S:.4f},{place}")
    return "\n".join(rows).encode()


def send(client: Any, session_id: str, content: bytes, **declared: Any) -> Any:
    declaration = {"segment": "hand_right", "format": "csv", **declared}
    return client.post(
        f"/api/sessions/{session_id}/markers",
        files=[
            ("declaration", (None, json.dumps(declaration), "application/json")),
            ("file", ("markers.csv", content, "text/csv")),
        ],
    )


def test_markers_are_fused_reported_exported_and_erased(
    engine: Engine, settings: Settings, worn: Any, therapist: Any, tmp_path: Path
) -> None:
    session_id, scene = worn
    answer = send(therapist, session_id, marker_csv(scene))
    assert answer.status_code == 202, answer.text
    assert therapist.get(f"/api/sessions/{session_id}/markers").json()[0]["status"] == "queued"
    done = run_job(engine, settings, answer.json()["id"], fuse)
    assert done is not None
    assert done.status == "complete", done.message
    (found,) = therapist.get(f"/api/sessions/{session_id}/markers").json()
    report = found["report"]
    # Times of the file count from its first frame; so does the offset.
    assert abs(report["offset_s"]) < 0.001
    assert (report["marker"], report["gap_count"]) == ("HAND", 1)
    assert report["gaps"][0]["length_s"] == pytest.approx(1.0, abs=0.02)
    assert report["gaps"][0]["start_s"] == pytest.approx(9.0, abs=0.02)
    assert max(report["residual_rms_m"]) < 0.001
    assert report["checks"][0]["inertial_m"] < report["checks"][0]["spline_m"]
    assert len(report["curves"]["time_s"]) == len(report["curves"]["residual_m"]) == 600
    lines = therapist.get(f"/api/sessions/{session_id}/markers/motion").text.splitlines()
    values = np.array([[float(x) if x else np.nan for x in line.split(",")] for line in lines[1:]])
    assert lines[0].startswith("time_s,position_x_m")
    rows = np.rint(values[:, 0] * 100).astype(int)
    assert lines[0].endswith("is_gap,measured_x_m,measured_y_m,measured_z_m")
    error = values[:, 1:4] - scene.position_m[rows]
    assert np.nanmax(np.abs(error)) < 0.005
    address = f"/api/sessions/{session_id}/markers/motion/stretch"
    stretch = therapist.get(address, params={"from_s": 8.0, "until_s": 11.0}).json()
    time_s, is_gap = np.array(stretch["time_s"]), np.array(stretch["is_gap"])
    assert stretch["markers_id"] == found["id"]
    assert len(time_s) == 300
    np.testing.assert_array_equal(is_gap, (time_s > 8.995) & (time_s < 9.995))
    places = np.array(stretch["place_m"]).T
    np.testing.assert_allclose(places, scene.position_m[np.rint(time_s * 100).astype(int)], atol=0.005)
    assert [x is None for x in stretch["measured_m"][0]] == is_gap.tolist()
    assert max(stretch["sigma_m"][2]) < 0.01
    assert therapist.get(address, params={"from_s": 8.0, "until_s": 300.0}).status_code == 422
    with read_only(engine) as session:
        actions = {event.action for event in session.scalars(select(AuditEvent))}
    assert {"session.markers", "session.markers.upload", "session.markers.export"} <= actions
    assert therapist.delete(f"/api/sessions/{session_id}").status_code == 204
    with read_only(engine) as session:
        assert not session.scalars(select(SignalChunk.stream)).all()


@pytest.mark.slow
def test_the_fused_path_is_shown_in_3d(engine: Engine, settings: Settings, worn: Any, therapist: Any) -> None:
    session_id, scene = worn
    wanted = {"mode": "replay", "markers_id": "none"}
    address = f"/api/sessions/{session_id}/views"
    assert therapist.post(address, json=wanted).status_code == 404
    answer = send(therapist, session_id, marker_csv(scene))
    run_job(engine, settings, answer.json()["id"], fuse)
    (found,) = therapist.get(f"/api/sessions/{session_id}/markers").json()
    wanted["markers_id"] = found["id"]
    view = therapist.post(address, json=wanted)
    assert view.status_code == 201, view.text
    assert therapist.get(view.json()["page_path"]).status_code == 200
    assert therapist.post(address, json={**wanted, "mode": "live"}).status_code == 422


def test_what_cannot_be_fused_is_told_and_kept(
    engine: Engine, settings: Settings, worn: Any, therapist: Any
) -> None:
    session_id, scene = worn
    assert send(therapist, session_id, b"a,b\n1,2\n").status_code == 422
    assert send(therapist, session_id, marker_csv(scene), segment="pelvis").status_code == 409
    assert send(therapist, session_id, marker_csv(scene), up="sideways").status_code == 422
    assert therapist.get(f"/api/sessions/{session_id}/markers/motion").status_code == 404
    answer = send(therapist, session_id, marker_csv(free_motion(6, 15.0)))
    done = run_job(engine, settings, answer.json()["id"], fuse)
    assert done is not None
    assert done.status == "failed"
    assert "do not fit this sensor" in done.message
    (found,) = therapist.get(f"/api/sessions/{session_id}/markers").json()
    assert found["report"] is None
    assert found["message"] == done.message
    answer = send(therapist, session_id, marker_csv(scene), unit="cm")
    done = run_job(engine, settings, answer.json()["id"], fuse)
    assert done is not None
    assert done.status == "failed"
    assert "look like mm, not cm: choose that unit" in done.message
    assert found["file_bytes"] > 10_000
    with unit_of_work(engine) as session:
        session.get_one(MotionSession, session_id).state = "recording"
    assert send(therapist, session_id, marker_csv(scene)).status_code == 409
