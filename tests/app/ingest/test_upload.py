"""Uploads: received to disk or refused without a trace, then stored and analysed as a task."""

import json
import time
from base64 import b64encode
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
import scipy.io
from sqlalchemy import Engine, select
from typer.testing import CliRunner

from app.accounts.models import AuditEvent
from app.cli import cli
from app.commands.upload import Wanted, declaration_of
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import RecordingFormatError
from app.ingest import readers
from app.ingest.upload import register, remove_orphans, upload_folder
from app.ingest.upload_task import upload
from app.recordings import read_frames, read_packets, stored_ranges
from app.recordings.columns import frames_table
from app.recordings.jobs import JobDone, run_job
from app.recordings.models import Job, MotionSession, Result, SessionEvent
from app.recordings.packet_log import write_log
from app.recordings.schemas import CsvMapping, JobOut, UploadIn
from app.recordings.service import job_out
from app.settings import Settings
from estimators import pipelines
from estimators.simulation import ArmScenario, Schedule, SimulatedSession, simulate_arm
from tests.app.ingest.odd_tables import odd_tables

ARM = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
MIB = 1 << 20


@pytest.fixture(scope="module")
def simulated() -> SimulatedSession:
    return simulate_arm(
        ArmScenario(
            exercise="reaching",
            placements=ARM,
            schedule=Schedule(n_pose_s=6.0, repetitions=3, pause_s=1.0),
            seed=11,
        )
    )


@pytest.fixture
def log(tmp_path: Path, simulated: SimulatedSession) -> Path:
    prepared = readers.packets_of(simulated.recording)
    path = tmp_path / "session.tmlog"
    path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(5))))
    return path


def declare(world: Any, **changes: Any) -> UploadIn:
    return UploadIn(**{"patient_id": world.patient_id, "format": "packet_log", **changes})


@pytest.fixture
def queue(engine: Engine, settings: Settings, world: Any) -> Callable[[Path, UploadIn], str]:
    """Put a file where a received upload lies and queue its task."""

    def place(source: Path, declaration: UploadIn) -> str:
        path = upload_folder(settings) / f"{source.stem}.upload"
        path.write_bytes(source.read_bytes())
        return register(engine, settings, world.subjects["therapist"], declaration, path).id

    return place


def session_of(engine: Engine, job_id: str) -> MotionSession:
    with read_only(engine) as session:
        return session.get_one(MotionSession, session.get_one(Job, job_id).session_id)


def test_one_sensor_under_several_names_is_told_and_not_refused(
    engine: Engine, settings: Settings, queue: Any, tmp_path: Path, world: Any, simulated: SimulatedSession
) -> None:
    recording = simulated.recording
    copied = replace(
        recording, sensors=recording.sensors | {"hand_right": recording.sensors["forearm_right"]}
    )
    prepared = readers.packets_of(copied)
    path = tmp_path / "copied.tmlog"
    path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(5))))
    done = run_job(engine, settings, queue(path, declare(world)), upload)
    assert done.status == "complete"
    assert "The sensors on the right forearm and right hand send the same signal" in done.message
    assert "calibrate again" not in done.message


def test_an_uploaded_log_becomes_a_calibrated_session(
    engine: Engine, settings: Settings, world: Any, queue: Any, log: Path, simulated: SimulatedSession
) -> None:
    job_id = queue(log, declare(world, exercise_id=world.exercise_id))
    done = run_job(engine, settings, job_id, upload)
    assert (done.status, done.message) == ("complete", "")
    found = session_of(engine, job_id)
    prepared = readers.packets_of(simulated.recording)
    stored = list(read_packets(engine, found.id))
    assert [p.payload for p in stored] == [p.payload for p in prepared.packets(5)]
    assert (found.source, found.state, found.packets_missing) == ("upload", "closing", 0)
    assert found.packets_stored == len(stored)
    assert found.duration_s == pytest.approx(simulated.recording.duration_s, abs=0.05)
    assert found.setup["calibration"]["score"] > 0.5
    assert not list(upload_folder(settings).iterdir())
    with read_only(engine) as session:
        frames = read_frames(session, found.main_result_id)
        pose = session.scalars(select(SessionEvent).where(SessionEvent.kind == "calibration")).one()
        following = session.scalars(select(Job).where(Job.kind == "compare")).one()
    assert (following.status, following.arguments) == ("queued", {"close": True})
    assert 0.0 <= pose.time_s < 3.0
    assert 1.4 < pose.duration_s <= 3.0
    # The elbow follows the truth; the issue's own bound for a clean stream is 2 degrees.
    name = "humerus_forearm_right_zxy_flexion"
    error = frames.angle_rad[:, frames.layout.angles.index(name)] - simulated.truth.angle_rad(name)
    assert np.degrees(np.sqrt(np.nanmean(error**2))) < 2.0


def test_an_upload_equals_the_library_run_on_the_same_file(
    engine: Engine, settings: Settings, world: Any, queue: Any, log: Path
) -> None:
    job_id = queue(log, declare(world, calibration_pose_s=(1.0, 4.0)))
    run_job(engine, settings, job_id, upload)
    found = session_of(engine, job_id)
    recording = readers.read(log)
    setup = replace(pipelines.SessionSetup.from_dict(found.setup), calibration=None)
    expected, _ = pipelines.run(recording, setup, (1.0, 4.0))
    with read_only(engine) as session:
        frames = read_frames(session, found.main_result_id)
    assert frames.tick_count == expected.tick_count
    # Stored in steps of 2^-14 rad at most.
    np.testing.assert_allclose(frames.angle_rad, expected.angle_rad, atol=2.0**-15 + 1e-6)
    np.testing.assert_array_equal(frames.angle_flags, expected.angle_flags)


def test_an_upload_without_stillness_is_kept_uncalibrated_and_says_so(
    engine: Engine, settings: Settings, world: Any, queue: Any, tmp_path: Path
) -> None:
    moving = simulate_arm(
        ArmScenario(placements=ARM, schedule=Schedule(n_pose_s=6.0, repetitions=2, pause_s=0.2), seed=2)
    ).recording
    # From the middle of the transition to the middle of the last repetition: never still.
    sensors = {}
    for name, s in moving.sensors.items():
        part = slice(650, int(100 * moving.duration_s) - 500)
        shaken = s.gyroscope_radps[part] + 0.5 * np.sin(np.arange(part.start, part.stop) * 0.3)[:, None]
        sensors[name] = replace(
            s,
            time_s=s.time_s[part] - s.time_s[part.start],
            gyroscope_radps=shaken,
            accelerometer_mps2=s.accelerometer_mps2[part],
            magnetometer_t=s.magnetometer_t[part],
        )
    prepared = readers.packets_of(replace(moving, sensors=sensors))
    path = tmp_path / "moving.tmlog"
    path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(5))))
    job_id = queue(path, declare(world))
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "complete"
    assert done.message.parameters["lines"][0].code == "session.not_calibrated_because"
    assert "still" in done.message
    found = session_of(engine, job_id)
    assert found.setup["calibration"] is None
    assert found.state_reason.code == "session.not_calibrated_because"
    with read_only(engine) as session:
        assert np.isnan(read_frames(session, found.main_result_id).angle_rad).all()


def test_a_file_that_breaks_off_fails_in_words_and_is_removed(
    engine: Engine, settings: Settings, world: Any, queue: Any, log: Path
) -> None:
    log.write_bytes(log.read_bytes()[:-100])
    job_id = queue(log, declare(world))
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "failed"
    assert "cut off" in done.message
    found = session_of(engine, job_id)
    assert (found.state, found.main_result_id) == ("failed", None)
    assert found.state_reason.code == "job.analysis_failed"
    assert found.state_reason.parameters["reason"].code == "log.cut_off"
    assert not list(upload_folder(settings).iterdir())


def test_a_file_of_another_format_is_refused_before_it_is_queued(
    engine: Engine, queue: Any, world: Any, tmp_path: Path
) -> None:
    path = tmp_path / "a.tmlog"
    path.write_bytes(b"time,x,y\n0,1,2\n")
    with pytest.raises(RecordingFormatError, match="TML1"):
        queue(path, declare(world))
    with read_only(engine) as session:
        assert session.scalars(select(MotionSession)).all() == []


def test_an_interrupted_upload_starts_anew_and_stores_everything_once(
    engine: Engine, settings: Settings, world: Any, queue: Any, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job_id = queue(log, declare(world))

    class Killed(BaseException):
        pass

    def die(*_: Any, **__: Any) -> None:
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr("app.ingest.upload_task._declare", die)
        with pytest.raises(Killed):
            run_job(engine, settings, job_id, upload)
    with unit_of_work(engine) as session:
        job = session.get_one(Job, job_id)
        assert job.status == "running"
        job.status = "queued"
    assert remove_orphans(engine, settings) == 0
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "complete"
    found = session_of(engine, job_id)
    with read_only(engine) as session:
        assert len(session.scalars(select(Result)).all()) == 1
    ranges = stored_ranges(engine, found.id)
    assert len(ranges) == found.packets_stored == ranges.highest + 1


def test_files_that_no_task_needs_are_removed_at_the_start(
    engine: Engine, settings: Settings, world: Any
) -> None:
    stale = upload_folder(settings) / "half.part"
    stale.write_bytes(b"x")
    assert remove_orphans(engine, settings) == 1
    assert not stale.exists()


# Over HTTP.


def post(client: Any, declaration: dict[str, Any] | None, content: bytes | None, **changes: Any) -> Any:
    parts: list[Any] = []
    if declaration is not None:
        parts.append(("declaration", (None, json.dumps(declaration), "application/json")))
    if content is not None:
        parts.append(("file", ("a.tmlog", content, "application/octet-stream")))
    if changes.get("reverse"):
        parts.reverse()
    return client.post("/api/uploads", files=parts)


def test_an_upload_over_http_is_queued_and_audited(
    therapist: Any, world: Any, log: Path, engine: Engine, services: Any
) -> None:
    services.jobs.stop()
    answer = post(therapist, declare(world).model_dump(mode="json"), log.read_bytes())
    assert answer.status_code == 202, answer.text
    job = answer.json()
    assert (job["kind"], job["status"]) == ("upload", "queued")
    shown = therapist.get(f"/api/jobs/{job['id']}").json()
    assert shown == job
    assert therapist.get(f"/api/sessions/{job['session_id']}/jobs").json() == [job]
    assert therapist.get(f"/api/sessions/{job['session_id']}").json()["state"] == "closing"
    with read_only(engine) as session:
        actions = list(session.scalars(select(AuditEvent.action)))
    assert "session.create" in actions


def test_whoever_may_not_record_cannot_upload_and_nothing_is_stored(
    sign_in: Any, nobody: Any, world: Any, log: Path, settings: Settings
) -> None:
    declaration = declare(world).model_dump(mode="json")
    content = log.read_bytes()
    expected = {
        "reader": 403,
        "colleague": 404,
        "other_patient": 404,
        "foreign_therapist": 404,
        "former": 404,
    }
    for name, status in expected.items():
        assert post(sign_in(name), declaration, content).status_code == status, name
    assert post(nobody, declaration, content).status_code == 401
    assert not list(upload_folder(settings).iterdir())


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda d, c: (None, c, {}), "before the part"),
        (lambda d, c: (d, None, {}), "`file` is missing"),
        (lambda d, c: (d, c, {"reverse": True}), "before the part"),
        (lambda d, c: ({**d, "format": "docx"}, c, {}), "format"),
        (lambda d, c: ({**d, "format": "csv"}, c, {}), "needs `csv`"),
        (lambda d, c: ({**d, "calibration_pose_s": [5, 2]}, c, {}), "calibration_pose_s"),
        (lambda d, c: ({**d, "orientation": "magic"}, c, {}), "magic"),
        (lambda d, c: (d, b"", {}), "TML1"),
    ],
)
def test_a_wrong_request_says_what_to_do(
    therapist: Any, world: Any, log: Path, settings: Settings, make: Any, says: str
) -> None:
    declaration, content, changes = make(declare(world).model_dump(mode="json"), log.read_bytes())
    answer = post(therapist, declaration, content, **changes)
    assert answer.status_code == 422, answer.text
    assert says in answer.json()["message"]
    assert not list(upload_folder(settings).iterdir())


def test_two_gigabytes_are_refused_by_their_announced_length(
    therapist: Any, world: Any, settings: Settings
) -> None:
    read = 0

    def endless() -> Iterator[bytes]:
        nonlocal read
        while read < 2048:
            read += 1
            yield bytes(MIB)

    answer = therapist.post(
        "/api/uploads",
        content=endless(),
        headers={"Content-Length": str(2 << 30), "Content-Type": "multipart/form-data; boundary=x"},
    )
    assert answer.status_code == 413
    assert answer.json()["code"] == "too_large"
    assert answer.json()["details"]["limit_bytes"] > 0
    assert not list(upload_folder(settings).iterdir())


def multipart(declaration: dict[str, Any], size_mib: int, *, close: bool = True) -> Iterator[bytes]:
    yield b'--xyz\r\nContent-Disposition: form-data; name="declaration"\r\n\r\n'
    yield json.dumps(declaration).encode()
    yield b'\r\n--xyz\r\nContent-Disposition: form-data; name="file"; filename="a"\r\n\r\n'
    for _ in range(size_mib):
        yield bytes(MIB)
    if close:
        yield b"\r\n--xyz--\r\n"


async def receive(
    tmp_path: Path, pieces: Iterator[bytes], limit_bytes: int
) -> tuple[Path, list[bytes], BaseException | None]:
    from app.errors import TelemotionError
    from app.ingest._multipart import UploadReceiver

    seen: list[bytes] = []

    async def on_declaration(text: bytes) -> None:
        seen.append(text)

    async def body() -> Any:
        for piece in pieces:
            yield piece

    target = tmp_path / "target.part"
    receiver = UploadReceiver("multipart/form-data; boundary=xyz", target, limit_bytes, on_declaration)
    try:
        await receiver.receive(body())
    except TelemotionError as error:
        return target, seen, error
    return target, seen, None


@pytest.mark.anyio
async def test_an_unannounced_upload_is_stopped_at_the_limit(tmp_path: Path) -> None:
    given = 0

    def counted() -> Iterator[bytes]:
        nonlocal given
        for piece in multipart({"a": 1}, 2048):
            given += len(piece)
            yield piece

    target, seen, error = await receive(tmp_path, counted(), 3 * MIB)
    assert error is not None
    assert error.status == 413
    assert len(seen) == 1
    # Read no further than the piece that went over, and never wrote more than the limit.
    assert given < 5 * MIB
    assert target.stat().st_size <= 3 * MIB


@pytest.mark.anyio
async def test_a_body_that_breaks_off_is_an_error(tmp_path: Path) -> None:
    _, _, error = await receive(tmp_path, multipart({"a": 1}, 1, close=False), 3 * MIB)
    assert "broke off" in str(error)


@pytest.mark.anyio
async def test_a_file_arrives_unchanged_whatever_the_pieces(tmp_path: Path) -> None:
    content = np.random.default_rng(1).bytes(300_000) + b"\r\n--xy" + b"\r\n--xyzz"
    whole = b"".join(multipart({"a": 1}, 0)).replace(
        b"\r\n\r\n\r\n--xyz--", b"\r\n\r\n" + content + b"\r\n--xyz--"
    )
    rng = np.random.default_rng(2)

    def pieces() -> Iterator[bytes]:
        at = 0
        while at < len(whole):
            size = int(rng.integers(1, 5000))
            yield whole[at : at + size]
            at += size

    target, seen, error = await receive(tmp_path, pieces(), MIB)
    assert error is None
    assert json.loads(seen[0]) == {"a": 1}
    assert target.read_bytes() == content


def as_csv(simulated: SimulatedSession, path: Path) -> dict[str, Any]:
    columns = {"time": next(iter(simulated.recording.sensors.values())).time_s * 1e3}
    signals = []
    for name, s in simulated.recording.sensors.items():
        for quantity, values, unit, factor in (
            ("gyroscope", s.gyroscope_radps, "deg/s", 180 / np.pi),
            ("accelerometer", s.accelerometer_mps2, "m/s^2", 1.0),
            ("magnetometer", s.magnetometer_t, "uT", 1e6),
        ):
            names = [f"{name} {quantity} {axis}" for axis in "xyz"]
            columns.update(zip(names, (values * factor).T, strict=True))
            signals.append({"placement": name, "quantity": quantity, "columns": names, "unit": unit})
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header=",".join(columns), comments="")
    return {"format": "csv", "csv": {"time_column": "time", "time_unit": "ms", "signals": signals}}


def as_whole_body(simulated: SimulatedSession, path: Path) -> dict[str, Any]:
    theirs = {ours: name for name, ours in readers.PLACEMENT_OF.items()}
    content: dict[str, Any] = {"t": next(iter(simulated.recording.sensors.values())).time_s}
    for name, s in simulated.recording.sensors.items():
        content[theirs[name]] = {"acc": s.accelerometer_mps2, "gyr": s.gyroscope_radps}
    scipy.io.savemat(path, content, appendmat=False)
    return {"format": "qmt_mat"}


@pytest.mark.parametrize("write", [as_csv, as_whole_body])
def test_every_format_is_analysed_like_a_stream(
    engine: Engine,
    settings: Settings,
    world: Any,
    queue: Any,
    tmp_path: Path,
    simulated: SimulatedSession,
    write: Callable[[SimulatedSession, Path], dict[str, Any]],
) -> None:
    path = tmp_path / "session.file"
    job_id = queue(path, declare(world, **write(simulated, path)))
    done = run_job(engine, settings, job_id, upload)
    assert (done.status, done.message) == ("complete", "")
    found = session_of(engine, job_id)
    assert set(found.setup["placements"]) == set(ARM)
    assert found.setup["rate_hz"] == 100.0
    assert found.setup["calibration"] is not None
    with read_only(engine) as session:
        frames = read_frames(session, found.main_result_id)
    name = "humerus_forearm_right_zxy_flexion"
    error = frames.angle_rad[:, frames.layout.angles.index(name)] - simulated.truth.angle_rad(name)
    # Without a magnetometer the heading of each sensor drifts; the bound of the issue holds with one.
    assert np.degrees(np.sqrt(np.nanmean(error**2))) < (2.0 if write is as_csv else 6.0)


def shown(engine: Engine, done: JobDone) -> JobOut:
    with read_only(engine) as session:
        return job_out(session.get_one(Job, done.job_id))


def test_a_csv_with_a_missing_column_fails_in_words(
    engine: Engine, settings: Settings, world: Any, queue: Any, tmp_path: Path, simulated: SimulatedSession
) -> None:
    path = tmp_path / "session.csv"
    declared = as_csv(simulated, path)
    declared["csv"]["signals"][1]["columns"][0] = "not there"
    job_id = queue(path, declare(world, **declared))
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "failed"
    assert "no column not there" in done.message
    assert not shown(engine, done).is_implausible
    assert shown(engine, done).sentences["message"].code == "table.no_column"
    assert session_of(engine, job_id).state == "failed"


def test_wrong_axes_fail_in_words_until_they_are_declared_or_accepted(
    engine: Engine, settings: Settings, world: Any, queue: Any, tmp_path: Path, simulated: SimulatedSession
) -> None:
    path = tmp_path / "session.csv"
    declared = as_csv(simulated, path)
    columns = next(
        s
        for s in declared["csv"]["signals"]
        if (s["placement"], s["quantity"]) == ("forearm_right", "gyroscope")
    )["columns"]
    columns[0], columns[1] = columns[1], columns[0]
    done = run_job(engine, settings, queue(path, declare(world, **declared)), upload)
    assert done.status == "failed"
    assert "Right forearm: the axes of the gyroscope do not fit" in done.message
    assert shown(engine, done).is_implausible
    assert shown(engine, done).sentences["message"].code == "upload.implausible"
    accepted = run_job(
        engine, settings, queue(path, declare(world, **declared, accept_implausible=True)), upload
    )
    assert not shown(engine, accepted).is_implausible
    assert accepted.status == "complete"
    assert "Right forearm: the axes of the gyroscope do not fit" in accepted.message


@pytest.mark.slow
def test_the_running_service_takes_an_upload_to_its_end(therapist: Any, world: Any, log: Path) -> None:
    """The whole way through the real worker process."""
    job = post(therapist, declare(world).model_dump(mode="json"), log.read_bytes()).json()
    deadline = time.monotonic() + 120
    while therapist.get(f"/api/sessions/{job['session_id']}").json()["state"] == "closing":
        assert time.monotonic() < deadline
        time.sleep(0.2)
    found = therapist.get(f"/api/sessions/{job['session_id']}").json()
    assert (found["state"], found["results"][0]["status"]) == ("analysed", "complete")
    jobs = therapist.get(f"/api/sessions/{job['session_id']}/jobs").json()
    assert {(j["kind"], j["status"], j["progress"]) for j in jobs} == {
        ("upload", "complete", 1.0),
        ("compare", "complete", 1.0),
    }


def test_a_preview_says_how_a_table_would_be_read_and_stores_nothing(
    therapist: Any, engine: Engine, settings: Settings
) -> None:
    odd = odd_tables()["german"]
    answer = therapist.post(
        "/api/uploads/preview",
        json={"file_name": "a.csv", "beginning": b64encode(odd.content[: readers.HEAD_BYTES]).decode()},
    )
    assert answer.status_code == 200, answer.text
    found = answer.json()
    direct = readers.preview_text("a.csv", odd.content[: readers.HEAD_BYTES])
    assert (found["format"], found["pipeline"], found["missing"]) == ("csv", "orientation", [])
    assert CsvMapping.model_validate(found["mapping"]) == CsvMapping.model_validate(direct.guess.mapping)
    refused = therapist.post("/api/uploads/preview", json={"file_name": "a.csv", "beginning": "AAAA"})
    assert refused.status_code == 422
    assert refused.json()["sentences"]["message"]["code"] == "table.not_text"
    with read_only(engine) as session:
        assert session.scalars(select(MotionSession)).all() == []
    assert not (settings.data_dir / "uploads").exists() or not list((settings.data_dir / "uploads").iterdir())


@pytest.mark.parametrize(
    "name",
    ["letters", "utf-16", "a clock that starts again", "rows that came late", "feet by the names of columns"],
)
def test_a_table_gives_the_same_numbers_by_upload_and_on_the_command_line(
    engine: Engine, settings: Settings, world: Any, queue: Any, tmp_path: Path, name: str
) -> None:
    odd = odd_tables()[name]
    path = tmp_path / odd.name
    path.write_bytes(odd.content)
    declaration = declaration_of(path, Wanted(world.patient_id, guess=True, force=True))
    job_id = queue(path, declaration)
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "complete", done.message
    found = session_of(engine, job_id)
    assert (found.setup["pipeline"], set(found.setup["placements"])) == (odd.pipeline, set(odd.sensors))
    with read_only(engine) as session:
        frames = read_frames(session, found.main_result_id)
    out = tmp_path / "out"
    told = CliRunner().invoke(cli, ["process", str(path), "--guess", "--force", "--out", str(out)])
    assert told.exit_code == 0, told.output
    table = pyarrow.parquet.read_table(out / "frames.parquet")
    assert table.num_rows == frames.tick_count
    stored = frames_table(frames, pipeline=odd.pipeline)
    assert stored.column_names == table.column_names
    for column in table.column_names:
        # Sent in 32 bits, stored in steps of 2^-14.
        np.testing.assert_allclose(
            stored[column].to_numpy(), table[column].to_numpy(), atol=2e-4, rtol=2e-3, err_msg=column
        )


def test_a_broad_trial_is_a_single_sensor_with_the_numbers_of_the_command_line(
    engine: Engine, settings: Settings, world: Any, queue: Any, tmp_path: Path
) -> None:
    with np.load(Path(__file__).parents[2] / "data" / "broad" / "fast_combined_15s.npz") as data:
        content = {
            "imu_gyr": data["gyroscope_radps"],
            "imu_acc": data["accelerometer_mps2"],
            "imu_mag": data["magnetometer_ut"],
            "opt_quat": data["q_earth_sensor_optical"],
            "movement": data["movement"].astype(np.uint8),
            "sampling_rate": float(data["sampling_rate_hz"]),
        }
    path = tmp_path / "trial.mat"
    scipy.io.savemat(path, content)
    declaration = declaration_of(path, Wanted(world.patient_id))
    assert declaration.format == "broad"
    job_id = queue(path, declaration)
    done = run_job(engine, settings, job_id, upload)
    assert done.status == "complete", done.message
    found = session_of(engine, job_id)
    with read_only(engine) as session:
        frames = read_frames(session, found.main_result_id)
    told = CliRunner().invoke(cli, ["process", str(path), "--out", str(tmp_path / "out")])
    assert told.exit_code == 0, told.output
    table = pyarrow.parquet.read_table(tmp_path / "out" / "frames.parquet")
    assert table.num_rows == frames.tick_count
    for part, letter in enumerate("wxyz"):
        np.testing.assert_allclose(
            frames.q_room_segment[:, 0, part], table[f"imu_q_{letter}"].to_numpy(), atol=2e-4
        )
