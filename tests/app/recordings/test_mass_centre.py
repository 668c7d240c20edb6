"""The centre of mass of stored results: from an uploaded recording of trunk and legs to curves, and who may read it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app import readers
from app.accounts.models import AuditEvent
from app.accounts.subject import Subject
from app.commands import mass_centre as command
from app.commands.options.recordings import MassCentreOptions
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput, NotFound
from app.network.packet_log import write_log
from app.recordings.analysis.series import series_of
from app.recordings.models import Result
from app.recordings.series_schemas import SeriesOut
from app.recordings.signals.chunks import encode_frames, frames_stream
from app.recordings.signals.rows import insert_chunk
from app.viewer.figure.proportions import hip_height_m
from app.viewer.pose import track_from_frames
from estimators import pipelines
from estimators.balance import MASS_SCALARS
from estimators.pipelines import ArmPipeline, Frames, SessionSetup
from estimators.simulation import ArmScenario, Schedule, simulate_arm

pytestmark = pytest.mark.slow

LEGS = ("thigh_left", "shank_left", "thigh_right", "shank_right")
WORN = ("sternum", "pelvis", "upper_arm_left", "upper_arm_right", *LEGS)


@pytest.fixture(scope="module")
def run() -> tuple[SessionSetup, Frames]:
    made = simulate_arm(
        ArmScenario(
            exercise="abduction",
            both_arms=True,
            placements=WORN,
            schedule=Schedule(n_pose_s=5.0, repetitions=2),
            rate_hz=50.0,
        )
    )
    frames, setup = pipelines.run(made.recording, made.setup, (2.0, 5.0))
    return setup, frames


@pytest.fixture
def stored(engine: Engine, new_session: Any, run: tuple[SessionSetup, Frames]) -> tuple[str, str]:
    return _store(engine, new_session, *run)


def _store(engine: Engine, new_session: Any, setup: SessionSetup, frames: Frames) -> tuple[str, str]:
    session_id = new_session(state="analysed", setup=setup)
    with unit_of_work(engine) as session:
        result = Result(
            session_id=session_id,
            kind="offline",
            pipeline="arm",
            pipeline_version="1",
            orientation=setup.orientation,
            orientation_version="1",
            setup=setup.to_dict(),
            layout={n: list(getattr(frames.layout, n)) for n in ("segments", "points", "angles", "scalars")},
            status="complete",
        )
        session.add(result)
        session.flush()
        for start in range(0, frames.tick_count, 300):
            chunk = encode_frames(frames.ticks(start, start + 300))
            insert_chunk(session, session_id, frames_stream(result.id), start, chunk)
        return session_id, result.id


@pytest.fixture
def therapist(world: Any) -> Subject:
    return world.subjects["therapist"]


def mass_centre_of(
    session: Session, subject: Subject, ids: tuple[str, str], *stretch: float | None
) -> SeriesOut:
    session_id, result_id = ids
    start_s, end_s, most = stretch
    return series_of(session, subject, session_id, ["mass_centre"], result_id, start_s, end_s, int(most or 0))


def test_curves_are_those_of_the_result(
    engine: Engine, stored: tuple[str, str], run: tuple[SessionSetup, Frames], therapist: Subject
) -> None:
    _, frames = run
    with unit_of_work(engine) as session:
        found = mass_centre_of(session, therapist, stored, None, None, 200)
        part = mass_centre_of(session, therapist, stored, 6.0, 8.0, 2000)
    assert 90 < len(found.time_s) <= 200
    assert found.reasons == {}
    assert [curve.name for curve in found.curves] == list(MASS_SCALARS[:3])
    assert set(found.unworn) >= {"head", "hand_left", "foot_right"}
    assert not set(found.unworn) & set(WORN)
    at = np.searchsorted(frames.time_s, np.array(found.time_s) - 1e-6)
    for i, curve in enumerate(found.curves):
        own = frames.scalar[:, frames.layout.scalars.index(MASS_SCALARS[i])]
        np.testing.assert_allclose(np.array(curve.value, dtype=float), own[at], atol=4e-5)
        sigma = frames.scalar[at, frames.layout.scalars.index(MASS_SCALARS[3 + i])]
        np.testing.assert_allclose(np.array(curve.sigma, dtype=float), sigma, atol=2e-5)
        assert curve.least == pytest.approx(np.nanmin(own), abs=5e-5)
        assert curve.most == pytest.approx(np.nanmax(own), abs=5e-5)
    assert part.time_s[0] == pytest.approx(6.0)
    assert len(part.time_s) == 100


def test_reading_it_is_audited_and_closed_to_strangers(
    engine: Engine, stored: tuple[str, str], therapist: Subject, world: Any
) -> None:
    with unit_of_work(engine) as session:
        mass_centre_of(session, therapist, stored, 0.0, 1.0, 10)
    with read_only(engine) as session:
        event = session.scalars(select(AuditEvent).where(AuditEvent.action == "session.series")).one()
        assert (event.patient_id, event.subject_id) == (world.patient_id, therapist.id)
    with unit_of_work(engine) as session, pytest.raises(NotFound, match="arm_points and mass_centre"):
        series_of(session, therapist, stored[0], ["mass_center"], stored[1], None, None, 10)
    with unit_of_work(engine) as session, pytest.raises(NotFound):
        mass_centre_of(session, world.subjects["foreign_therapist"], stored, None, None, 10)


def test_without_leg_sensors_the_reason_is_told(engine: Engine, new_session: Any, therapist: Subject) -> None:
    made = simulate_arm(ArmScenario(schedule=Schedule(n_pose_s=4.0, repetitions=1), rate_hz=50.0))
    frames, setup = pipelines.run(made.recording, made.setup, (1.0, 4.0))
    ids = _store(engine, new_session, setup, frames)
    with unit_of_work(engine) as session:
        found = mass_centre_of(session, therapist, ids, None, None, 100)
    assert found.curves == []
    assert "both thighs" in found.reasons["mass_centre"]


def test_uploads_keep_the_legs_when_asked() -> None:
    assert ArmPipeline.used(WORN) == WORN[:4]
    assert ArmPipeline.used(WORN, with_legs=True) == WORN
    assert ArmPipeline.used(("pelvis", *LEGS)) == ("pelvis", *LEGS), "without arms they are what was recorded"


def test_the_ball_is_drawn_within_the_figure(run: tuple[SessionSetup, Frames]) -> None:
    setup, frames = run
    track = track_from_frames(frames, setup.body)
    assert track.mass_m is not None
    assert track.mass_spread_m is not None
    assert np.abs(track.mass_m[-1, :2]).max() < 0.06
    above_hip = track.mass_m[-1, 2] - hip_height_m(setup.body)
    assert 0.0 < above_hip < 0.12
    assert 0.02 < track.mass_spread_m[-1] < 0.08


def test_the_command_writes_what_it_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = simulate_arm(
        ArmScenario(placements=WORN, schedule=Schedule(n_pose_s=4.0, repetitions=1), rate_hz=50.0)
    )
    prepared = readers.packets_of(made.recording)
    log = tmp_path / "trunk_and_legs.tml"
    log.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(0))))
    wanted = MassCentreOptions(
        recording=log, out=tmp_path / "out", format="packet_log", pose_s=(1.0, 4.0), stature_m=1.70
    )
    command.mass_centre(wanted)
    rows = np.genfromtxt(tmp_path / "out" / "mass_centre.csv", delimiter=",", names=True)
    assert rows.dtype.names == ("time_s", *MASS_SCALARS)
    assert np.nanmean(rows["centre_of_mass_height_m"]) == pytest.approx(0.56 * 1.70, abs=0.03)
    assert "assumed" in capsys.readouterr().out
    arms = simulate_arm(ArmScenario(schedule=Schedule(n_pose_s=4.0, repetitions=1), rate_hz=50.0))
    prepared = readers.packets_of(arms.recording)
    log.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(0))))
    with pytest.raises(InvalidInput, match="both thighs"):
        command.mass_centre(replace(wanted, out=tmp_path / "none", pose_s=None))
