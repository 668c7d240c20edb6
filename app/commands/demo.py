"""`telemotion demo`: the service with an invented clinic, and a patient who streams live."""

import http.client
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Final

import typer

from app.commands.options.starting import DemoOptions
from app.commands.serve import claim, run
from app.database.writer_lock import LOCK_SUFFIX
from app.demo.people import PASSWORD, PATIENTS, THERAPIST, prepare
from app.edge.demonstration import HistoryProgress
from app.errors import InvalidInput
from app.settings import Settings
from estimators.compiling import why_unused

_ANSWER_POLL_S: Final = 0.1
HISTORY_COMES: Final = "  Past sessions are being made; they appear one after the other."


def demo(options: DemoOptions) -> None:
    """Prepare the demonstration's people, start its companions, and serve."""
    port, folder, started_s = options.port, options.folder, options.started_s or time.time()
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
        _empty_unless_begun(folder, options.fresh)
        progress = prepare(settings.database_url, folder)
        commands = companions(server, started_s, progress, settings.database_url, stream=options.stream)
        running = [subprocess.Popen(words) for words in commands]  # noqa: S603 - our own interpreter and module
        threading.Thread(
            target=_welcome, args=(port, server, started_s, options.stream, progress.is_complete), daemon=True
        ).start()
        try:
            run(settings, listener, lock)
        finally:
            for one in running:
                one.terminate()
            for one in running:
                one.wait(timeout=10)


def _contents(folder: Path) -> list[Path]:
    """Return what is in a demonstration's folder, without the lock, which must stay while it is held."""
    return [path for path in folder.iterdir() if not path.name.endswith(LOCK_SUFFIX)]


def _empty_unless_begun(folder: Path, fresh: bool) -> None:
    """Throw away what a folder holds where that is asked for, or where it was left by an interrupted start."""
    if fresh or HistoryProgress.of(folder) is None:
        # Without a word of how far its history is, it was left by an interrupted start of an earlier version.
        for path in _contents(folder):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()


def companions(
    server: str, started_s: float, progress: HistoryProgress, url: str, *, stream: bool = True
) -> list[list[str]]:
    """Return the commands of the processes that play the demonstration's patients.

    Parameters
    ----------
    server : str
        Where they reach the service.
    started_s : float
        Since the epoch: from when what they print is timed.
    progress : HistoryProgress
        Of the past sessions; what is missing of them is made.
    url : str
        Of the database.
    stream : bool
        Whether a patient streams live.
    """
    common = [sys.executable, "-m", "app.demo.companion", "--server", server, "--started-s", str(started_s)]
    found = []
    # Two processes: making history takes all the time it gets, and must take none from the patient who streams.
    if stream:
        found.append([*common, "--stream"])
    if not progress.is_complete:
        found.append([*common, "--history", str(progress.path.parent), "--database-url", url])
    return found


def _welcome(port: int, server: str, started_s: float, with_stream: bool, is_complete: bool) -> None:
    """Print the address as soon as it answers."""
    while not answers(port):
        time.sleep(_ANSWER_POLL_S)
    person = PATIENTS[0]
    lines = [
        "",
        f"  Telemotion demonstration:  {server}   (answers after {time.time() - started_s:.0f} s)",
        "",
        f"    therapist   {THERAPIST}   password  {PASSWORD}",
        f"    patient     {person.email}       password  {PASSWORD}",
        "",
    ]
    if with_stream:
        lines.append(f"  {person.given_name} {person.family_name} streams live: sign in and open her row.")
    if not is_complete:
        lines.append(HISTORY_COMES)
    if why := why_unused():
        lines.append(
            f"  Kernels are compiled here, which takes minutes; those that came with the package do not fit: {why}."
        )
    lines.append("  Ctrl-C stops it. Everything here is invented; never use it with real patients.")
    typer.echo("\n".join([*lines, ""]))


def answers(port: int) -> bool:
    """Return whether a service answers at a port of this machine."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=5.0)
    try:
        connection.request("GET", "/api/health")
        return connection.getresponse().status == http.HTTPStatus.OK
    except OSError:
        return False
    finally:
        connection.close()
