"""A sensor that turned in its strap: reported on the time line, and its angles flagged in the result."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Final, cast

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app import readers
from app.database.unit_of_work import read_only, unit_of_work
from app.kinds.arm.slips import EVENT, in_words, mounted_since_s
from app.recordings.analysis.heading_line import HeadingReset
from app.recordings.analysis.jobs import JobContext, run_job
from app.recordings.analysis.reprocess import reprocess
from app.recordings.models import Job, MotionSession, SessionEvent
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import read_frames
from app.settings import Settings
from estimators.conventions import Placement
from estimators.orientation import OrientationFlag
from estimators.pipelines import SessionSetup, Slip
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from estimators.simulation.faults import turn_in_strap
from tests.said import codes

ARM: Final[tuple[Placement, ...]] = ("upper_arm_right", "forearm_right", "hand_right")
AT_S = 17.4


def stored(engine: Engine, new_session: Callable[..., str]) -> str:
    """Store a closed live session in which the forearm's sensor turns about the forearm while the arm rests."""
    made = simulate_arm(
        ArmScenario(placements=ARM, schedule=Schedule(n_pose_s=5.0, repetitions=4, pause_s=1.5), seed=7)
    )
    times = made.truth.repetitions_s
    assert times[1, 1] < AT_S < times[2, 0]
    # About the sensor's x axis, which lies along the limb.
    recording = turn_in_strap(made.recording, "forearm_right", AT_S, (np.radians(35.0), 0.0, 0.0))
    packets = readers.packets_of(recording)
    session_id = new_session(
        state="closing", hello=packets.declaration.to_dict(), setup=SessionSetup("arm", ARM, 100.0)
    )
    writer = GroupCommitWriter(engine, commit_interval_s=0.01, chunk_s=0.01)
    writer.start()
    writer.open_session(session_id)
    for n, packet in enumerate(packets.packets(0)):
        writer.append_packet(session_id, packet)
        if n % 50 == 0:
            writer.flush(session_id).result(10)
    writer.add_event(session_id, "calibration", 1.0, duration_s=3.0)
    writer.flush(session_id).result(10)
    writer.close()
    return session_id


def analyse(engine: Engine, settings: Settings, session_id: str, **arguments: bool) -> None:
    with unit_of_work(engine) as session:
        job = Job(session_id=session_id, kind="reprocess", arguments=arguments, created_by="x")
        session.add(job)
    done = run_job(engine, settings, job.id, reprocess)
    assert done is not None
    assert done.status == "complete", done.message


@pytest.mark.slow
def test_a_closed_session_says_which_sensor_turned_and_when(
    engine: Engine, settings: Settings, new_session: Callable[..., str]
) -> None:
    session_id = stored(engine, new_session)
    analyse(engine, settings, session_id, close=True)
    # Once more finds it once more, and says it once.
    analyse(engine, settings, session_id)
    with read_only(engine) as session:
        (event,) = session.scalars(
            select(SessionEvent).where(SessionEvent.session_id == session_id, SessionEvent.kind == EVENT)
        )
        assert event.placement == "forearm_right"
        assert event.time_s == pytest.approx(AT_S, abs=0.5)
        assert codes([event.text]) == ["slip.turned"]
        assert "right forearm" in str(event.text)
        assert "0:17" in str(event.text)
        result_id = session.get_one(MotionSession, session_id).main_result_id
        assert result_id is not None
        frames = read_frames(session, result_id)
    column = frames.layout.angles.index("humerus_forearm_right_zxy_pronation")
    flagged = (frames.angle_flags[:, column] & int(OrientationFlag.CONVERGING)) != 0
    assert flagged[frames.time_s > AT_S + 0.5].all()
    assert not flagged[(frames.time_s > 8.0) & (frames.time_s < AT_S - 0.8)].any()
    assert np.degrees(frames.angle_sigma_rad[-1, column]) > 30.0
    assert frames.slipped is not None, "stored with the frames"
    segment, angle, _ = frames.slipped_parts
    after = frames.time_s > AT_S + 0.5
    assert angle[after, column].all()
    assert (segment[-1] == [name == "forearm_right" for name in frames.layout.segments]).all()
    assert not frames.slipped[frames.time_s < AT_S - 0.8].any()


@pytest.mark.parametrize(
    ("mounted", "reset", "record_s", "from_s"),
    [
        (None, None, None, 0.0),
        (None, (4.0, 6.0), None, 6.0),
        (None, (4.0, 6.0), 9.0, 9.0),
        (None, (4.0, 12.0), 9.0, 12.0),
        ((1.0, 3.0), (4.0, 6.0), 9.0, 3.0),
    ],
)
def test_a_remembered_mounting_holds_from_the_first_heading_and_from_record_on(
    engine: Engine,
    new_session: Callable[..., str],
    mounted: tuple[float, float] | None,
    reset: tuple[float, float] | None,
    record_s: float | None,
    from_s: float,
) -> None:
    """Straps are put right before: what was handled then is no slip."""
    session_id = new_session(recording_start_s=record_s)
    if mounted is not None:
        with unit_of_work(engine) as session:
            session.add(
                SessionEvent(
                    session_id=session_id,
                    kind="calibration",
                    time_s=mounted[0],
                    duration_s=mounted[1] - mounted[0],
                    text="",
                    details={"kind": "t_pose"},
                )
            )
    resets = [] if reset is None else [HeadingReset(*reset, ARM, {})]
    context = cast(JobContext, SimpleNamespace(engine=engine, session_id=session_id))
    assert mounted_since_s(context, resets) == from_s


def test_of_two_sensors_one_is_meant() -> None:
    slips = [
        Slip("forearm_right", 62.0, (0.0, 0.0, 0.5), 0.02),
        Slip("hand_right", 62.3, (0.0, 0.0, -0.5), 0.02),
    ]
    said = str(in_words(slips))
    assert "right forearm or right hand" in said
    assert "1:02" in said
    assert "elbow and wrist" in said
