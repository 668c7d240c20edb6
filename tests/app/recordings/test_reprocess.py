"""Estimating again: all packets, any order of arrival, earlier results kept; the queue across failures."""

import os
import random
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, delete, select

from app import readers
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, NotFound
from app.patients.models import SensorDevice
from app.recordings import repository, service
from app.recordings.analysis.jobs import JobContext, JobDone, JobRunner, run_job
from app.recordings.analysis.reprocess import reprocess
from app.recordings.models import Job, MotionSession, Result, SignalChunk
from app.recordings.schemas import ReprocessIn
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import read_frames
from app.settings import Settings
from estimators import orientation, rotation
from estimators.errors import CalibrationError
from estimators.orientation import DeviceConstants
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.patience import PATIENCE_S

ARM = ("sternum", "upper_arm_right", "forearm_right")


@pytest.fixture(scope="module")
def prepared() -> readers.RecordingPackets:
    recording = simulate_arm(
        ArmScenario(placements=ARM, schedule=Schedule(n_pose_s=5.0, repetitions=2, pause_s=0.5), seed=7)
    ).recording
    return readers.packets_of(recording)


@pytest.fixture
def streamed(
    engine: Engine, new_session: Callable[..., str], prepared: readers.RecordingPackets
) -> Callable[[list[int]], str]:
    """Store the simulated packets in the given order of arrival, as a closed live session."""

    def store(order: list[int]) -> str:
        hello = prepared.declaration.to_dict()
        session_id = new_session(state="closing", hello=hello)
        packets = list(prepared.packets(0))
        writer = GroupCommitWriter(engine, commit_interval_s=0.01, chunk_s=0.01)
        writer.start()
        writer.open_session(session_id)
        for n in order:
            writer.append_packet(session_id, packets[n])
            if n % 50 == 0:
                writer.flush(session_id).result(10)
        writer.add_event(session_id, "calibration", 1.0, duration_s=3.0)
        writer.flush(session_id).result(10)
        writer.close()
        return session_id

    return store


def queue(engine: Engine, session_id: str, **arguments: Any) -> str:
    with unit_of_work(engine) as session:
        job = Job(session_id=session_id, kind="reprocess", arguments=arguments, created_by="x")
        session.add(job)
    return job.id


def frames_of(engine: Engine, session_id: str, result_id: str | None = None) -> Any:
    with read_only(engine) as session:
        found = session.get_one(MotionSession, session_id)
        return read_frames(session, result_id or found.main_result_id)


def test_the_result_does_not_depend_on_the_order_of_arrival(
    engine: Engine, settings: Settings, streamed: Any, prepared: readers.RecordingPackets
) -> None:
    count = sum(1 for _ in prepared.packets(0))
    straight = list(range(count))
    shuffled = straight.copy()
    random.Random(1).shuffle(shuffled)
    # A link that broke: the middle comes at the end.
    back_filled = [n for n in straight if not 60 <= n < 130] + list(range(60, 130))
    found = []
    for order in (straight, shuffled, back_filled):
        session_id = streamed(order)
        # The pose is evaluated again when another parameter is asked for: this covers both passes.
        done = run_job(
            engine,
            settings,
            queue(engine, session_id, close=True, orientation_parameters={"rest_minimum_s": 1.2}),
            reprocess,
        )
        assert done.status == "complete", done.message
        found.append(frames_of(engine, session_id))
    for other in found[1:]:
        for name in ("q_room_segment", "point_room_m", "angle_rad", "segment_flags", "angle_flags"):
            np.testing.assert_array_equal(getattr(other, name), getattr(found[0], name))
    assert np.isfinite(found[0].angle_rad).all(axis=1).mean() > 0.9


def test_closing_counts_names_the_main_result_and_queues_the_comparison(
    engine: Engine, settings: Settings, streamed: Any, prepared: readers.RecordingPackets
) -> None:
    count = sum(1 for _ in prepared.packets(0))
    session_id = streamed([n for n in range(count) if n not in {40, 41, 42, 43, 44, 45}])
    with unit_of_work(engine) as session:
        first = service.queue_closing(session, session_id)
        assert service.queue_closing(session, session_id) == first
    done = run_job(engine, settings, first, reprocess)
    assert done.status == "complete"
    with read_only(engine) as session:
        found = session.get_one(MotionSession, session_id)
        assert (found.packets_stored, found.packets_missing) == (count - 6, 6)
        assert found.duration_s == pytest.approx(prepared.recording.duration_s, abs=0.05)
        assert found.main_result_id is not None
        following = session.scalars(select(Job).where(Job.kind == "compare")).one()
        assert following.arguments == {"close": True}
    # 0.3 s without packets is a marked gap: too long to be bridged.
    frames = frames_of(engine, session_id)
    assert ((frames.segment_flags[200:230] & 1) != 0).all()
    with unit_of_work(engine) as session:
        # While the comparison is to come, the closing is not done again after a restart.
        assert service.queue_closing(session, session_id) == following.id


def test_another_estimate_stands_beside_the_first(
    engine: Engine, settings: Settings, streamed: Any, world: Any
) -> None:
    session_id = streamed(list(range(150)))
    run_job(engine, settings, queue(engine, session_id, close=True), reprocess)
    before = frames_of(engine, session_id)
    names = list(orientation.available())
    wanted = ReprocessIn(orientation=names[-1], orientation_parameters={})
    with unit_of_work(engine) as session:
        session.get_one(MotionSession, session_id).state = "analysed"
    with unit_of_work(engine) as session:
        job = service.queue_reprocess(session, world.subjects["therapist"], session_id, wanted)
    assert run_job(engine, settings, job.id, reprocess).status == "complete"
    with read_only(engine) as session:
        found = session.get_one(MotionSession, session_id)
        results = repository.results_of(session, session_id)
        assert [r.status for r in results] == ["complete", "complete"]
        known = orientation.available(with_offline=True)
        assert all(known[r.orientation].version == r.orientation_version for r in results)
        assert found.main_result_id == results[0].id
    np.testing.assert_array_equal(frames_of(engine, session_id).angle_rad, before.angle_rad)
    assert frames_of(engine, session_id, results[1].id).tick_count == before.tick_count


def test_a_session_run_with_our_filter_is_smoothed_when_it_closes(
    engine: Engine, settings: Settings, streamed: Any, prepared: readers.RecordingPackets
) -> None:
    session_id = streamed(list(range(sum(1 for _ in prepared.packets(0)))))
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, session_id)
        found.setup = {
            **found.setup,
            "orientation": "telemotion",
            "orientation_parameters": {"block_s": 0.25},
        }
        found.hello = {**found.hello, "serials": ["A", "B", "C"]}
        live = DeviceConstants(magnetometer_delay_s=0.5)
        for serial, taught_by in (("A", session_id), ("B", "another session")):
            session.add(
                SensorDevice(
                    clinic_id=found.clinic_id,
                    serial=serial,
                    session_id=taught_by,
                    calibration={},
                    scores={},
                    constants=live.to_dict(),
                )
            )
    done = run_job(engine, settings, queue(engine, session_id, close=True), reprocess)
    assert done.status == "complete", done.message
    with unit_of_work(engine) as session:
        main = session.get_one(Result, session.get_one(MotionSession, session_id).main_result_id)
        assert main.orientation == "telemotion_smoother"
        assert main.orientation_version == orientation.smoothers()["telemotion_smoother"].version
        assert main.setup["orientation_parameters"] == {"block_s": 0.25}
        assert main.setup["calibration"]["method"] == "n_pose"
        # What the live filter gives stays to be asked for, beside the smoothed result.
        session.get_one(MotionSession, session_id).state = "analysed"
        # The smoother knows the sensors better than the live filter; what another session taught stays.
        rows = {
            row.serial: DeviceConstants.from_dict(row.constants)
            for row in session.scalars(select(SensorDevice))
        }
        assert set(rows) == {"A", "B"}
        assert 0.0 < abs(rows["A"].magnetometer_delay_s) < 0.05
        assert rows["B"] == live
    frames = frames_of(engine, session_id)
    assert np.isfinite(frames.angle_rad).all()
    assert (frames.segment_flags == 0).mean() > 0.9
    queued = queue(engine, session_id, orientation="telemotion", orientation_parameters={})
    assert run_job(engine, settings, queued, reprocess).status == "complete"
    with read_only(engine) as session:
        results = repository.results_of(session, session_id)
        assert [r.orientation for r in results] == ["telemotion_smoother", "telemotion"]
        assert session.get_one(MotionSession, session_id).main_result_id == results[0].id
        other = read_frames(session, results[1].id)
    apart = rotation.angle_between(frames.q_room_segment, other.q_room_segment)[500:]
    assert 0.0 < np.degrees(np.sqrt(np.mean(apart**2))) < 5.0


def test_a_mounting_found_by_movement_is_kept_when_smoothing(
    engine: Engine, settings: Settings, streamed: Any
) -> None:
    session_id = streamed(list(range(150)))
    run_job(engine, settings, queue(engine, session_id, close=True), reprocess)
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, session_id)
        known = session.get_one(Result, found.main_result_id).setup["calibration"]
        by_movement = {**known, "method": "functional"}
        found.setup = {**found.setup, "orientation": "telemotion", "calibration": by_movement}
    run_job(engine, settings, queue(engine, session_id, close=True), reprocess)
    with read_only(engine) as session:
        main = session.get_one(Result, session.get_one(MotionSession, session_id).main_result_id)
        assert main.orientation == "telemotion_smoother"
        assert main.setup["calibration"]["method"] == "functional"
        assert main.setup["calibration"]["q_sensor_segment"] == known["q_sensor_segment"]


def test_who_may_ask_for_another_estimate(engine: Engine, streamed: Any, world: Any) -> None:
    session_id = streamed(list(range(10)))
    wanted = ReprocessIn(orientation="vqf")
    with unit_of_work(engine) as session, pytest.raises(Conflict, match="not finished"):
        service.queue_reprocess(session, world.subjects["therapist"], session_id, wanted)
    with unit_of_work(engine) as session, pytest.raises(NotFound):
        service.queue_reprocess(session, world.subjects["foreign_therapist"], session_id, wanted)


def test_frames_by_time_and_thinned(engine: Engine, settings: Settings, streamed: Any, world: Any) -> None:
    session_id = streamed(list(range(150)))
    run_job(engine, settings, queue(engine, session_id, close=True), reprocess)
    whole = frames_of(engine, session_id)
    with read_only(engine) as session:
        therapist = world.subjects["therapist"]
        part = service.frames(session, therapist, session_id, None, 2.0, 3.5)
        assert (part.first_tick, part.tick_count) == (200, 150)
        np.testing.assert_array_equal(part.angle_rad, whole.angle_rad[200:350])
        thin = service.frames(session, therapist, session_id, None, 2.01, 6.0, 50)
        assert thin.tick_count <= 50
        stride = round(thin.time_step_s / whole.time_step_s)
        assert stride == 8
        ticks = np.round(thin.time_s / whole.time_step_s).astype(int)
        np.testing.assert_array_equal(thin.angle_rad, whole.angle_rad[ticks])
        assert ticks[0] == 208
        beyond = service.frames(session, therapist, session_id, None, 900.0, 901.0)
        assert beyond.tick_count == 0
        with pytest.raises(NotFound):
            service.frames(session, therapist, session_id, "nothing")


def test_a_session_without_packets_fails_in_words(
    engine: Engine, settings: Settings, new_session: Any
) -> None:
    session_id = new_session(state="closing")
    done = run_job(engine, settings, queue(engine, session_id, close=True), reprocess)
    assert done.status == "failed"
    assert "no sensor box" in done.message
    with read_only(engine) as session:
        found = session.get_one(MotionSession, session_id)
        assert found.state == "failed"
        assert "no sensor box" in found.state_reason
        assert "complete" not in session.scalars(select(Result.status)).all()


# The queue.


def succeed(context: JobContext) -> str:
    context.progress(0.5, "half")
    return "well done"


def refuse(context: JobContext) -> str:
    raise CalibrationError("hold the pose again")


def stumble(context: JobContext) -> str:
    raise ZeroDivisionError("secret detail")


def die_once(context: JobContext) -> str:
    if context.attempt == 1:
        os._exit(9)
    return "second attempt"


def die(context: JobContext) -> str:
    os._exit(9)


def sleep_long(context: JobContext) -> str:
    time.sleep(60)
    return "too late"


@pytest.mark.parametrize(
    ("handler", "status", "message"),
    [
        (succeed, "complete", "well done"),
        (refuse, "failed", "hold the pose again"),
        (stumble, "failed", "internal error"),
    ],
)
def test_how_a_task_ends_is_on_its_row(
    engine: Engine, settings: Settings, new_session: Any, handler: Any, status: str, message: str
) -> None:
    session_id = new_session(state="closing")
    job_id = queue(engine, session_id)
    run_job(engine, settings, job_id, handler)
    with read_only(engine) as session:
        job = session.get_one(Job, job_id)
        found = session.get_one(MotionSession, session_id)
    assert job.status == status
    assert message in job.message
    assert "secret" not in job.message
    assert found.state == ("closing" if status == "complete" else "failed")
    assert run_job(engine, settings, job_id, handler) is None


def run_until(engine: Engine, settings: Settings, handler: Any, session_id: str, count: int) -> list[JobDone]:
    done: list[JobDone] = []
    runner = JobRunner(engine, settings, {"reprocess": handler})
    runner.subscribe(done.append)
    runner.start()
    # A worker imports for seconds, four times here, and more on a busy machine.
    deadline = time.monotonic() + PATIENCE_S
    while len(done) < count and time.monotonic() < deadline:
        time.sleep(0.02)
    runner.stop()
    return done


@pytest.mark.slow
def test_a_task_whose_worker_dies_is_tried_again(
    engine: Engine, settings: Settings, new_session: Any
) -> None:
    session_id = new_session()
    first, second = queue(engine, session_id), queue(engine, session_id)
    done = run_until(engine, settings, die_once, session_id, 2)
    assert [(d.job_id, d.status, d.message) for d in done] == [
        (first, "complete", "second attempt"),
        (second, "complete", "second attempt"),
    ]


@pytest.mark.slow
def test_a_task_that_kills_its_worker_fails_and_the_queue_goes_on(
    engine: Engine, settings: Settings, new_session: Any
) -> None:
    session_id = new_session()
    bad = queue(engine, session_id)
    done = run_until(engine, settings, die, session_id, 1)
    assert [(d.job_id, d.status) for d in done] == [(bad, "failed")]
    assert "interrupted" in done[0].message
    good = queue(engine, session_id)
    done = run_until(engine, settings, succeed, session_id, 1)
    assert [(d.job_id, d.status) for d in done] == [(good, "complete")]


@pytest.mark.slow
def test_a_task_in_progress_is_taken_up_after_a_restart(
    engine: Engine, settings: Settings, new_session: Any
) -> None:
    session_id = new_session()
    job_id = queue(engine, session_id)
    runner = JobRunner(engine, settings, {"reprocess": sleep_long})
    runner.start()
    deadline = time.monotonic() + PATIENCE_S
    status = ""
    while status != "running" and time.monotonic() < deadline:
        time.sleep(0.05)
        with read_only(engine) as session:
            status = session.get_one(Job, job_id).status
    started = time.monotonic()
    runner.stop()
    assert time.monotonic() - started < 5.0
    with read_only(engine) as session:
        assert session.get_one(Job, job_id).status == "running"
    done = run_until(engine, settings, succeed, session_id, 1)
    assert [(d.job_id, d.status) for d in done] == [(job_id, "complete")]


def test_an_unknown_kind_of_task_fails_in_words(engine: Engine, settings: Settings, new_session: Any) -> None:
    job_id = queue(engine, new_session())
    runner = JobRunner(engine, settings, {})
    runner.start()
    deadline = time.monotonic() + PATIENCE_S
    status = "queued"
    while status == "queued" and time.monotonic() < deadline:
        time.sleep(0.05)
        with read_only(engine) as session:
            status = session.get_one(Job, job_id).status
    runner.stop()
    assert status == "failed"


def test_a_deleted_session_stops_its_task(engine: Engine, settings: Settings, streamed: Any) -> None:
    session_id = streamed(list(range(100)))
    job_id = queue(engine, session_id)

    def delete_midway(context: JobContext) -> str:
        with unit_of_work(engine) as session:
            session.execute(delete(MotionSession).where(MotionSession.id == session_id))
        context.progress(0.9)
        return "not reached"

    done = run_job(engine, settings, job_id, delete_midway)
    assert done.status == "failed"
    with read_only(engine) as session:
        assert session.scalars(select(SignalChunk)).all() == []
        assert session.get(Job, job_id) is None
