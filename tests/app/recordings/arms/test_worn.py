"""A stored session whose movements contradict its standing pose: said on the time line, and in the result."""

from collections.abc import Callable
from typing import Final

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app import readers
from app.database.unit_of_work import read_only, unit_of_work
from app.kinds.arm.worn import EVENT
from app.recordings.analysis.jobs import run_job
from app.recordings.analysis.reprocess import reprocess
from app.recordings.models import Job, MotionSession, SessionEvent
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import read_frames
from app.settings import Settings
from estimators import rotation
from estimators.conventions import Placement
from estimators.orientation import OrientationFlag
from estimators.pipelines import SessionSetup
from estimators.simulation import ArmScenario, Mounting, Schedule, SimulatedSession, simulate_arm
from estimators.simulation._sensors import outward_mounting
from tests.said import codes

WORN: Final[tuple[Placement, ...]] = ("sternum", "upper_arm_right", "forearm_right")
FLEXION: Final = "humerus_forearm_right_zxy_flexion"


def drinking(turned: Placement | None) -> SimulatedSession:
    """Somebody who stands, then drinks four times; a turned sensor is back to front."""
    mounted = {}
    if turned is not None:
        half = rotation.multiply(outward_mounting(turned), np.array([0.0, 1.0, 0.0, 0.0]))
        w, x, y, z = (float(v) for v in half)
        mounted[turned] = (w, x, y, z)
    schedule = Schedule(n_pose_s=5.0, repetitions=4, pause_s=2.5)
    mounting = Mounting(q_segment_sensor=mounted)
    return simulate_arm(
        ArmScenario(
            exercise="drinking", placements=WORN, schedule=schedule, mounting=mounting, rate_hz=50.0, seed=17
        )
    )


def stored(
    engine: Engine, new_session: Callable[..., str], made: SimulatedSession, pose_s: tuple[float, float]
) -> str:
    packets = readers.packets_of(made.recording)
    setup = SessionSetup("arm", WORN, 50.0)
    session_id = new_session(state="closing", hello=packets.declaration.to_dict(), setup=setup)
    writer = GroupCommitWriter(engine, commit_interval_s=0.01, chunk_s=0.01)
    writer.start()
    writer.open_session(session_id)
    for n, packet in enumerate(packets.packets(0)):
        writer.append_packet(session_id, packet)
        if n % 50 == 0:
            writer.flush(session_id).result(10)
    writer.add_event(session_id, "calibration", pose_s[0], duration_s=pose_s[1] - pose_s[0])
    writer.flush(session_id).result(10)
    writer.close()
    return session_id


def analysed(engine: Engine, settings: Settings, session_id: str, **arguments: bool) -> list[str]:
    """Analyse it, and return what its time line says of the calibration."""
    with unit_of_work(engine) as session:
        job = Job(session_id=session_id, kind="reprocess", arguments=arguments, created_by="x")
        session.add(job)
    done = run_job(engine, settings, job.id, reprocess)
    assert done is not None
    assert done.status == "complete", done.message
    with read_only(engine) as session:
        kind = SessionEvent.kind == EVENT
        found = session.scalars(select(SessionEvent).where(SessionEvent.session_id == session_id, kind))
        return codes([event.text for event in found])


@pytest.mark.slow
def test_a_chest_sensor_back_to_front_is_turned(
    engine: Engine, settings: Settings, new_session: Callable[..., str]
) -> None:
    made = drinking("sternum")
    session_id = stored(engine, new_session, made, (1.0, 4.0))
    assert analysed(engine, settings, session_id, close=True) == ["placement.back_to_front"]
    assert analysed(engine, settings, session_id) == ["placement.back_to_front"], "once more, said once"
    with read_only(engine) as session:
        frames = read_frames(session, session.get_one(MotionSession, session_id).main_result_id or "")
    found = frames.angle_rad[:, frames.layout.angles.index(FLEXION)]
    off = np.degrees(found - made.truth.angle_rad(FLEXION)[: len(found)])
    assert np.sqrt(np.mean(off[300:] ** 2)) < 5.0


@pytest.mark.slow
def test_a_pose_with_bent_elbows_is_said_and_its_angles_count_nowhere(
    engine: Engine, settings: Settings, new_session: Callable[..., str]
) -> None:
    made = drinking(None)
    end_s, begin_s = made.truth.repetitions_s[0, 1], made.truth.repetitions_s[1, 0]
    session_id = stored(engine, new_session, made, (float(end_s) + 0.4, float(begin_s) - 0.3))
    assert analysed(engine, settings, session_id, close=True) == ["placement.elbow_impossible"]
    with read_only(engine) as session:
        frames = read_frames(session, session.get_one(MotionSession, session_id).main_result_id or "")
    column = frames.layout.angles.index(FLEXION)
    assert (frames.angle_flags[:, column] & int(OrientationFlag.INVALID)).all()
    assert np.nanmin(frames.angle_sigma_rad[:, column]) > 1.0


@pytest.mark.slow
def test_a_sound_session_says_nothing(
    engine: Engine, settings: Settings, new_session: Callable[..., str]
) -> None:
    session_id = stored(engine, new_session, drinking(None), (1.0, 4.0))
    assert analysed(engine, settings, session_id, close=True) == []
