"""Uploaded files go with their task, however it ends, and with their session; what a crash leaves is swept."""

import os
import stat
import time
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, select

from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, NotFound, RecordingFormatError
from app.ingest.upload import register
from app.network.packet_log import log_head
from app.recordings import repository
from app.recordings.analysis import jobs
from app.recordings.analysis.jobs import JobRunner, run_job
from app.recordings.analysis.queue import Waiting
from app.recordings.files_in_passing import SWEEP_S, upload_folder
from app.recordings.models import Job, MotionSession
from app.settings import Settings
from estimators.errors import EstimationError
from tests.app.ingest.uploads import declare


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """The head of a packet log: enough to be registered."""
    declared = {"protocol_version": 1, "ticket": "x", "placements": ["upper_arm_right"], "rate_hz": 100.0}
    path = tmp_path / "session.tmlog"
    path.write_bytes(log_head(declared))
    return path


@pytest.fixture
def job_id(engine: Engine, log: Path, world: Any, settings: Settings) -> str:
    path = upload_folder(settings) / "session.upload"
    path.write_bytes(log.read_bytes())
    return register(engine, settings, world.subjects["therapist"], declare(world), path).id


def files(settings: Settings) -> list[str]:
    return sorted(path.name for path in upload_folder(settings).iterdir())


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        EstimationError("cannot be"),
        RecordingFormatError("cannot be read"),
        NotFound("gone"),
        OSError(28, "no space"),
        ZeroDivisionError(),
        None,
    ],
    ids=lambda error: type(error).__name__,
)
def test_a_task_that_has_ended_leaves_no_file(
    engine: Engine, settings: Settings, job_id: str, error: Exception | None
) -> None:
    def end(_: Any) -> str:
        if error is not None:
            raise error
        return ""

    run_job(engine, settings, job_id, end)
    assert files(settings) == []


def test_a_task_that_another_attempt_took_over_keeps_its_file(
    engine: Engine, settings: Settings, job_id: str
) -> None:
    def taken_over(context: Any) -> str:
        context.remember(attempt=2)
        with unit_of_work(engine) as session:
            job = session.get_one(Job, context.job_id)
            job.arguments = {**job.arguments, "attempt": 2}
        raise MemoryError

    run_job(engine, settings, job_id, taken_over)
    assert files(settings) == ["session.upload"]


@pytest.mark.parametrize(("attempt", "left"), [(1, ["session.upload"]), (jobs.MAX_ATTEMPTS, [])])
def test_a_task_whose_process_dies_for_good_leaves_no_file_and_no_waiting_session(
    engine: Engine, settings: Settings, job_id: str, attempt: int, left: list[str]
) -> None:
    with unit_of_work(engine) as session:
        job = session.get_one(Job, job_id)
        job.status, job.arguments = "running", {**job.arguments, "attempt": attempt}
    JobRunner(engine, settings, {})._take_up()
    assert files(settings) == left
    with read_only(engine) as session:
        state = session.scalars(select(MotionSession.state)).one()
    assert state == ("closing" if left else "failed")


def test_a_task_of_no_known_kind_leaves_no_file(engine: Engine, settings: Settings, job_id: str) -> None:
    JobRunner(engine, settings, {})._run_one(Waiting(job_id, "upload", "clinic", "somebody"))
    assert files(settings) == []


def test_deleting_a_session_takes_its_file_once_that_is_committed(
    engine: Engine, settings: Settings, job_id: str, world: Any
) -> None:
    with read_only(engine) as session:
        session_id = session.scalars(select(MotionSession.id)).one()
    subject = world.subjects["therapist"]

    def not_after_all() -> None:
        with unit_of_work(engine) as session:
            repository.delete_session(session, settings, subject, session_id)
            raise Conflict("not after all")

    with pytest.raises(Conflict):
        not_after_all()
    assert files(settings) == ["session.upload"]
    with unit_of_work(engine) as session:
        repository.delete_session(session, settings, subject, session_id)
    assert files(settings) == []


def test_what_a_crash_left_is_swept_and_what_is_needed_or_arriving_is_not(
    engine: Engine, settings: Settings, job_id: str
) -> None:
    folder = upload_folder(settings)
    for name, age_s in (("left.upload", 2 * SWEEP_S), ("left.part", 2 * SWEEP_S), ("arriving.part", 5.0)):
        (folder / name).write_bytes(b"x")
        os.utime(folder / name, (time.time() - age_s,) * 2)
    os.utime(folder / "session.upload", (1.0, 1.0))
    runner = JobRunner(engine, settings, {})
    runner._swept_s -= SWEEP_S + 1.0
    runner._sweep_when_due()
    assert files(settings) == ["arriving.part", "session.upload"]


def test_a_received_file_is_for_the_service_alone(
    therapist: Any, world: Any, log: Path, settings: Settings, services: Any
) -> None:
    from tests.app.ingest.test_upload_http import post

    services.get(JobRunner).stop()
    old = os.umask(0)
    try:
        assert post(therapist, declare(world).model_dump(mode="json"), log.read_bytes()).status_code == 202
    finally:
        os.umask(old)
    (path,) = upload_folder(settings).iterdir()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
