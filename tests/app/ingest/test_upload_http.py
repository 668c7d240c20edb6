"""Uploads over HTTP: who may, what is refused before it is received, and previews."""

import json
import time
from base64 import b64encode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, select

from app import readers
from app.accounts.models import AuditEvent
from app.database.unit_of_work import read_only
from app.readers.tables.schemas import CsvMapping
from app.recordings.analysis.jobs import JobRunner
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import MotionSession
from app.settings import Settings
from tests.app.ingest.uploads import declare
from tests.app.readers.odd_tables import odd_tables
from tests.patience import PATIENCE_S

MIB = 1 << 20


def post(client: Any, declaration: dict[str, Any] | None, content: bytes | None, **changes: Any) -> Any:
    parts: list[Any] = []
    if declaration is not None:
        parts.append(("declaration", (None, json.dumps(declaration), "application/json")))
    if content is not None:
        parts.append(("file", ("a.tmlog", content, "application/octet-stream")))
    if changes.get("reverse"):
        parts.reverse()
    return client.post("/api/uploads", files=parts)


def test_an_upload_over_http_is_queued_and_audited(
    therapist: Any, world: Any, log: Path, engine: Engine, services: Any
) -> None:
    services.get(JobRunner).stop()
    answer = post(therapist, declare(world).model_dump(mode="json"), log.read_bytes())
    assert answer.status_code == 202, answer.text
    job = answer.json()
    assert (job["kind"], job["status"]) == ("upload", "queued")
    shown = therapist.get(f"/api/jobs/{job['id']}").json()
    assert shown == job
    assert therapist.get(f"/api/sessions/{job['session_id']}/jobs").json() == [job]
    assert therapist.get(f"/api/sessions/{job['session_id']}").json()["state"] == "closing"
    with read_only(engine) as session:
        actions = list(session.scalars(select(AuditEvent.action)))
    assert "session.create" in actions


def test_whoever_may_not_record_cannot_upload_and_nothing_is_stored(
    sign_in: Any, nobody: Any, world: Any, log: Path, settings: Settings
) -> None:
    declaration = declare(world).model_dump(mode="json")
    content = log.read_bytes()
    expected = {
        "reader": 403,
        "colleague": 404,
        "other_patient": 404,
        "foreign_therapist": 404,
        "former": 404,
    }
    for name, status in expected.items():
        assert post(sign_in(name), declaration, content).status_code == status, name
    assert post(nobody, declaration, content).status_code == 401
    assert not list(upload_folder(settings).iterdir())


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda d, c: (None, c, {}), "before the part"),
        (lambda d, c: (d, None, {}), "`file` is missing"),
        (lambda d, c: (d, c, {"reverse": True}), "before the part"),
        (lambda d, c: ({**d, "format": "docx"}, c, {}), "format"),
        (lambda d, c: ({**d, "format": "csv"}, c, {}), "needs `csv`"),
        (lambda d, c: ({**d, "calibration_pose_s": [5, 2]}, c, {}), "calibration_pose_s"),
        (lambda d, c: ({**d, "orientation": "magic"}, c, {}), "magic"),
        (lambda d, c: (d, b"", {}), "TML1"),
    ],
)
def test_a_wrong_request_says_what_to_do(
    therapist: Any, world: Any, log: Path, settings: Settings, make: Any, says: str
) -> None:
    declaration, content, changes = make(declare(world).model_dump(mode="json"), log.read_bytes())
    answer = post(therapist, declaration, content, **changes)
    assert answer.status_code == 422, answer.text
    assert says in answer.json()["message"]
    assert not list(upload_folder(settings).iterdir())


def test_two_gigabytes_are_refused_by_their_announced_length(
    therapist: Any, world: Any, settings: Settings
) -> None:
    read = 0

    def endless() -> Iterator[bytes]:
        nonlocal read
        while read < 2048:
            read += 1
            yield bytes(MIB)

    answer = therapist.post(
        "/api/uploads",
        content=endless(),
        headers={"Content-Length": str(2 << 30), "Content-Type": "multipart/form-data; boundary=x"},
    )
    assert answer.status_code == 413
    assert answer.json()["code"] == "too_large"
    assert answer.json()["details"]["limit_bytes"] > 0
    assert not list(upload_folder(settings).iterdir())


@pytest.mark.slow
def test_the_running_service_takes_an_upload_to_its_end(therapist: Any, world: Any, log: Path) -> None:
    """The whole way through the real worker process."""
    job = post(therapist, declare(world).model_dump(mode="json"), log.read_bytes()).json()
    deadline = time.monotonic() + PATIENCE_S
    while therapist.get(f"/api/sessions/{job['session_id']}").json()["state"] == "closing":
        assert time.monotonic() < deadline
        time.sleep(0.2)
    found = therapist.get(f"/api/sessions/{job['session_id']}").json()
    assert (found["state"], found["results"][0]["status"]) == ("analysed", "complete")
    jobs = therapist.get(f"/api/sessions/{job['session_id']}/jobs").json()
    assert {(j["kind"], j["status"], j["progress"]) for j in jobs} == {
        ("upload", "complete", 1.0),
        ("compare", "complete", 1.0),
    }


def test_a_preview_says_how_a_table_would_be_read_and_stores_nothing(
    therapist: Any, engine: Engine, settings: Settings
) -> None:
    odd = odd_tables()["german"]
    answer = therapist.post(
        "/api/uploads/preview",
        json={"file_name": "a.csv", "beginning": b64encode(odd.content[: readers.HEAD_BYTES]).decode()},
    )
    assert answer.status_code == 200, answer.text
    found = answer.json()
    direct = readers.preview_text("a.csv", odd.content[: readers.HEAD_BYTES])
    assert (found["format"], found["pipeline"], found["missing"]) == ("csv", "orientation", [])
    assert CsvMapping.model_validate(found["mapping"]) == CsvMapping.model_validate(direct.guess.mapping)
    refused = therapist.post("/api/uploads/preview", json={"file_name": "a.csv", "beginning": "AAAA"})
    assert refused.status_code == 422
    assert refused.json()["sentences"]["message"]["code"] == "table.not_text"
    with read_only(engine) as session:
        assert session.scalars(select(MotionSession)).all() == []
    assert not (settings.data_dir / "uploads").exists() or not list((settings.data_dir / "uploads").iterdir())


def test_a_preview_leaves_open_a_unit_that_nothing_says(therapist: Any) -> None:
    """Raw counts of a converter: the person who knows the sensor names the unit or converts."""
    counts = "acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n" + "-2052,-28,-73,1,0,-5\n" * 40
    answer = therapist.post(
        "/api/uploads/preview",
        json={"file_name": "a.csv", "beginning": b64encode(counts.encode()).decode()},
    )
    assert answer.status_code == 200, answer.text
    units = {one["quantity"]: one["unit"] for one in answer.json()["mapping"]["signals"]}
    assert units["accelerometer"] is None
    assert "guess.no_unit" in [one["code"] for one in answer.json()["sentences"]["missing"]]
