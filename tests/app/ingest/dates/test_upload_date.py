"""A session counts for the day of its recording: as the file says, as somebody says, else said to be unknown."""

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, select

from app import readers
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import RecordingFormatError
from app.exercises.models import Prescription
from app.ingest.upload import parse_declaration
from app.ingest.upload_task import _declare
from app.network.packet_log import write_log
from app.readers.moments import RECORDED_AT, as_metadata
from app.readers.sensor_names import check_names
from app.recordings.analysis.jobs import JobContext
from app.recordings.models import Job, MotionSession, SessionEvent
from app.settings import Settings
from estimators.simulation import SimulatedSession
from tests.app.ingest.uploads import declare

RECORDED = datetime(2026, 11, 9, 8, 0, tzinfo=UTC)


@pytest.fixture
def declared(engine: Engine, settings: Settings, world: Any, queue: Any, simulated: SimulatedSession) -> Any:
    """Register a log whose first packet arrived at a moment; returns its session after its declaration was stored."""

    def make(path: Path, arrival_ns: int, **said: Any) -> tuple[MotionSession, list[str]]:
        prepared = readers.packets_of(simulated.recording)
        path.write_bytes(b"".join(write_log(prepared.declaration.to_dict(), prepared.packets(arrival_ns))))
        job_id = queue(path, declare(world, **said))
        with read_only(engine) as session:
            job = session.get_one(Job, job_id)
        context = JobContext(
            engine, settings, job_id, job.session_id, world.subjects["therapist"], job.arguments
        )
        log = readers.LogReader(path)
        _declare(context, log.declaration, "arm", log.recorded_at, with_legs=False)
        with read_only(engine) as session:
            found = session.get_one(MotionSession, job.session_id)
            texts = session.scalars(select(SessionEvent.text).where(SessionEvent.session_id == found.id))
            return found, [text.code for text in texts]

    return make


def test_a_packet_log_is_of_the_day_of_its_first_packet(declared: Any, tmp_path: Path) -> None:
    found, said = declared(tmp_path / "a.tmlog", int(RECORDED.timestamp() * 1e9))
    assert found.started_at == RECORDED
    assert said == []


@pytest.mark.parametrize("arrival_ns", [0, 5, int(4e18)])
def test_a_log_without_a_possible_moment_says_that_the_day_is_not_known(
    declared: Any, tmp_path: Path, arrival_ns: int
) -> None:
    before = datetime.now(UTC)
    found, said = declared(tmp_path / "b.tmlog", arrival_ns)
    assert found.started_at >= before
    assert said == ["upload.day_unknown"]


def test_what_somebody_says_holds(declared: Any, tmp_path: Path) -> None:
    day_before = RECORDED - timedelta(days=1)
    found, said = declared(tmp_path / "c.tmlog", int(RECORDED.timestamp() * 1e9), recorded_at=day_before)
    assert found.started_at == day_before
    assert said == []


@pytest.mark.parametrize("moment", ["2026-11-09T08:00:00", "1969-01-01T00:00:00Z", "2999-01-01T00:00:00Z"])
def test_an_impossible_moment_is_refused(world: Any, moment: str) -> None:
    text = declare(world).model_dump_json().replace('"recorded_at":null', f'"recorded_at":"{moment}"')
    with pytest.raises(Exception, match="moment of the recording"):
        parse_declaration(text.encode())


def test_stamps_that_count_from_1970_say_the_day_and_others_do_not() -> None:
    assert as_metadata(RECORDED.timestamp()) == {RECORDED_AT: "2026-11-09T08:00:00.000+00:00"}
    for seconds in (0.0, 12.5, 1e18, float("nan")):
        assert as_metadata(seconds) == {}


@pytest.mark.parametrize(
    "name", ["=cmd|calc", "@SUM(1)", "+1", "-1", "a\nb", "\tx", "a\u202eb", "a;b", 'a"b', ""]
)
def test_a_name_that_a_spreadsheet_would_take_for_a_formula_is_refused(name: str) -> None:
    with pytest.raises(RecordingFormatError) as refused:
        check_names(["foot", name])
    assert refused.value.details["names"]


def test_usual_names_are_taken() -> None:
    check_names(["hand_right", "Sensor 2", "IMU-04.1", "Knöchel", "7"])


@pytest.mark.parametrize(
    ("days_before", "ends_after_days", "belongs"),
    [(10, None, True), (10, 20, True), (10, 5, False), (-1, None, False)],
)
def test_a_recording_belongs_to_what_was_prescribed_on_its_day(
    declared: Any,
    engine: Engine,
    world: Any,
    tmp_path: Path,
    days_before: int,
    ends_after_days: int | None,
    belongs: bool,
) -> None:
    """Nobody names the prescription: it is that of the exercise on the day of the recording, or none."""
    starts_at = RECORDED - timedelta(days=days_before)
    ends_at = None if ends_after_days is None else starts_at + timedelta(days=ends_after_days)
    with unit_of_work(engine) as session:
        prescription = Prescription(
            patient_id=world.patient_id,
            exercise_id=world.exercise_id,
            starts_at=starts_at,
            ends_at=ends_at,
            times_per_week=3,
            prescribed_by=world.subjects["therapist"].id,
        )
        session.add(prescription)
        session.flush()
        wanted = prescription.id if belongs else None
    found, _ = declared(tmp_path / "e.tmlog", int(RECORDED.timestamp() * 1e9), exercise_id=world.exercise_id)
    assert found.prescription_id == wanted
