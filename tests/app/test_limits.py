"""What one account or clinic holds leaves room for the others, and is counted back when it ends."""

from dataclasses import dataclass

import pytest
from sqlalchemy import Engine

from app.database.unit_of_work import unit_of_work
from app.errors import LimitReached, Unavailable
from app.limits import Limits
from app.network.pace import Pace
from app.recordings.models import MotionSession, SignalChunk
from app.recordings.signals.disk import DiskUse
from app.settings import Allowance, Settings
from estimators.pipelines import SessionSetup


@dataclass(frozen=True)
class Person:
    id: str
    clinic_id: str


ADA, BERT, CARL, DORA = Person("a", "one"), Person("b", "one"), Person("c", "two"), Person("d", "three")


def test_an_account_a_clinic_and_the_service_are_counted_apart() -> None:
    limits = Limits({"views": Allowance(2, 3, 4)})
    first, second = limits.take("views", ADA), limits.take("views", ADA)
    with pytest.raises(LimitReached, match="Open 3D views for one account: at most 2") as own:
        limits.take("views", ADA)
    assert (own.value.details["scope"], own.value.details["retry_after_s"]) == ("account", 60)
    limits.take("views", BERT)
    with pytest.raises(LimitReached, match="Open 3D views in your clinic: at most 3"):
        limits.take("views", BERT)
    neighbour = limits.take("views", CARL)
    with pytest.raises(Unavailable, match="on this service"):
        limits.take("views", DORA)
    first.release()
    first.release()
    assert limits.held("views", "service") == 3, "released twice is released once"
    with neighbour, limits.take("views", DORA):
        assert limits.held("views", "service") == 4
    second.release()
    assert limits.held("views", "account", "a") == 0
    assert limits.held("views", "service") == 1


def test_allowances_are_read_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TELEMOTION_SECRET_KEY", "0123456789abcdefghijklmnopqrstuvwxyz-tests")
    monkeypatch.setenv("TELEMOTION_LIMIT_VIEWS", "2/ 5/9")
    assert Settings(_env_file=None).limit_views == (2, 5, 9)
    for wrong in ("3", "a/b/c", "0/1/2"):
        monkeypatch.setenv("TELEMOTION_LIMIT_VIEWS", wrong)
        with pytest.raises(ValueError, match="limit_views"):
            Settings(_env_file=None)


def test_a_gateway_five_times_too_fast_is_read_three_times_as_fast() -> None:
    now = 0.0
    pace = Pace(3.0, burst_s=20.0, now_s=now)
    signal_s = 0.0
    while now < 100.0:
        signal_s += 0.05
        # It has the next packet ready a fifth of the packet's duration later, or as soon as it is read.
        now += max(0.01, pace.take(0.05, now))
    assert signal_s == pytest.approx(3.0 * 100.0 + 20.0, rel=0.01)


def test_a_gateway_in_real_time_never_waits() -> None:
    now = 0.0
    pace = Pace(3.0, now_s=now)
    for number in range(10_000):
        # A link that holds everything up for two seconds now and then.
        now += 2.0 if number % 100 == 0 else 0.05 - 1.95 / 99
        assert pace.take(0.05, now) == 0.0


def test_an_upload_beyond_the_share_is_refused_and_says_when_to_come_back(services, world, therapist) -> None:
    holds = [services.limits.take("uploads", world.subjects["therapist"]) for _ in range(3)]
    answer = therapist.post("/api/uploads", files={"declaration": b"{}", "file": b""})
    assert (answer.status_code, answer.json()["code"]) == (429, "limit_reached")
    assert int(answer.headers["retry-after"]) > 0
    holds[0].release()
    assert therapist.post("/api/uploads", files={"declaration": b"{}", "file": b""}).status_code == 422
    assert services.limits.held("uploads", "service") == 2


def test_a_clinic_that_has_used_up_its_disk_starts_nothing_and_the_other_does(
    engine: Engine, services, world, therapist, foreign_therapist
) -> None:
    setup = SessionSetup("arm", ("sternum", "upper_arm_right", "forearm_right"), 100.0).to_dict()
    services.get(DiskUse)._most_bytes = 1000
    wanted = {"patient_id": world.patient_id, "placements": list(setup["placements"])}
    stored = therapist.post("/api/sessions", json=wanted)
    assert stored.status_code == 201
    chunk = SignalChunk(
        session_id=stored.json()["id"],
        stream="raw",
        sequence=0,
        start_ns=0,
        ticks=1,
        codec="x",
        scale={},
        crc=0,
    )
    chunk.data = bytes(1000)
    with unit_of_work(engine) as session:
        session.add(chunk)
    services.get(DiskUse)._counted.clear()
    answer = therapist.post("/api/sessions", json=wanted)
    assert (answer.status_code, answer.json()["code"]) == (413, "quota_reached")
    assert "Delete sessions" in answer.json()["message"]
    other = foreign_therapist.post("/api/sessions", json=wanted | {"patient_id": world.foreign_patient_id})
    assert other.status_code == 201
    with unit_of_work(engine) as session:
        session.delete(session.get_one(MotionSession, stored.json()["id"]))
    assert therapist.post("/api/sessions", json=wanted).status_code == 201, (
        "what was deleted makes room at once"
    )
