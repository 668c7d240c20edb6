"""Files that arrive and wait use the clinic's quota, and leave room for what is streamed."""

import json
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from sqlalchemy import Engine

from app.database.unit_of_work import unit_of_work
from app.network.packet_log import log_entry, log_head
from app.recordings import repository
from app.recordings.analysis.jobs import JobRunner, run_job
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import Job, MotionSession
from app.recordings.signals.disk import DiskUse
from app.settings import Settings
from tests.app.ingest.test_upload_http import post
from tests.app.ingest.uploads import declare

MIB = 1 << 20


@pytest.fixture
def room(services: Any) -> DiskUse:
    """A clinic that may have 1 MiB; nothing is done with what waits."""
    services.get(JobRunner).stop()
    found: DiskUse = services.get(DiskUse)
    found._most_bytes = MIB
    return found


def padded(head: bytes, size: int) -> bytes:
    """Return a log of about this size; what its packets hold is looked at by its task only."""
    entry = log_entry(bytes(1000))
    return head + entry * ((size - len(head)) // len(entry) + 1)


def files(settings: Settings) -> list[str]:
    return sorted(path.name for path in upload_folder(settings).iterdir())


@pytest.fixture(scope="module")
def small_log() -> bytes:
    declared = {"protocol_version": 1, "ticket": "x", "placements": ["upper_arm_right"], "rate_hz": 100.0}
    return log_head(declared)


def test_four_files_of_35_mb_do_not_fit_into_a_quota_of_one(
    therapist: Any, world: Any, small_log: bytes, settings: Settings, room: DiskUse
) -> None:
    content = padded(small_log, 35_000_000)
    for _ in range(4):
        answer = post(therapist, declare(world).model_dump(mode="json"), content)
        assert (answer.status_code, answer.json()["code"]) == (413, "quota_reached")
        assert answer.json()["details"]["size_bytes"] >= 35_000_000
        assert "33.4 MiB" in answer.json()["message"]
    assert files(settings) == []
    assert room.used_bytes(world.subjects["therapist"].clinic_id) == 0


def test_what_waits_counts_until_its_session_is_deleted(
    therapist: Any, world: Any, small_log: bytes, engine: Engine, settings: Settings, room: DiskUse
) -> None:
    declaration = declare(world).model_dump(mode="json")
    content = padded(small_log, 300_000)
    answers = [post(therapist, declaration, content) for _ in range(4)]
    assert [answer.status_code for answer in answers] == [202, 202, 202, 413]
    assert answers[3].json()["code"] == "quota_reached"
    assert len(files(settings)) == 3
    # Counted from the disk, as after a start of the service, it is the same.
    room._counted.clear()
    assert post(therapist, declaration, content).status_code == 413
    wanted = {"patient_id": world.patient_id, "placements": ["sternum", "upper_arm_right", "forearm_right"]}
    assert therapist.post("/api/sessions", json=wanted).status_code == 201, "a tenth is left to live sessions"
    with unit_of_work(engine) as session:
        gone = session.get_one(MotionSession, answers[0].json()["session_id"])
        repository.delete_session(session, settings, world.subjects["therapist"], gone.id)
    assert len(files(settings)) == 2
    assert post(therapist, declaration, content).status_code == 202


def test_another_clinic_has_its_own_room(
    therapist: Any, foreign_therapist: Any, world: Any, small_log: bytes, room: DiskUse
) -> None:
    content = padded(small_log, 700_000)
    assert post(therapist, declare(world).model_dump(mode="json"), content).status_code == 202
    other = declare(world, patient_id=world.foreign_patient_id).model_dump(mode="json")
    assert post(foreign_therapist, other, content).status_code == 202


def test_files_that_arrive_together_share_the_room(
    therapist: Any, world: Any, small_log: bytes, settings: Settings, room: DiskUse
) -> None:
    declaration = declare(world).model_dump(mode="json")
    content = padded(small_log, 600_000)
    with ThreadPoolExecutor(3) as pool:
        answers = list(pool.map(lambda _: post(therapist, declaration, content).status_code, range(3)))
    assert sorted(answers) == [202, 413, 413]
    assert len(files(settings)) == 1


def test_a_file_of_unannounced_length_ends_where_the_room_ends(
    therapist: Any, world: Any, settings: Settings, room: DiskUse
) -> None:
    room._most_bytes = 8 * MIB
    sent = 0

    def endless() -> Iterator[bytes]:
        nonlocal sent
        yield b'--x\r\nContent-Disposition: form-data; name="declaration"\r\n\r\n'
        yield json.dumps(declare(world).model_dump(mode="json")).encode()
        yield b'\r\n--x\r\nContent-Disposition: form-data; name="file"; filename="a"\r\n\r\n'
        while sent < 64:
            sent += 1
            yield bytes(MIB)

    answer = therapist.post(
        "/api/uploads", content=endless(), headers={"Content-Type": "multipart/form-data; boundary=x"}
    )
    assert (answer.status_code, answer.json()["code"]) == (413, "quota_reached")
    assert files(settings) == []


def test_uploads_leave_some_of_the_disk_to_what_is_streamed(
    therapist: Any, world: Any, small_log: bytes, services: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    services.get(JobRunner).stop()
    reserve = services.settings.disk_reserve_bytes
    free = reserve + 400_000
    monkeypatch.setattr(shutil, "disk_usage", lambda _: type("Usage", (), {"free": free}))
    declaration = declare(world).model_dump(mode="json")
    answer = post(therapist, declaration, padded(small_log, 500_000))
    assert (answer.status_code, answer.json()["code"]) == (503, "unavailable")
    assert int(answer.headers["retry-after"]) > 0
    assert post(therapist, declaration, padded(small_log, 300_000)).status_code == 202


def test_a_failed_task_frees_the_room_of_its_file(
    therapist: Any, world: Any, small_log: bytes, engine: Engine, settings: Settings, room: DiskUse
) -> None:
    def fails(_: Any) -> str:
        raise MemoryError

    declaration = declare(world).model_dump(mode="json")
    answer = post(therapist, declaration, padded(small_log, 700_000))
    run_job(engine, settings, answer.json()["id"], fails)
    with unit_of_work(engine) as session:
        assert session.get_one(Job, answer.json()["id"]).status == "failed"
    assert post(therapist, declaration, padded(small_log, 700_000)).status_code == 202


def test_a_file_of_markers_needs_room_too(
    therapist: Any, world: Any, small_log: bytes, engine: Engine, settings: Settings, room: DiskUse
) -> None:
    answer = post(therapist, declare(world).model_dump(mode="json"), padded(small_log, 2000))
    session_id = answer.json()["session_id"]
    with unit_of_work(engine) as session:
        found = session.get_one(MotionSession, session_id)
        found.state, found.hello = "analysed", {"placements": ["upper_arm_right"]}
    declaration = {"format": "csv", "segment": "upper_arm_right", "marker": "A", "rate_hz": 100.0}
    answer = therapist.post(
        f"/api/sessions/{session_id}/markers",
        files=[
            ("declaration", (None, json.dumps(declaration), "application/json")),
            ("file", ("a.csv", bytes(3 * MIB), "text/csv")),
        ],
    )
    assert (answer.status_code, answer.json()["code"]) == (413, "quota_reached"), answer.text
