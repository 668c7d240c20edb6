"""`telemotion demo`: the service with an invented clinic, and a patient who streams live."""

import shutil
import subprocess
import sys
from pathlib import Path

import typer

from app.commands.serve import claim, run
from app.database import engine as engines
from app.database import migrate
from app.database.writer_lock import LOCK_SUFFIX
from app.demo.people import is_seeded, seed_people
from app.errors import InvalidInput
from app.settings import Settings

HISTORY_MARK = "history-complete"


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
    database = folder / "telemotion.db"
    if folder.exists() and not database.exists() and _contents(folder):
        raise InvalidInput(f"{folder} holds something else; name a new or empty folder")
    server = f"http://127.0.0.1:{port}"
    settings = Settings(
        demo=True,
        base_url=server,
        database_url=f"sqlite:///{database.resolve()}",
        data_dir=folder,
        log_level="warning",
    )
    with claim(settings, "127.0.0.1", port, "telemotion demo") as (listener, lock):
        words = _prepare(settings, folder, fresh)
        if stream:
            words.append("--stream")
        companion = subprocess.Popen(words)  # noqa: S603 - our own interpreter and module
        try:
            run(settings, listener, lock)
        finally:
            companion.terminate()
            companion.wait(timeout=10)


def _contents(folder: Path) -> list[Path]:
    """Return what is in a demonstration's folder, without the lock, which must stay while it is held."""
    return [path for path in folder.iterdir() if not path.name.endswith(LOCK_SUFFIX)]


def _prepare(settings: Settings, folder: Path, fresh: bool) -> list[str]:
    """Bring the database about and return the companion's command line."""
    mark = folder / HISTORY_MARK
    if fresh or not mark.exists():
        # A first start that was interrupted left half a history: begin again rather than show it.
        for path in _contents(folder):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()
    migrate.upgrade(settings.database_url)
    engine = engines.create(settings)
    try:
        with_history = not is_seeded(engine)
        if with_history:
            typer.echo("Preparing the demonstration clinic (about a minute, the first time only) ...")
            seed_people(engine)
    finally:
        engine.dispose()
    words = [sys.executable, "-m", "app.demo.companion", "--server", settings.base_url]
    words += ["--database-url", settings.database_url]
    if with_history:
        words += ["--history-mark", str(mark)]
    return words
