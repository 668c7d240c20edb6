"""A real server process on a real socket, and the therapist's hands on it."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from sqlalchemy import Engine

from app.database.engine import create_from_url
from app.gateway import DeviceStream, ServiceClient, stream_of
from app.live import warmup
from app.settings import Settings
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.patience import PATIENCE_S
from tests.ports import free_port


@pytest.fixture(autouse=True)
def prepared(monkeypatch: pytest.MonkeyPatch) -> None:
    """A session waits for its kernels, however long they take: a test is no gateway that comes back."""
    monkeypatch.setattr(warmup, "PATIENCE_S", 2.0 * PATIENCE_S)


PASSWORD = "a long enough password"
"""Of everybody in `world`."""
ROOT = Path(__file__).resolve().parents[3]


class ServerProcess:
    """uvicorn with the application, as `telemotion serve` starts it; survives `kill` and `start` again."""

    def __init__(self, settings: Settings, log: Path) -> None:
        self.port = free_port()
        self.address = f"http://127.0.0.1:{self.port}"
        self._log = log
        self._environment = os.environ | {
            "TELEMOTION_DATABASE_URL": settings.database_url,
            "TELEMOTION_SECRET_KEY": settings.secret_key.get_secret_value(),
            "TELEMOTION_BASE_URL": self.address,
            "TELEMOTION_DATA_DIR": str(settings.data_dir),
            # Ten minutes are streamed in one; that streams are slowed is a matter of test_limits.py.
            "TELEMOTION_STREAM_SPEED_LIMIT": "1000",
            "PYTHONPATH": str(ROOT),
            "OPENBLAS_NUM_THREADS": "1",
        }
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        arguments = ["--factory", "app.main:create_app", "--host", "127.0.0.1", "--port", str(self.port)]
        arguments += [
            "--ws",
            "app.network.lean_sockets:LeanSocket",
            "--loop",
            "uvloop",
            "--http",
            "httptools",
        ]
        arguments += ["--no-access-log", "--log-level", "warning"]
        with self._log.open("ab") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "uvicorn", *arguments],
                cwd=ROOT,
                env=self._environment,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            assert self.process.poll() is None, self._log.read_text()
            try:
                if httpx.get(f"{self.address}/api/health", trust_env=False, timeout=1).is_success:
                    return
            except httpx.TransportError:
                time.sleep(0.1)
        raise TimeoutError(self._log.read_text())

    def kill(self) -> None:
        """SIGKILL, the worker process for long tasks included."""
        if self.process is not None:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait(PATIENCE_S)
            self.process = None

    def log(self) -> str:
        return self._log.read_text()


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory, migrated_file: Path) -> Settings:
    """One database a module, because starting the real server takes seconds; every test has its own clinics."""
    folder = tmp_path_factory.mktemp("server")
    shutil.copy(migrated_file, folder / "telemotion.db")
    return Settings(
        _env_file=None,
        base_url="http://127.0.0.1:8000",
        secret_key="0123456789abcdefghijklmnopqrstuvwxyz-tests",
        database_url=f"sqlite:///{folder / 'telemotion.db'}",
        data_dir=folder / "var",
    )


@pytest.fixture(scope="module")
def engine(settings: Settings) -> Iterator[Engine]:
    engine = create_from_url(settings.database_url)
    yield engine
    engine.dispose()


@pytest.fixture(scope="module")
def server(settings: Settings) -> Iterator[ServerProcess]:
    process = ServerProcess(settings, settings.data_dir.parent / "server.log")
    process.start()
    yield process
    process.kill()


@pytest.fixture
def email(world: Any) -> Callable[[str], str]:
    return lambda name: f"{name}@{world.clinic_id[:6]}.example"


@pytest.fixture
def signed_in(server: ServerProcess, email: Callable[[str], str]) -> Callable[..., Awaitable[ServiceClient]]:
    """Return an async function that gives a client in which the named person is signed in."""

    async def make(name: str = "therapist") -> ServiceClient:
        client = ServiceClient(server.address)
        await client.sign_in(email(name), PASSWORD)
        return client

    return make


@pytest.fixture(scope="module")
def stream() -> DeviceStream:
    scenario = ArmScenario(schedule=Schedule(n_pose_s=10.0, repetitions=1), seed=5)
    return stream_of(simulate_arm(scenario).recording)
