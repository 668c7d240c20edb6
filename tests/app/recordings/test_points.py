"""Elbows, wrists and hands of stored results against the exact movement they were made of."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts.models import AuditEvent
from app.accounts.subject import Subject
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import NotFound
from app.recordings.analysis.series import series_of
from app.recordings.columns import frames_table
from app.recordings.models import Result
from app.recordings.points import described
from app.recordings.series_schemas import SeriesOut
from app.recordings.signals.chunks import decode_frames, encode_frames, frames_stream
from app.recordings.signals.rows import insert_chunk
from estimators.arm import point_covariance
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames, SessionSetup
from estimators.simulation import ArmScenario, Schedule, simulate_arm

GAP = slice(900, 960)


@pytest.fixture(scope="module")
def exact() -> tuple[SessionSetup, Frames]:
    scenario = ArmScenario(exercise="drinking", schedule=Schedule(n_pose_s=3.0, repetitions=10), seed=4)
    made = simulate_arm(scenario)
    frames = made.truth.frames
    sigma = np.broadcast_to(np.radians([1.0, 1.0, 4.0]), (*frames.segment_flags.shape, 3)).copy()
    flags = frames.segment_flags.copy()
    flags[GAP] |= np.uint8(OrientationFlag.INVALID)
    # The whole pieces of a minute in which a long result is read must join.
    assert frames.tick_count > 6500
    return made.setup, replace(frames, segment_sigma_rad=sigma, segment_flags=flags)


@pytest.fixture
def stored(engine: Engine, new_session: Any, exact: tuple[SessionSetup, Frames]) -> tuple[str, str]:
    setup, frames = exact
    session_id = new_session(state="analysed", setup=setup)
    layout = frames.layout
    with unit_of_work(engine) as session:
        result = Result(
            session_id=session_id,
            kind="offline",
            pipeline="arm",
            pipeline_version="1",
            orientation="vqf",
            orientation_version="1",
            setup=setup.to_dict(),
            layout={n: list(getattr(layout, n)) for n in ("segments", "points", "angles", "scalars")},
            status="complete",
        )
        session.add(result)
        session.flush()
        for start in range(0, frames.tick_count, 1000):
            chunk = encode_frames(frames.ticks(start, start + 1000))
            insert_chunk(session, session_id, frames_stream(result.id), start, chunk)
        return session_id, result.id


@pytest.fixture
def therapist(world: Any) -> Subject:
    return world.subjects["therapist"]


def points_of(session: Session, subject: Subject, ids: tuple[str, str], *stretch: float | None) -> SeriesOut:
    session_id, result_id = ids
    start_s, end_s, most = stretch
    return series_of(session, subject, session_id, ["arm_points"], result_id, start_s, end_s, int(most or 0))


def triple(found: SeriesOut, point: str) -> tuple[np.ndarray, np.ndarray]:
    """Position and sigma, shape (3, K)."""
    curves = {curve.name: curve for curve in found.curves}
    chosen = [curves[f"{point}.{axis}"] for axis in "xyz"]
    return tuple(np.array([getattr(one, name) for one in chosen], dtype=float) for name in ("value", "sigma"))


@pytest.mark.slow
def test_points_are_those_of_the_movement(
    engine: Engine, stored: tuple[str, str], exact: tuple[SessionSetup, Frames], therapist: Subject
) -> None:
    setup, frames = exact
    with unit_of_work(engine) as session:
        found = points_of(session, therapist, stored, None, None, 700)
    stride = round((found.time_s[1] - found.time_s[0]) / frames.time_step_s)
    assert 300 < len(found.time_s) <= 700
    at = np.arange(0, frames.tick_count, stride)
    np.testing.assert_allclose(found.time_s, frames.time_s[at], atol=1e-4)
    position, sigma = triple(found, "wrist_right")
    moved = {curve.name: np.array(curve.value, dtype=float) for curve in found.curves}
    column = frames.layout.points.index("wrist_right")
    lost = (at >= GAP.start) & (at < GAP.stop)
    assert np.isnan(position[:, lost]).all()
    # Of stored orientations: two segments of 0.3 m, each wrong by up to 2 * 2^-16 about an axis.
    np.testing.assert_allclose(position[:, ~lost].T, frames.point_room_m[at[~lost], column], atol=5e-5)
    # Speed and acceleration against differences of the exact path.
    path = frames.point_room_m[:, column]
    speed = np.linalg.norm(np.gradient(path, frames.time_step_s, axis=0), axis=1)
    seen = moved["wrist_right.speed"]
    inner = np.isfinite(seen) & (np.abs(at - 930) > 80)
    assert speed.max() > 0.3
    np.testing.assert_allclose(seen[inner], speed[at[inner]], atol=0.01)
    force = np.linalg.norm(np.gradient(np.gradient(path, 0.01, axis=0), 0.01, axis=0), axis=1)
    told = moved["wrist_right.acceleration"]
    assert np.corrcoef(told[inner], force[at[inner]])[0, 1] > 0.95
    # One-sigma as told by the covariance of the chain.
    spread = point_covariance(
        frames.q_room_segment[at],
        frames.layout.segments,  # type: ignore[arg-type]
        setup.body,
        frames.segment_sigma_rad[at],  # type: ignore[index]
        points=["wrist_right"],
    ).covariance_m2[:, 0]
    expected = np.sqrt(np.diagonal(spread, axis1=-2, axis2=-1))
    np.testing.assert_allclose(sigma[:, ~lost].T, expected[~lost], rtol=2e-3)


def test_a_part_is_the_same_as_in_the_whole(
    engine: Engine, stored: tuple[str, str], therapist: Subject
) -> None:
    with unit_of_work(engine) as session:
        whole = points_of(session, therapist, stored, 58.0, 63.0, 2000)
        part = points_of(session, therapist, stored, 59.5, 61.0, 2000)
    assert len(part.time_s) == 150
    first = whole.time_s.index(part.time_s[0])
    for one, other in zip(part.curves, whole.curves, strict=True):
        assert one.value == pytest.approx(other.value[first : first + 150], abs=2e-5)


def test_reading_points_is_audited_and_closed_to_strangers(
    engine: Engine, stored: tuple[str, str], therapist: Subject, world: Any
) -> None:
    with unit_of_work(engine) as session:
        points_of(session, therapist, stored, 0.0, 1.0, 10)
    with read_only(engine) as session:
        event = session.scalars(select(AuditEvent).where(AuditEvent.action == "session.series")).one()
        assert (event.patient_id, event.subject_id) == (world.patient_id, therapist.id)
    with unit_of_work(engine) as session, pytest.raises(NotFound):
        points_of(session, world.subjects["foreign_therapist"], stored, None, None, 10)


def test_stored_sigmas_are_coarse_and_may_be_absent(exact: tuple[SessionSetup, Frames]) -> None:
    _, frames = exact
    chunk = encode_frames(frames.ticks(0, 500))
    back = decode_frames(chunk, frames.layout)
    assert back.segment_sigma_rad is not None
    np.testing.assert_allclose(back.segment_sigma_rad, frames.segment_sigma_rad[:500], rtol=1e-3)  # type: ignore[index]
    unknown = encode_frames(replace(frames.ticks(0, 500), segment_sigma_rad=None))
    assert decode_frames(unknown, frames.layout).segment_sigma_rad is None
    # An estimator that tells none costs nothing.
    blank = np.full_like(frames.segment_sigma_rad, np.nan)
    assert len(encode_frames(replace(frames, segment_sigma_rad=blank).ticks(0, 500)).data) == len(
        unknown.data
    )
    assert len(chunk.data) < 1.1 * len(unknown.data)


def test_files_have_columns_of_points(exact: tuple[SessionSetup, Frames]) -> None:
    setup, frames = exact
    part = frames.ticks(0, 400)
    plain, full = frames_table(part), frames_table(part, setup.body)
    assert set(plain.column_names) < set(full.column_names)
    found = described(part, setup.body)
    column = full["hand_right_velocity_z_mps"].to_numpy()
    np.testing.assert_array_equal(column, found.velocity_mps[:, found.names.index("hand_right"), 2])
    assert {"hand_right_sigma_x_m", "elbow_right_acceleration_y_mps2"} <= set(full.column_names)
