"""Two results of one session beside each other: numbers that follow from what was stored."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.accounts.subject import Subject
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, InvalidInput, NotFound
from app.recordings import service
from app.recordings.analysis.differences import differences
from app.recordings.analysis.heading_line import calibration_in_force
from app.recordings.analysis.sequences import in_sequence
from app.recordings.models import Job, Result, SessionEvent
from app.recordings.schemas import ReprocessAllIn
from app.recordings.signals.chunks import encode_frames, frames_stream
from app.recordings.signals.rows import insert_chunk
from estimators import orientation
from estimators.orientation import OrientationFlag
from estimators.pipelines import FrameLayout, Frames, SessionSetup

LAYOUT = FrameLayout(("forearm_right",), (), ("flexion", "carrying"))
TICKS = 15_000
"""Two and a half pieces of a minute at 100 Hz."""


def frames(shift_rad: float) -> Frames:
    angles = np.zeros((TICKS, 2))
    angles[:, 0] = np.linspace(0.0, 1.0, TICKS) + shift_rad
    # Unwrapped curves may be apart by whole turns.
    angles[:, 1] = 2.0 * np.pi if shift_rad else 0.0
    flags = np.zeros((TICKS, 2), dtype=np.uint8)
    flags[:500, 0] = int(OrientationFlag.INVALID)
    angles[:500, 0] += 1.0 * bool(shift_rad)
    angles[700, 0] += 0.5 * bool(shift_rad)
    return Frames(
        LAYOUT,
        0,
        0.01,
        np.tile([1.0, 0.0, 0.0, 0.0], (TICKS, 1, 1)),
        np.zeros((TICKS, 0, 3)),
        angles,
        np.zeros((TICKS, 2)),
        np.zeros((TICKS, 0)),
        np.zeros((TICKS, 1), dtype=np.uint8),
        flags,
    )


def add_result(engine: Engine, session_id: str, found: Frames, **fields: Any) -> str:
    setup = SessionSetup("arm", ("forearm_right",), 100.0)
    layout = {"segments": ["forearm_right"], "points": [], "angles": ["flexion", "carrying"], "scalars": []}
    with unit_of_work(engine) as session:
        result = Result(
            session_id=session_id,
            kind="offline",
            pipeline="arm",
            pipeline_version="1",
            orientation=fields.pop("orientation", "vqf"),
            orientation_version=fields.pop("orientation_version", "1"),
            setup=setup.to_dict(),
            layout=layout,
            status=fields.pop("status", "complete"),
        )
        session.add(result)
        session.flush()
        for start in range(0, found.tick_count, 1000):
            rows = slice(start, min(start + 1000, found.tick_count))
            names = ("q_room_segment", "point_room_m", "angle_rad", "angle_sigma_rad", "scalar")
            part = replace(
                found,
                first_tick=start,
                **{n: getattr(found, n)[rows] for n in (*names, "segment_flags", "angle_flags")},
            )
            chunk = encode_frames(part)
            insert_chunk(session, session_id, frames_stream(result.id), start, chunk)
        return result.id


@pytest.fixture
def therapist(world: Any) -> Subject:
    return world.subjects["therapist"]


def test_rms_maximum_and_curves_are_those_of_the_stored_angles(
    engine: Engine, new_session: Any, therapist: Subject
) -> None:
    session_id = new_session(state="analysed")
    one = add_result(engine, session_id, frames(0.0))
    other = add_result(engine, session_id, frames(0.1))
    with unit_of_work(engine) as session:
        found = differences(session, therapist, session_id, one, other, 1000)
    flexion, carrying = found.angles
    counted = TICKS - 500
    rms = np.degrees(np.sqrt(((counted - 1) * 0.1**2 + 0.6**2) / counted))
    assert flexion.rms_deg == pytest.approx(rms, rel=1e-3)
    assert flexion.mean_deg == pytest.approx(-np.degrees(0.1), rel=1e-2)
    assert flexion.maximum_deg == pytest.approx(np.degrees(0.6), rel=1e-3)
    assert flexion.maximum_at_s == pytest.approx(7.0)
    assert flexion.compared_s == pytest.approx(counted / 100)
    assert carrying.rms_deg == pytest.approx(0.0, abs=1e-4), "a whole turn apart is the same posture"
    assert len(found.time_s) == len(found.curves[0].a_deg) == len(found.curves[0].b_deg)
    assert 900 <= len(found.time_s) <= 1000
    assert found.curves[0].b_deg[-1] == pytest.approx(np.degrees(1.1), abs=0.2)


def test_only_complete_results_of_the_session_are_compared(
    engine: Engine, new_session: Any, therapist: Subject
) -> None:
    session_id, foreign = new_session(state="analysed"), new_session(state="analysed")
    one = add_result(engine, session_id, frames(0.0))
    running = add_result(engine, session_id, frames(0.0), status="running")
    elsewhere = add_result(engine, foreign, frames(0.0))
    with unit_of_work(engine) as session:
        with pytest.raises(Conflict):
            differences(session, therapist, session_id, one, running, 100)
        with pytest.raises(NotFound):
            differences(session, therapist, session_id, one, elsewhere, 100)


def test_every_estimator_gets_a_task_unless_its_result_is_there(
    engine: Engine, new_session: Any, therapist: Subject
) -> None:
    session_id = new_session(state="analysed")
    known = orientation.available(with_offline=True)
    add_result(engine, session_id, frames(0.0), orientation_version=known["vqf"].version)
    with unit_of_work(engine) as session:
        jobs = service.queue_reprocess_all(session, therapist, session_id, ReprocessAllIn())
    assert len(jobs) == len(known) - 1
    with read_only(engine) as session:
        stored = session.scalars(select(Job).where(Job.session_id == session_id)).all()
    assert {job.arguments["orientation"] for job in stored} == set(known) - {"vqf"}
    with unit_of_work(engine) as session, pytest.raises(InvalidInput, match="no estimator"):
        service.queue_reprocess_all(session, therapist, session_id, ReprocessAllIn(orientations=["x"]))


@pytest.mark.parametrize(
    ("kinds", "expected"),
    [
        (["n_pose"], (10.0, 13.0)),
        (["n_pose", "heading_reset", "static_bias"], (10.0, 13.0)),
        (["n_pose", "functional"], None),
        (["functional", "n_pose"], (20.0, 23.0)),
        (["t_pose"], None),
        ([], None),
    ],
)
def test_only_a_standing_pose_in_force_is_evaluated_anew(
    engine: Engine, new_session: Any, kinds: list[str], expected: tuple[float, float] | None
) -> None:
    session_id = new_session(state="analysed")
    with unit_of_work(engine) as session:
        for n, kind in enumerate(kinds, start=1):
            session.add(
                SessionEvent(
                    session_id=session_id,
                    kind="calibration",
                    time_s=10.0 * n,
                    duration_s=3.0,
                    details={"kind": kind},
                )
            )
    with read_only(engine) as session:
        assert calibration_in_force(session, session_id)[0] == expected


def test_a_joint_in_another_sequence_with_its_singular_distance(
    engine: Engine, new_session: Any, therapist: Subject
) -> None:
    session_id = new_session(state="analysed")
    found = frames(0.0)
    half = np.radians(40.0) / 2
    bent = np.array([np.cos(half), 0.0, -np.sin(half), 0.0])
    q = np.stack((found.q_room_segment[:, 0], np.tile(bent, (TICKS, 1))), axis=1)
    layout = FrameLayout(("upper_arm_right", "forearm_right"), (), ("flexion", "carrying"))
    found = replace(
        found, layout=layout, q_room_segment=q, segment_flags=np.zeros((TICKS, 2), dtype=np.uint8)
    )
    result = add_result(engine, session_id, found)
    with unit_of_work(engine) as session:
        session.get_one(Result, result).layout = {
            "segments": list(layout.segments),
            "points": [],
            "angles": list(layout.angles),
            "scalars": [],
        }
        out = in_sequence(
            session, therapist, session_id, "humerus_forearm", "right", "zxy", result, 0.0, 10.0, 50
        )
        assert out.names[0] == "humerus_forearm_right_zxy_flexion"
        assert out.angles_deg[0] == pytest.approx([40.0] * len(out.time_s), abs=0.01)
        assert out.singular_distance_deg[0] == pytest.approx(90.0, abs=0.01)
        with pytest.raises(InvalidInput, match="shoulder"):
            in_sequence(session, therapist, session_id, "humerus_forearm", "right", "yxy", result, 0, 1, 50)
