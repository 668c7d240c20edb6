"""Uploaded files on their way into the database: who needs them, and that nobody else leaves one behind.

A file belongs to the task that reads it. Whoever ends that task for good, or deletes its session, removes the file;
what a crash leaves is found at the next start and every hour.
"""

import os
import time
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final

from sqlalchemy import Engine, Select, select
from sqlalchemy.orm import Session

from app.database.unit_of_work import after_commit, read_only
from app.recordings.models import Job
from app.settings import Settings

SWEEP_S: Final = 3600.0


def upload_folder(settings: Settings) -> Path:
    """Return the folder for files in passing, readable by the service only."""
    folder = settings.data_dir / "uploads"
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    return folder


def open_private(path: Path) -> BinaryIO:
    """Open a new file for writing that the service alone may read."""
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb")


def file_of(settings: Settings, arguments: dict[str, Any]) -> Path | None:
    """Return the file that a task with these arguments reads; None for a task without one."""
    name = arguments.get("file")
    return upload_folder(settings) / Path(name).name if isinstance(name, str) else None


def remove_file(settings: Settings, arguments: dict[str, Any]) -> None:
    """Remove the file of a task that has ended for good; nothing where it has none, or it is gone."""
    if (path := file_of(settings, arguments)) is not None:
        path.unlink(missing_ok=True)


def remove_files_of(session: Session, settings: Settings, session_ids: Select[Any]) -> None:
    """Remove the files of all tasks of some recordings once this unit of work, which deletes them, is committed.

    Parameters
    ----------
    session : Session
        Writing.
    session_ids : Select
        Of one column.
    """
    for arguments in session.scalars(select(Job.arguments).where(Job.session_id.in_(session_ids))):
        after_commit(session, partial(remove_file, settings, arguments))


def remove_orphans(engine: Engine, settings: Settings, older_than_s: float = 0.0) -> int:
    """Remove uploaded files that no unfinished task needs; called at the start of the service, and every hour.

    Parameters
    ----------
    older_than_s : float
        Where files are being received: longer than one takes.

    Returns
    -------
    int
        How many were removed.
    """
    newest_s = time.time() - older_than_s
    unfinished = select(Job.arguments).where(Job.status.in_(("queued", "running")))
    # Looked at before the tasks: a file that comes while they are read is not taken for one that nobody needs.
    found = [path for path in upload_folder(settings).iterdir() if path.stat().st_mtime <= newest_s]
    with read_only(engine) as session:
        wanted = {arguments.get("file") for arguments in session.scalars(unfinished)}
    orphans = [path for path in found if path.name not in wanted]
    for path in orphans:
        path.unlink(missing_ok=True)
    return len(orphans)
