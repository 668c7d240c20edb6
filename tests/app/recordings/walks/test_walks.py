"""Walks through the service: a real recording of both feet, one of a single foot, and what is no walk."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from alembic.script import ScriptDirectory
from sqlalchemy import Engine, event, select

from app.accounts.models import AuditEvent
from app.assessment.walk_progress import walk_values
from app.database import migrate
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict
from app.ingest.upload import register
from app.ingest.upload_task import upload
from app.kinds.walk.stored import recording_of, walk_stream
from app.recordings import service
from app.recordings.analysis.jobs import run_job
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import MotionSession, Result, SignalChunk
from app.recordings.schemas import ReprocessIn, UploadIn
from app.recordings.signals.store import read_frames
from app.settings import Settings
from estimators.gait import steady
from estimators.pipelines import SessionSetup, analyse_walk
from estimators.recording import ImuChunk, Recording, SampleQuality, SensorSignals

FEET = Path(__file__).parents[3] / "data" / "feet"
SECONDS = 32.0


def gaitmap_csv(path: Path) -> Recording:
    """Write the beginning of the real walk as its library does; return what the file holds."""
    content = np.load(FEET / "gaitmap_strides.npz")
    rate_hz = 204.8
    ticks = int(SECONDS * rate_hz)
    axes = ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")
    columns, sensors = [], {}
    for side in ("left", "right"):
        accelerometer = content[f"accelerometer_{side}_mps2"][:ticks].astype(float)
        gyroscope = content[f"gyroscope_{side}_radps"][:ticks].astype(float)
        columns += [accelerometer, np.degrees(gyroscope)]
        sensors[f"foot_{side}"] = SensorSignals(np.arange(ticks) / rate_hz, gyroscope, accelerometer)
    # The library writes an index column first.
    head = [
        "," + ",".join(f"{side}_sensor" for side in ("left", "right") for _ in axes),
        "," + ",".join(axes * 2),
    ]
    rows = np.concatenate([np.arange(ticks)[:, None], *columns], axis=1)
    np.savetxt(path, rows, delimiter=",", header="\n".join(head), comments="", fmt="%.8g")
    return Recording(sensors, rate_hz)


@pytest.fixture
def uploaded(engine: Engine, settings: Settings, world: Any) -> Callable[..., Any]:
    """Upload a file as the therapist and do its task; returns the finished task."""

    def place(source: Path, **declared: Any) -> Any:
        path = upload_folder(settings) / f"{source.stem}.upload"
        path.write_bytes(source.read_bytes())
        declaration = UploadIn(patient_id=world.patient_id, **declared)
        job = register(engine, settings, world.subjects["therapist"], declaration, path)
        return run_job(engine, settings, job.id, upload)

    return place


def test_a_real_walk_becomes_footprints_strides_and_numbers(
    engine: Engine, uploaded: Any, therapist: Any, tmp_path: Path
) -> None:
    recording = gaitmap_csv(tmp_path / "walk.csv")
    done = uploaded(tmp_path / "walk.csv", format="gaitmap")
    assert done.status == "complete", done.message
    answer = therapist.get(f"/api/sessions/{done.session_id}/gait")
    assert answer.status_code == 200
    walk = answer.json()
    # What the service keeps is what the library finds in the same samples.
    direct = analyse_walk(recording, SessionSetup("gait", ("foot_left", "foot_right"), 204.8))
    for foot in walk["feet"]:
        strides = direct.strides[foot["side"]]
        assert len(foot["strides"]) == strides.count
        assert len(foot["footholds"]) == strides.count + 1
        lengths = [stride["length_m"] for stride in foot["strides"]]
        np.testing.assert_allclose(lengths, strides.length_m, atol=2e-3)
        measures = {one["measure"]: one for one in foot["measures"]}
        expected = direct.summary.feet[foot["side"]]["stride_length"]
        assert measures["stride_length"]["count"] == expected.count > 5
        assert measures["stride_length"]["value"] == pytest.approx(expected.value, abs=2e-3)
        assert 0 < measures["stride_length"]["sigma"] < measures["stride_length"]["value"]
        assert sum(stride["is_counted"] for stride in foot["strides"]) == int(steady(strides).sum())
        # Neighbouring footprints are a stride apart.
        places = np.array([[hold["x_m"], hold["y_m"]] for hold in foot["footholds"]])
        np.testing.assert_allclose(
            np.linalg.norm(np.diff(places, axis=0), axis=1), strides.length_m, atol=0.02
        )
        height, speed = foot["curves"]
        assert (height["name"], speed["name"]) == ("height", "speed")
        assert len(height["mean"]) == len(height["spread"]) == 51
        assert 0.05 < max(height["mean"]) < 0.5
        assert max(speed["mean"]) == pytest.approx(
            np.nanmean([s["peak_speed_mps"] for s in foot["strides"] if s["is_counted"]]), rel=0.2
        )
    assert {one["measure"] for one in walk["asymmetry"]} >= {"stride_length", "stance_share"}
    assert {one["measure"] for one in walk["both"]} >= {"double_support"}
    assert walk["has_step_width"] is False
    assert (walk["result"]["pipeline"], walk["result"]["orientation"]) == ("gait", "foot")
    shown = therapist.get(f"/api/sessions/{done.session_id}").json()
    assert shown["pipeline"] == "gait"
    assert shown["duration_s"] == pytest.approx(SECONDS, abs=0.05)
    with read_only(engine) as session:
        frames = read_frames(session, shown["main_result_id"])
        actions = [event.action for event in session.scalars(select(AuditEvent))]
    assert frames.layout.points == ("foot_left", "foot_right")
    assert frames.tick_count == direct.frames.tick_count
    assert "session.gait" in actions


def test_one_foot_says_what_it_cannot_tell_and_is_erased_whole(
    engine: Engine, uploaded: Any, therapist: Any, world: Any, tmp_path: Path
) -> None:
    content = np.load(FEET / "pyshoe_walk.npz")
    path = tmp_path / "walk.mat"
    together = np.concatenate([content["accelerometer_mps2"], content["gyroscope_radps"]], axis=1)
    scipy.io.savemat(path, {"imu_data": together, "timestamps_all": content["time_s"][None, :]})
    done = uploaded(path, format="pyshoe")
    assert done.status == "complete", done.message
    walk = therapist.get(f"/api/sessions/{done.session_id}/gait").json()
    assert [foot["side"] for foot in walk["feet"]] == ["right"]
    assert walk["asymmetry"] == walk["both"] == []
    assert "walk.one_foot" in [said["code"] for said in walk["sentences"]["reasons"]]
    with read_only(engine) as session:
        found = session.get_one(MotionSession, done.session_id)
        result = session.scalars(select(Result).where(Result.session_id == found.id)).one()
        assert found.hello is not None
        assert found.hello["clip_gyroscope_radps"] > 1.0
        key = (found.id, walk_stream(result.id), 0)
        assert session.get(SignalChunk, key) is not None
    with unit_of_work(engine) as session:
        session.get_one(MotionSession, done.session_id).state = "analysed"
    again, by = ReprocessIn(orientation="vqf"), world.subjects["therapist"]
    with unit_of_work(engine) as session, pytest.raises(Conflict, match="one estimator"):
        service.queue_reprocess(session, by, done.session_id, again)
    assert therapist.delete(f"/api/sessions/{done.session_id}").status_code == 204
    with read_only(engine) as session:
        assert session.get(SignalChunk, key) is None


def test_a_foot_that_never_leaves_the_ground_is_told_and_not_guessed(
    uploaded: Any, therapist: Any, tmp_path: Path
) -> None:
    time_s = np.arange(4000) / 200.0
    rng = np.random.default_rng(1)
    gyroscope = rng.normal(0, 0.005, (4000, 3))
    accelerometer = np.array([0.0, 0.0, 9.81]) + rng.normal(0, 0.03, (4000, 3))
    path = tmp_path / "standing.mat"
    together = np.concatenate([accelerometer, gyroscope], axis=1)
    scipy.io.savemat(path, {"imu_data": together, "timestamps_all": time_s[None, :]})
    done = uploaded(path, format="pyshoe")
    assert done.status == "complete", done.message
    walk = therapist.get(f"/api/sessions/{done.session_id}/gait").json()
    assert walk["feet"][0]["strides"] == []
    assert "walk.no_stride" in [said["code"] for said in walk["sentences"]["reasons"]]


def test_a_session_of_an_arm_is_no_walk(new_session: Any, therapist: Any) -> None:
    answer = therapist.get(f"/api/sessions/{new_session(state='analysed')}/gait")
    assert answer.status_code == 409
    assert "not a walk" in answer.json()["message"]


def test_a_live_walk_needs_no_calibration_and_refuses_one(therapist: Any, world: Any) -> None:
    wanted = {"patient_id": world.patient_id, "pipeline": "gait", "placements": ["foot_left", "foot_right"]}
    made = therapist.post("/api/sessions", json=wanted)
    assert made.status_code == 201
    assert made.json()["pipeline"] == "gait"
    assert "foot_left_stance" in made.json()["layout"]["scalars"]
    refused = therapist.post("/api/sessions", json=wanted | {"placements": ["sternum"]})
    assert refused.status_code == 422
    assert "sensor on a foot" in refused.json()["message"]


def test_walks_of_a_patient_are_listed_and_compared(
    uploaded: Any, therapist: Any, world: Any, tmp_path: Path
) -> None:
    gaitmap_csv(tmp_path / "walk.csv")
    first, second = (uploaded(tmp_path / "walk.csv", format="gaitmap").session_id for _ in range(2))
    listed = therapist.get(f"/api/patients/{world.patient_id}/walks").json()
    assert {row["session_id"] for row in listed} == {first, second}
    assert all(row["kind"] == "walk" and row["distance_m"] > 10.0 for row in listed)
    path = f"/api/patients/{world.patient_id}/walks/comparison"
    answer = therapist.post(path, json={"a": [first], "b": [second]})
    assert answer.status_code == 200, answer.text
    found = answer.json()
    assert found["method"] == "strides"
    of_length = [one for one in found["changes"] if one["measure"] == "stride_length"]
    assert {one["foot"] for one in of_length} == {"left", "right"}
    # The same walk twice: nothing changes, and chance explains it.
    assert all(one["difference"] == 0.0 and one["p"] == pytest.approx(1.0) for one in of_length)
    twice = therapist.post(path, json={"a": [first], "b": [first]})
    assert twice.status_code == 422
    stranger = therapist.post(path, json={"a": [first], "b": ["nothing"]})
    assert stranger.status_code == 422
    assert stranger.json()["details"]["field"] == "b"


def test_what_a_session_measured_reaches_its_walk_whole():
    """Compass, clip levels and every measured tick; ticks that were bridged or lost do not."""
    generator = np.random.default_rng(5)
    values = generator.normal(size=(3, 2, 10, 3))
    values[2, 1] = np.nan
    quality = np.zeros((2, 10), np.uint8)
    quality[0, 3:5] = SampleQuality.BRIDGED
    chunk = ImuChunk(0, 0.01, values[0], values[1], values[2], quality)
    setup = SessionSetup("gait", ("foot_left", "foot_right"), 100.0)
    hello = {"clip_gyroscope_radps": 34.9, "clip_accelerometer_mps2": 156.9}
    found = recording_of([chunk.ticks(0, 4), chunk.ticks(4, 10)], setup, hello)
    left, right = found.sensors["foot_left"], found.sensors["foot_right"]
    kept = np.delete(np.arange(10), [3, 4])
    np.testing.assert_array_equal(left.magnetometer_t, values[2, 0, kept])
    np.testing.assert_allclose(left.time_s, 0.01 * kept)
    assert right.magnetometer_t is None
    assert found.metadata == {"gyroscope_clip_radps": "34.9", "accelerometer_clip_mps2": "156.9"}


def test_progress_of_walks_has_the_form_of_every_progress(
    engine: Engine, uploaded: Any, therapist: Any, world: Any, tmp_path: Path
) -> None:
    gaitmap_csv(tmp_path / "walk.csv")
    walks = [uploaded(tmp_path / "walk.csv", format="gaitmap") for _ in range(2)]
    found = therapist.get(f"/api/patients/{world.patient_id}/progress").json()
    measures = {one["measure"]: one for one in found["measures"]}
    assert next(iter(measures)) == "walk:speed:left"
    speed = measures["walk:speed:left"]
    assert "walk:speed:right" not in measures, "both feet walk at one speed"
    assert speed["label"] == "Walking speed, steady strides"
    assert [point["session_id"] for point in speed["points"]] == [walk.session_id for walk in walks]
    stored = therapist.get(f"/api/sessions/{walks[0].session_id}/gait").json()
    left = next(foot for foot in stored["feet"] if foot["side"] == "left")
    mine = next(one for one in left["measures"] if one["measure"] == "speed")
    point = speed["points"][0]
    assert point["value"] == pytest.approx(mine["value"])
    assert point["high"] - point["value"] == pytest.approx(mine["spread"])
    assert point["count"] == mine["count"]
    # Two walks are too few to judge a change.
    assert speed["trend"]["word"] == "values"
    share = measures["walk:stance_share:right"]
    assert share["unit"] == "%"
    assert 50.0 < share["points"][0]["value"] < 80.0
    assert all(one["measure"].startswith("walk:") for one in found["measures"])
    # Walks that were stored before get the very same from their migration.
    script = ScriptDirectory(str(migrate.SCRIPTS)).get_revision("0019_walk_followed")
    with read_only(engine) as session:
        kept = session.execute(select(Result.id, Result.session_id, Result.followed)).all()
        assert len(kept) == 2
        for of, session_id, followed in kept:
            data = session.get_one(SignalChunk, (session_id, walk_stream(of), 0)).data
            assert json.dumps(script.module._followed(data)) == json.dumps(followed)


def test_progress_of_walks_reads_none_of_them(
    engine: Engine, uploaded: Any, world: Any, tmp_path: Path
) -> None:
    gaitmap_csv(tmp_path / "walk.csv")
    uploaded(tmp_path / "walk.csv", format="gaitmap")
    said: list[str] = []

    def note(_connection: Any, _cursor: Any, statement: str, *_rest: Any) -> None:
        said.append(statement)

    event.listen(engine, "before_cursor_execute", note)
    try:
        with read_only(engine) as session:
            values = walk_values(session, [world.patient_id])
    finally:
        event.remove(engine, "before_cursor_execute", note)
    assert len(values) > 10
    assert len([one for one in said if one.startswith("SELECT")]) == 1
    assert not [one for one in said if "signal_chunk" in one]
