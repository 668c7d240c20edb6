"""The export of a patient holds everything, once, and the trail says so in one line."""

import io
import json
import zipfile

import pyarrow.parquet
import pytest
from sqlalchemy import select

from app.accounts.models import AuditEvent
from app.database.unit_of_work import read_only, unit_of_work
from app.ingest.upload import upload_folder
from tests.app.viewer.stored_reaches import Recorded, compared_reaches, store


@pytest.fixture
def recorded(world, engine) -> Recorded:
    with unit_of_work(engine) as session:
        return store(
            session,
            world.clinic_id,
            world.patient_id,
            world.exercise_id,
            world.accounts["therapist"],
            compared_reaches(),
        )


def test_everything_is_in_it(engine, world, settings, recorded, patient) -> None:
    answer = patient.get(f"/api/patients/{world.patient_id}/export")
    assert answer.status_code == 200
    assert answer.headers["content-disposition"].endswith('.zip"')
    archive = zipfile.ZipFile(io.BytesIO(answer.content))
    assert archive.testzip() is None
    own = json.loads(archive.read("patient.json"))
    assert own["patient"]["id"] == world.patient_id
    assert {one["level"] for one in own["grants"]} >= {"treat"}
    assert [one["name"] for one in own["templates"]] == ["Reach"]
    names = archive.namelist()
    details = [json.loads(archive.read(name)) for name in names if name.endswith("session.json")]
    assert {one["id"] for one in details} >= {recorded.session_id, recorded.live_session_id}
    (movement,) = [name for name in names if name.endswith(f"movement-{recorded.result_id[:8]}.parquet")]
    table = pyarrow.parquet.read_table(io.BytesIO(archive.read(movement)))
    assert table.num_rows == recorded.frames.tick_count
    angle = recorded.frames.layout.angles[0]
    assert table[f"{angle}_rad"].to_numpy()[-1] == pytest.approx(recorded.frames.angle_rad[-1, 0], abs=1e-4)
    (compared,) = [name for name in names if name.endswith("comparisons.json")]
    assert json.loads(archive.read(compared))[0]["repetitions"]
    assert list(upload_folder(settings).iterdir()) == []


def test_the_trail_says_it_in_one_line(engine, world, recorded, therapist) -> None:
    before = _actions(engine, world.patient_id)
    assert therapist.get(f"/api/patients/{world.patient_id}/export").status_code == 200
    assert _actions(engine, world.patient_id)[len(before) :] == ["patient.export"]


def _actions(engine, patient_id: str) -> list[str]:
    with read_only(engine) as session:
        query = (
            select(AuditEvent.action).where(AuditEvent.patient_id == patient_id).order_by(AuditEvent.number)
        )
        return list(session.scalars(query))
