"""Nobody's tasks wait for the end of somebody else's many or long ones."""

from collections.abc import Callable

import pytest
from sqlalchemy import Engine, update

from app.database.base import new_id
from app.database.unit_of_work import read_only, unit_of_work
from app.recordings.analysis.jobs import JobContext, run_job
from app.recordings.analysis.queue import FairQueue, Waiting
from app.recordings.models import Job, MotionSession
from app.settings import Settings

Ask = Callable[[str, str, int], list[str]]


@pytest.fixture
def ask(engine: Engine, world, new_session) -> Ask:
    """Queue tasks of somebody in a clinic; returns their identifiers."""

    def make(clinic_id: str, asked_by: str, count: int) -> list[str]:
        session_id = new_session()
        jobs = [
            Job(id=new_id(), session_id=session_id, kind="upload", created_by=asked_by) for _ in range(count)
        ]
        names = [job.id for job in jobs]
        with unit_of_work(engine) as session:
            session.execute(
                update(MotionSession).where(MotionSession.id == session_id).values(clinic_id=clinic_id)
            )
            session.add_all(jobs)
        return names

    return make


def take(engine: Engine, queue: FairQueue) -> Waiting | None:
    with read_only(engine) as session:
        return queue.take(session)


def finish(engine: Engine, queue: FairQueue, waiting: Waiting) -> None:
    with unit_of_work(engine) as session:
        session.execute(update(Job).where(Job.id == waiting.job_id).values(status="complete"))
    queue.done(waiting)


def test_another_clinics_task_begins_while_one_has_a_hundred(engine: Engine, world, ask: Ask) -> None:
    queue = FairQueue(workers=2)
    bombs = ask(world.clinic_id, "attacker", 100)
    first = take(engine, queue)
    assert first is not None
    assert first.job_id in bombs
    assert take(engine, queue) is None, "one clinic leaves one worker free"
    (own,) = ask(world.foreign_clinic_id, "neighbour", 1)
    begun = take(engine, queue)
    assert begun is not None
    assert begun.job_id == own
    assert take(engine, queue) is None


def test_people_of_one_clinic_take_turns(engine: Engine, world, ask: Ask) -> None:
    queue = FairQueue(workers=1)
    ask(world.clinic_id, "busy", 5)
    first = take(engine, queue)
    ask(world.clinic_id, "colleague", 2)
    order = []
    for waiting in iter(lambda: first if not order else take(engine, queue), None):
        order.append(waiting.asked_by)
        finish(engine, queue, waiting)
    assert order == ["busy", "colleague", "busy", "colleague", "busy", "busy", "busy"]


def test_one_worker_serves_clinics_in_turn(engine: Engine, world, ask: Ask) -> None:
    queue = FairQueue(workers=1)
    ask(world.clinic_id, "one", 3)
    ask(world.foreign_clinic_id, "other", 2)
    order = []
    while (waiting := take(engine, queue)) is not None:
        order.append(waiting.asked_by)
        assert take(engine, queue) is None, "no place"
        finish(engine, queue, waiting)
    assert order == ["one", "other", "one", "other", "one"]


def hungry(context: JobContext) -> str:
    raise MemoryError


def test_a_task_beyond_its_memory_fails_with_a_sentence(
    engine: Engine, settings: Settings, world, ask: Ask
) -> None:
    (job_id,) = ask(world.clinic_id, "one", 1)
    done = run_job(engine, settings, job_id, hungry)
    assert done is not None
    assert done.status == "failed"
    assert "3.0 GiB" in done.message
    assert "Split the recording" in done.message
