"""A service on many machines, all of them this one: NATS, PostgreSQL, edges and workers as real processes."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import httpx
from pydantic import SecretStr

from app.database import migrate
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.scaled.mqtt.configuration import configuration
from app.settings import Settings
from tests.benchmarks.service import EMAIL as EMAIL
from tests.benchmarks.service import PASSWORD as PASSWORD
from tests.benchmarks.service import ROOT, SECRET, add_clinic, add_patient, compile_usual, environment_of
from tests.patience import PATIENCE_S
from tests.ports import free_port
from tests.scaled.tls.certificates import Authority

MOST_EDGES = 4
"""That the broker knows; a test that needs more finds out at once."""
SERVER = shutil.which("nats-server", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")


class Cluster:
    """Processes of one service.

    Parameters
    ----------
    folder : Path
    url : str
        Of an empty database on PostgreSQL.
    calibration : dict
        Of its patient.
    authority : Authority, optional
        NATS speaks TLS only, with the certificate of this authority.
    """

    def __init__(
        self, folder: Path, url: str, calibration: dict[str, object], authority: Authority | None = None
    ) -> None:
        self.folder, self.url, self.authority = folder, url, authority
        self.nats_port, self.mqtt_port = free_port(), free_port()
        self.calibration = calibration
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self.ports: dict[str, int] = {}
        self.before: dict[str, str] = {}
        """Code that a part runs first whenever it is started, by its name."""
        migrate.upgrade(url)
        engine = create_from_url(url)
        with unit_of_work(engine) as session:
            self.patient_id = add_patient(session, add_clinic(session), EMAIL, calibration)
        engine.dispose()

    @property
    def nats_url(self) -> str:
        """Where workers find the broker."""
        return self._nats_url("worker")

    def edge_url(self, name: str) -> str:
        """Return where an edge finds the broker."""
        return self._nats_url(name)

    def _nats_url(self, user: str) -> str:
        scheme = "tls" if self.authority else "nats"
        return f"{scheme}://{user}:only-for-tests-of-{user}@127.0.0.1:{self.nats_port}"

    @property
    def mqtt_url(self) -> str:
        """Where gateways find it by MQTT."""
        return f"{'mqtts' if self.authority else 'mqtt'}://127.0.0.1:{self.mqtt_port}"

    def environment(self, port: int) -> dict[str, str]:
        """Return that of a part."""
        trusted = {"TELEMOTION_NATS_CA": str(self.authority.ca)} if self.authority else {}
        return environment_of(self.url, self.folder / "data", port) | {
            "TELEMOTION_NATS_URL": self.nats_url,
            "TELEMOTION_MQTT": "true",
            "TELEMOTION_PARTITIONS": "8",
            "TELEMOTION_LEASE_SECONDS": "1.5",
            "PYTHONWARNINGS": "ignore:resource_tracker",
            **trusted,
        }

    def start_broker(self) -> None:
        """Start NATS on its port and folder, also anew."""
        assert SERVER, "nats-server is in the test extra"
        file = self.folder / "nats.conf"
        edges = ",".join(self.edge_url(f"edge{number}") for number in range(MOST_EDGES))
        settings = Settings(
            secret_key=SecretStr(SECRET), nats_url=SecretStr(self.nats_url), nats_edge_url=SecretStr(edges)
        )
        text = configuration(
            settings,
            listen=f"127.0.0.1:{self.nats_port}",
            mqtt=f"127.0.0.1:{self.mqtt_port}",
            store=str(self.folder / "nats"),
            tls=self.authority.files if self.authority else "",
            listen_tls=self.authority.files if self.authority else "",
        )
        file.write_text(text)
        command = [SERVER, "-c", str(file)]
        with (self.folder / "nats.log").open("ab") as log:
            self.processes["nats"] = subprocess.Popen(command, stderr=log, stdout=log)

    def start(self, kind: str, name: str) -> None:
        """Start an edge or a worker; it may not be ready yet."""
        port = self.ports[name] = self.ports.get(name) or free_port()
        code = f"{self.before.get(name, '')}\nfrom app.commands.scaled import {kind}; {kind}('127.0.0.1', {port})"
        environment = self.environment(port) | {"TELEMOTION_LOG_LEVEL": "info"}
        if kind == "edge":
            environment["TELEMOTION_NATS_URL"] = self.edge_url(name)
        with (self.folder / f"{name}.log").open("ab") as log:
            self.processes[name] = subprocess.Popen(
                [sys.executable, "-c", code], env=environment, cwd=ROOT, stderr=log, stdout=log
            )

    def address(self, name: str) -> str:
        """Return where a part answers."""
        return f"http://127.0.0.1:{self.ports[name]}"

    def until_ready(self, *names: str) -> None:
        """Return when parts say that they are ready."""
        until = time.monotonic() + PATIENCE_S
        for name in names:
            while True:
                assert self.processes[name].poll() is None, self.log(name)
                assert time.monotonic() < until, self.log(name)
                try:
                    if httpx.get(f"{self.address(name)}/api/ready", trust_env=False, timeout=5).is_success:
                        break
                except httpx.TransportError:
                    pass
                time.sleep(0.05)

    def begin(self, edges: int = 2, workers: int = 2) -> None:
        """Start everything, and wait until it is ready."""
        self.start_broker()
        compile_usual()
        parts = [("worker", f"worker{n}") for n in range(workers)] + [
            ("edge", f"edge{n}") for n in range(edges)
        ]
        for kind, name in parts:
            self.start(kind, name)
        self.until_ready(*(name for _, name in parts))

    def kill(self, name: str) -> None:
        """End a process as a power cut would."""
        self.processes[name].kill()
        self.processes[name].wait()

    def signal(self, name: str, number: signal.Signals) -> None:
        """Send a process a signal."""
        self.processes[name].send_signal(number)

    def log(self, name: str) -> str:
        """Return the end of what a process wrote."""
        return (self.folder / f"{name}.log").read_text(errors="replace")[-8000:]

    def copy_logs(self, folder: Path) -> None:
        """Copy what the processes wrote to a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for log in self.folder.glob("*.log"):
            shutil.copy(log, folder / log.name)

    def close(self) -> None:
        """End every process."""
        # The broker last: what the others hold goes into it.
        for name, process in sorted(self.processes.items(), key=lambda one: one[0] == "nats"):
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.terminate()
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                print(f"{name} did not end", file=sys.stderr)
                process.kill()
                process.wait()
