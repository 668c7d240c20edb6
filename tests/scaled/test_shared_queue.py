"""Workers share the queue of long tasks: each task is run once, and again where its worker has ended."""

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sqlalchemy import Engine, select

from app.accounts.credentials.passwords import Passwords
from app.database import migrate
from app.database.base import new_id
from app.database.engine import create_from_url
from app.database.unit_of_work import read_only, unit_of_work
from app.database.writer_lock import RunnerLock
from app.recordings.analysis.jobs import JobContext, JobDone, JobRunner, run_job
from app.recordings.files_in_passing import remove_orphans, upload_folder
from app.recordings.models import Job, MotionSession
from app.settings import Settings
from tests.app.conftest import BASE_URL, build_world
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.postgres


class Queue:
    """A database on PostgreSQL with tasks, and runners of it."""

    def __init__(self, url: str, folder: Path, passwords: Passwords) -> None:
        self.settings = Settings(
            _env_file=None,
            base_url=BASE_URL,
            secret_key="0123456789abcdefghijklmnopqrstuvwxyz-tests",
            database_url=url,
            data_dir=folder,
            job_workers=2,
        )
        self.engine: Engine = create_from_url(url)
        world = build_world(self.engine, passwords)
        self.session_id = new_id()
        with unit_of_work(self.engine) as session:
            session.add(
                MotionSession(
                    id=self.session_id,
                    clinic_id=world.clinic_id,
                    patient_id=world.patient_id,
                    setup={},
                    created_by=world.accounts["therapist"],
                )
            )
        self.account = world.accounts["therapist"]
        self.done: list[JobDone] = []
        self.locks: list[RunnerLock] = []

    def add(self, count: int) -> list[str]:
        ids = [new_id() for _ in range(count)]
        with unit_of_work(self.engine) as session:
            for one in ids:
                session.add(
                    Job(
                        id=one,
                        session_id=self.session_id,
                        kind="reprocess",
                        arguments={},
                        created_by=self.account,
                    )
                )
        return ids

    def runner(self, handler: Callable[[JobContext], str]) -> tuple[JobRunner, RunnerLock]:
        lock = RunnerLock(self.settings.database_url, "tests")
        lock.take()
        self.locks.append(lock)
        runner = JobRunner(self.engine, self.settings, {"reprocess": handler}, lock)
        runner.subscribe(self.done.append)
        runner.start()
        return runner, lock

    def rows(self) -> dict[str, Job]:
        with read_only(self.engine) as session:
            return {job.id: job for job in session.scalars(select(Job))}

    def until(self, condition: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline_s, {one.id: one.status for one in self.rows().values()}
            time.sleep(0.05)


@pytest.fixture
def queue(
    postgresql_database: Callable[[], str], tmp_path: Path, cheap_passwords: Passwords
) -> Iterator[Queue]:
    url = postgresql_database()
    migrate.upgrade(url)
    made = Queue(url, tmp_path, cheap_passwords)
    yield made
    for lock in made.locks:
        lock.release()
    made.engine.dispose()


def well(context: JobContext) -> str:
    time.sleep(0.5)
    return "well done"


def long_at_first(context: JobContext) -> str:
    if context.attempt == 1:
        time.sleep(300.0)
    return f"attempt {context.attempt}"


@pytest.mark.slow("each of eight tasks starts a process that imports the service")
def test_two_workers_run_every_task_once(queue: Queue) -> None:
    ids = queue.add(8)
    runners = [queue.runner(well) for _ in range(2)]
    queue.until(lambda: len(queue.done) == len(ids))
    for runner, _ in runners:
        runner.stop()
    rows = queue.rows()
    assert sorted(done.job_id for done in queue.done) == sorted(ids)
    assert all(rows[one].status == "complete" and rows[one].arguments["attempt"] == 1 for one in ids)
    assert {rows[one].arguments["runner"] for one in ids} == {lock.key for _, lock in runners}


@pytest.mark.slow("each attempt starts a process that imports the service")
def test_what_ran_at_a_worker_that_has_ended_is_taken_up_by_another(queue: Queue) -> None:
    (job_id,) = queue.add(1)
    first, lock = queue.runner(long_at_first)
    queue.until(lambda: queue.rows()[job_id].status == "running")
    second, _ = queue.runner(long_at_first)
    # It lives: nobody takes what it runs.
    second._take_up()
    assert queue.rows()[job_id].status == "running"
    first.stop()
    lock.release()
    queue.until(lambda: bool(queue.done))
    second.stop()
    assert [(done.job_id, done.status, done.message) for done in queue.done] == [
        (job_id, "complete", "attempt 2")
    ]


def test_one_of_two_that_take_a_task_at_the_same_moment_runs_it(queue: Queue) -> None:
    (job_id,) = queue.add(1)
    begun, found = threading.Barrier(2), []

    def take() -> None:
        begun.wait(PATIENCE_S)
        found.append(run_job(queue.engine, queue.settings, job_id, well))

    threads = [threading.Thread(target=take) for _ in range(2)]
    for one in threads:
        one.start()
    for one in threads:
        one.join(30.0)
    assert sorted(done is None for done in found) == [False, True]
    assert queue.rows()[job_id].arguments["attempt"] == 1


def test_an_attempt_that_was_taken_for_ended_writes_no_end(queue: Queue) -> None:
    (job_id,) = queue.add(1)

    def overtaken(context: JobContext) -> str:
        with unit_of_work(queue.engine) as session:
            job = session.get_one(Job, job_id)
            job.arguments = {**job.arguments, "attempt": 2}
        return "too late"

    run_job(queue.engine, queue.settings, job_id, overtaken)
    assert queue.rows()[job_id].status == "running"


def test_an_upload_that_is_under_way_at_an_edge_stays(queue: Queue) -> None:
    path = upload_folder(queue.settings) / "under-way"
    path.write_bytes(b"half of a file")
    assert remove_orphans(queue.engine, queue.settings, 3600.0) == 0
    assert path.exists()
    assert remove_orphans(queue.engine, queue.settings) == 1
