"""`telemotion demo`: the service with an invented clinic, and a patient who streams live."""

import shutil
import socket
import subprocess
import sys
from pathlib import Path

import typer

from app.commands.serve import serve
from app.database import engine as engines
from app.database import migrate
from app.demo.people import is_seeded, seed_people
from app.errors import Conflict, InvalidInput
from app.settings import Settings

HISTORY_MARK = "history-complete"


def _require_free(port: int) -> None:
    """Refuse a port that somebody listens on, before anything is prepared for it.

    Raises
    ------
    Conflict
        The port is taken, perhaps by another demonstration.
    """
    with socket.socket() as probe:
        if probe.connect_ex(("127.0.0.1", port)) == 0:
            raise Conflict(
                f"port {port} is taken; stop what runs there, or choose another (make run PORT=...)"
            )


def demo(port: int, folder: Path, fresh: bool, stream: bool) -> None:
    """Prepare the demonstration's database, start its companion, and serve.

    Parameters
    ----------
    port : int
    folder : Path
        Database and files in passing.
    fresh : bool
        Throw an earlier demonstration away.
    stream : bool
        Start the simulated patient.
    """
    mark = folder / HISTORY_MARK
    _require_free(port)
    database = folder / "telemotion.db"
    if folder.exists() and any(folder.iterdir()) and not database.exists():
        raise InvalidInput(f"{folder} holds something else; name a new or empty folder")
    if database.exists() and (fresh or not mark.exists()):
        # A first start that was interrupted left half a history: begin again rather than show it.
        shutil.rmtree(folder)
    folder.mkdir(parents=True, exist_ok=True)
    server = f"http://127.0.0.1:{port}"
    settings = Settings(
        demo=True,
        base_url=server,
        database_url=f"sqlite:///{database.resolve()}",
        data_dir=folder,
        log_level="warning",
    )
    migrate.upgrade(settings.database_url)
    engine = engines.create(settings)
    try:
        with_history = not is_seeded(engine)
        if with_history:
            typer.echo("Preparing the demonstration clinic (about a minute, the first time only) ...")
            seed_people(engine)
    finally:
        engine.dispose()
    words = [
        sys.executable,
        "-m",
        "app.demo.companion",
        "--server",
        server,
        "--database-url",
        settings.database_url,
    ]
    if with_history:
        words += ["--history-mark", str(mark)]
    if stream:
        words.append("--stream")
    companion = subprocess.Popen(words)  # noqa: S603 - our own interpreter and module
    try:
        serve("127.0.0.1", port, settings)
    finally:
        companion.terminate()
        companion.wait(timeout=10)
