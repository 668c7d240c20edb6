"""The export of a patient holds everything, once, and the trail says so in one line."""

import io
import json
import zipfile
import zlib

import pyarrow.parquet
import pytest
from sqlalchemy import select, update

from app.accounts.models import AuditEvent
from app.assessment.exports.patient import export
from app.database.unit_of_work import read_only, unit_of_work
from app.exercises.models import Template
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import Job, MotionSession, SessionEvent
from app.recordings.signals.chunks import EncodedChunk
from app.recordings.signals.codecs import checksum
from app.recordings.signals.rows import insert_chunk
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


@pytest.mark.slow
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
    text = archive.read(movement.replace(".parquet", ".csv")).decode().splitlines()
    assert len(text) == 1 + table.num_rows
    assert text[0].replace('"', "").split(",") == table.column_names
    dictionary = json.loads(archive.read(movement.replace(".parquet", ".json")))
    assert [one["name"] for one in dictionary["columns"]] == table.column_names
    assert dictionary["setup"]["pipeline"] == "arm"
    (compared,) = [name for name in names if name.endswith("comparisons.json")]
    assert json.loads(archive.read(compared))[0]["repetitions"]
    assert list(upload_folder(settings).iterdir()) == []


def test_templates_devices_markers_and_safety_words_are_in_it(
    engine, world, recorded, patient, device_token
) -> None:
    token = device_token(world.patient_id)
    with unit_of_work(engine) as session:
        # One that the whole clinic uses is movement of this patient all the same.
        session.execute(update(Template).where(Template.name == "Reach").values(patient_id=None))
        for kind in ("implants_excluded", "implants_withdrawn"):
            session.add(
                SessionEvent(
                    session_id=recorded.session_id,
                    kind=kind,
                    time_s=0.0,
                    details={"by": world.accounts["therapist"]},
                )
            )
        found = session.get_one(MotionSession, recorded.session_id)
        session.add(
            Job(session_id=found.id, kind="markers", arguments={"markers_id": "m" * 32}, created_by="x")
        )
        for number in range(2):
            data = zlib.compress(b"frame,x\n1,0.5\n")
            told = {"declaration": {"segment": "forearm_right", "format": "csv"}, "bytes": 30}
            chunk = EncodedChunk(0, 0, "file.zlib", told, checksum(data), data)
            insert_chunk(session, found.id, "markers/" + "m" * 32, number, chunk)
    answer = patient.get(f"/api/patients/{world.patient_id}/export")
    archive = zipfile.ZipFile(io.BytesIO(answer.content))
    own = json.loads(archive.read("patient.json"))
    assert [one["label"] for one in own["devices"]] == ["gateway"]
    assert token.encode() not in answer.content
    assert [one["name"] for one in own["templates"]] == ["Reach"]
    by_end = {name.rsplit("/", 1)[-1]: name for name in archive.namelist()}
    (template,) = [name for name in archive.namelist() if name.startswith("templates/Reach-1")]
    assert len(json.loads(archive.read(template))["content"]["curves"][0]["mean"]) == 101
    words = json.loads(archive.read(by_end["safety.json"]))
    assert [word["by"] for word in words] == [world.accounts["therapist"]] * 2
    assert archive.read(by_end["markers-mmmmmmmm.csv"]) == b"frame,x\n1,0.5\n" * 2
    assert json.loads(archive.read(by_end["markers-mmmmmmmm.json"]))["segment"] == "forearm_right"


@pytest.mark.slow
def test_only_so_many_are_made_at_once(world, recorded, services, patient, therapist) -> None:
    path = f"/api/patients/{world.patient_id}/export"
    with services.limits.take("exports", world.subjects["therapist"]):
        answer = therapist.get(path)
        assert (answer.status_code, answer.json()["code"]) == (429, "limit_reached")
        assert int(answer.headers["retry-after"]) > 0
        assert patient.get(path).status_code == 200
    assert therapist.get(path).status_code == 200
    assert services.limits.held("exports", "service") == 0


def test_a_reader_that_leaves_ends_the_export(engine, settings, world, recorded, services) -> None:
    pieces = export(engine, settings, services.limits, world.subjects["therapist"], world.patient_id)
    assert next(pieces).startswith(b"PK")
    assert services.limits.held("exports", "service") == 1
    del pieces
    assert services.limits.held("exports", "service") == 0
    export(engine, settings, services.limits, world.subjects["therapist"], world.patient_id)
    assert services.limits.held("exports", "service") == 0, "never begun"


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
