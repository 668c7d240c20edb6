"""What is valid in a session, on sessions whose truth is known."""

from dataclasses import replace

import numpy as np
import pytest

from app.assessment.comparisons import compare_task
from app.assessment.models import Comparison
from app.assessment.practised import NOTHING, practised, walked_s
from app.database.base import new_id
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Exercise, Prescription, TemplateVersion
from app.kinds.walk.schemas import FootOut, StrideOut, WalkContent, WalkTestOut
from app.kinds.walk.stored import store_walk
from app.recordings.analysis.jobs import run_job
from app.recordings.models import Job, MotionSession, Result, SessionEvent
from estimators.arm import ArmModel
from estimators.body import BodyDimensions
from estimators.comparison import moving_time
from estimators.orientation import OrientationFlag
from estimators.pipelines import FrameLayout
from estimators.rotation import about_y
from tests.app.viewer.stored_reaches import RATE_HZ, Recorded, compared_reaches, reaching_frames, store
from tests.said import codes

REACHES, REACH_S = 5, 3.0
"""Of `compared_reaches`."""


@pytest.fixture
def keep(world, engine):
    """Store an analysed session of given frames; returns its identifiers."""

    def make(frames) -> Recorded:
        _, template, compared = compared_reaches()
        with unit_of_work(engine) as session:
            return store(
                session,
                world.clinic_id,
                world.patient_id,
                world.exercise_id,
                world.accounts["therapist"],
                (frames, template, compared),
            )

    return make


def still(seconds: float):
    return hold(reaching_frames(), round(seconds * RATE_HZ))


def hold(frames, ticks: int):
    """The first posture for so many ticks."""
    arrays = (
        "q_room_segment",
        "point_room_m",
        "angle_rad",
        "angle_sigma_rad",
        "scalar",
        "segment_flags",
        "angle_flags",
    )
    return replace(frames, **{name: np.repeat(getattr(frames, name)[:1], ticks, axis=0) for name in arrays})


def measured(engine, recorded, movement: str | None = None, **window):
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, recorded.session_id)
        for name, value in window.items():
            setattr(found, name, value)
        if movement is not None:
            session.get_one(Exercise, found.exercise_id).movement = movement
        session.flush()
        return practised(session, found)


def test_repetitions_that_are_kept_count_with_their_time(engine, keep) -> None:
    recorded = keep(compared_reaches()[0])
    repetitions, active_s = measured(engine, recorded)
    assert repetitions == REACHES
    # Each begins and ends where its speed passes 5 percent of its peak: at 6 percent of a smooth reach and return.
    assert active_s == pytest.approx(REACHES * REACH_S, rel=0.12)
    # Only two of them lie inside the recording: a second of rest, then one every four seconds.
    repetitions, active_s = measured(engine, recorded, recording_start_s=0.5, recording_end_s=8.8)
    assert (repetitions, active_s) == (2, pytest.approx(2 * REACH_S, rel=0.12))


def bent(placements: tuple[str, ...], angles_rad: dict[str, float]):
    """Still frames of those sensors but for the segments that bend forward, hold and come back, as often as reaches."""
    frames = still(1.0 + REACHES * (REACH_S + 1.0))
    moving = (frames.time_s - 1.0) % (REACH_S + 1.0)
    course = np.where(frames.time_s >= 1.0, np.clip(moving, 0.0, REACH_S), 0.0)
    course = np.sin(np.pi * course / REACH_S) ** 2
    q = np.stack([about_y(angles_rad.get(name, 0.0) * course) for name in placements], axis=1)
    model = ArmModel(BodyDimensions(), placements, 1.0 / RATE_HZ)
    found = model.evaluate(q)
    layout = FrameLayout(placements, model.points, model.angles, model.scalars)
    return replace(
        frames,
        layout=layout,
        q_room_segment=q,
        point_room_m=found.point_room_m,
        angle_rad=found.angle_rad,
        angle_sigma_rad=np.full_like(found.angle_rad, np.nan),
        scalar=found.scalar,
        segment_flags=np.zeros((len(q), len(placements)), np.uint8),
        angle_flags=found.angle_flags,
    )


@pytest.mark.parametrize(
    ("placements", "angles_rad"),
    [
        (
            ("sternum", "upper_arm_right", "thigh_right", "shank_right"),
            {"thigh_right": -1.4, "shank_right": 0.5},
        ),
        (("sternum", "upper_arm_right"), {"sternum": 0.9, "upper_arm_right": 0.9}),
    ],
    ids=["squat", "trunk_bend"],
)
def test_repetitions_of_legs_and_trunk_count(engine, keep, placements, angles_rad) -> None:
    """A squat moves no arm: without the channels of the leg nothing of it would be found."""
    repetitions, active_s = measured(engine, keep(bent(placements, angles_rad)), "other")
    assert repetitions == REACHES
    # A sine squared passes 5 percent of its peak speed at 2 percent of its time.
    assert active_s == pytest.approx(REACHES * REACH_S, rel=0.12)


def test_a_session_in_which_nobody_moved_is_none(engine, keep) -> None:
    recorded = keep(still(60.0))
    for movement in ("reaching", "other", "walk"):
        assert measured(engine, recorded, movement) == NOTHING, movement


def test_an_exercise_without_repetitions_counts_its_movement(engine, keep) -> None:
    """Turned steadily for 30 s of 50: no repetition, and 30 s of movement."""
    frames = still(50.0)
    angle = np.clip(frames.time_s - 10.0, 0.0, 30.0) * 0.5
    turn = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    q = frames.q_room_segment.copy()
    q[:, 1] = turn
    frames = replace(frames, q_room_segment=q)
    # Steps of 0.2 s: one at each end may be told wrongly.
    assert moving_time(frames) == pytest.approx(30.0, abs=0.4)
    assert moving_time(frames, 0.0, 20.0) == pytest.approx(10.0, abs=0.4)
    slower = replace(frames, q_room_segment=np.repeat(q[::4], 4, axis=0)[: len(q)])
    assert moving_time(slower) == pytest.approx(30.0, abs=0.6)
    untracked = replace(
        frames, segment_flags=np.full_like(frames.segment_flags, np.uint8(OrientationFlag.INVALID))
    )
    assert moving_time(untracked) == 0.0
    recorded = keep(frames)
    assert measured(engine, recorded, "other") == (0, pytest.approx(30.0, abs=0.4))
    assert measured(engine, recorded, "reaching") == NOTHING
    assert measured(engine, recorded, "other", recording_end_s=18.0) == NOTHING, "8 s are no exercise"


def stride(duration_s: float | None, is_counted: bool) -> StrideOut:
    known = {"number", "bout", "duration_s", "is_counted", "is_initiation", "is_termination"}
    unknown = dict.fromkeys(set(StrideOut.model_fields) - known)
    return StrideOut(
        number=1,
        bout=1,
        duration_s=duration_s,
        is_counted=is_counted,
        is_initiation=False,
        is_termination=False,
        **unknown,
    )


def walk(left, right, test: WalkTestOut | None = None) -> WalkContent:
    feet = [
        FootOut(side=side, measures=[], footholds=[], strides=strides, path_m=[], curves=[])
        for side, strides in (("left", left), ("right", right))
    ]
    return WalkContent(
        feet=feet,
        both=[],
        asymmetry=[],
        turn_count=0,
        bout_count=1,
        reasons=[],
        has_step_width=False,
        test=test,
    )


def timed(kind: str) -> WalkTestOut:
    rest = {"distance_sigma_m": 0.1, "speed_mps": 1.0, "step_count": 9, "turn_count": 1, "pause_count": 0}
    return WalkTestOut(
        kind=kind,
        start_s=1.0,
        end_s=12.5,
        time_s=11.5,
        distance_m=6.0,
        turn_s=2.0,
        minutes_m=[6.0],
        reasons=[],
        **rest,
    )


def test_walks_count_by_steady_strides_and_tests_by_their_time(engine, keep) -> None:
    left = [stride(1.5, False), *(stride(1.1, True) for _ in range(10)), stride(None, True)]
    right = [stride(1.1, True) for _ in range(9)]
    content = walk(left, right, timed("walk"))
    assert walked_s(content) == pytest.approx(11.0)
    assert walked_s(walk([stride(1.5, False)], [])) == 0.0
    assert walked_s(walk([stride(1.5, False)], [], timed("timed_up_and_go"))) == 11.5
    recorded = keep(still(5.0))
    assert measured(engine, recorded, "walk") == NOTHING
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, recorded.session_id)
        found.setup = found.setup | {"pipeline": "gait"}
        store_walk(session, found.id, recorded.result_id, content)
    assert measured(engine, recorded, "walk") == (0, pytest.approx(11.0))
    assert measured(engine, recorded, exercise_id=None) == (0, pytest.approx(11.0)), (
        "nobody said of what exercise"
    )


def test_the_walk_beside_a_magnetic_result_counts_too(engine, keep) -> None:
    recorded = keep(still(5.0))
    with unit_of_work(engine) as session:
        main = session.get_one(Result, recorded.result_id)
        fields = {c.name: getattr(main, c.name) for c in Result.__table__.columns if c.name != "id"}
        beside = Result(**fields | {"id": new_id(), "pipeline": "gait"})
        session.add(beside)
        session.flush()
        store_walk(session, recorded.session_id, beside.id, walk([stride(1.0, True)] * 4, []))
    assert measured(engine, recorded, "walk") == (0, 4.0)


def on_the_left():
    """Trunk and left arm, which does the reaching of an exercise of the right one; the trunk leans along."""
    return bent(
        ("sternum", "upper_arm_left", "forearm_left"),
        {"sternum": 0.15, "upper_arm_left": -0.9, "forearm_left": -1.2},
    )


def test_what_the_other_arm_did_does_not_count(engine, keep) -> None:
    assert measured(engine, keep(on_the_left()), "reaching") == NOTHING


@pytest.mark.parametrize("with_template", [True, False])
def test_a_session_of_the_other_arm_says_why_it_does_not_count(engine, settings, world, keep, with_template):
    recorded = keep(on_the_left())
    close(engine, settings, world, recorded, with_template=with_template)
    with read_only(engine) as session:
        found = session.get_one(MotionSession, recorded.session_id)
        assert (found.state, found.valid_repetitions, found.active_s) == ("analysed", 0, 0.0)
        (event,) = session.query(SessionEvent).filter_by(session_id=found.id, kind="not_practised")
        assert codes(event.text) == ["comparison.not_practised", "compare.other_side_measured"]
        assert "left" in str(event.text)


def close(engine, settings, world, recorded, *, with_template: bool) -> None:
    """Let a stored session be compared and closed, with a prescription that names its template or none."""
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, recorded.session_id)
        found.state = "closing"
        if with_template:
            version = session.get_one(TemplateVersion, recorded.template_version_id)
            prescription = Prescription(
                id=new_id(),
                patient_id=world.patient_id,
                exercise_id=world.exercise_id,
                template_id=version.template_id,
                prescribed_by=world.accounts["therapist"],
                starts_at=found.created_at,
            )
            session.add(prescription)
            session.flush()
            found.prescription_id = prescription.id
        job = Job(id=new_id(), session_id=found.id, kind="compare", arguments={"close": True}, created_by="x")
        session.add(job)
    done = run_job(engine, settings, job.id, compare_task)
    assert done.status == "complete", done.message


@pytest.mark.parametrize("with_template", [True, False])
def test_closing_a_session_notes_what_was_valid(engine, settings, world, keep, with_template) -> None:
    recorded = keep(compared_reaches()[0])
    close(engine, settings, world, recorded, with_template=with_template)
    with read_only(engine) as session:
        found = session.get_one(MotionSession, recorded.session_id)
        assert found.state == "analysed"
        assert found.valid_repetitions == REACHES
        assert found.active_s == pytest.approx(REACHES * REACH_S, rel=0.12)
        made = [one for one in session.query(Comparison).all() if one.summary["measures"]]
        assert len(made) == (1 if with_template else 0)


def test_a_session_too_long_to_be_counted_is_analysed_all_the_same(
    engine, settings, keep, monkeypatch
) -> None:
    """A day of wearing is more than an analysis may take of memory at once, and is analysed in pieces."""

    def too_long(*_):
        raise MemoryError

    monkeypatch.setattr("app.assessment.practised.load_source", too_long)
    recorded = keep(still(60.0))
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, recorded.session_id)
        found.state = "closing"
        job = Job(id=new_id(), session_id=found.id, kind="compare", arguments={"close": True}, created_by="x")
        session.add(job)
    done = run_job(engine, settings, job.id, compare_task)
    assert done.status == "complete", done.message
    with read_only(engine) as session:
        found = session.get_one(MotionSession, recorded.session_id)
        assert (found.state, found.valid_repetitions, found.active_s) == ("analysed", None, None)
