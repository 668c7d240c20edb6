"""Nobody but the service's own account reads its folder and database, however they were made."""

import os
import stat
from pathlib import Path
from typing import Final

from sqlalchemy import make_url

from app.database.writer_lock import LOCK_SUFFIX
from app.errors import InvalidInput
from app.settings import Settings

_OF_OTHERS: Final = stat.S_IRWXG | stat.S_IRWXO
_ROOT: Final = 0
_OF_A_NEW_DISK: Final = "lost+found"


def make_private(settings: Settings) -> None:
    """Take every right of other accounts away from the data folder and the database's files; nothing on Windows.

    Parameters
    ----------
    settings : Settings
        `data_dir` and `database_url` are used. The folder is made when there is none.

    Raises
    ------
    InvalidInput
        Others can read, and this account may not change that, or should not: the folder is not the service's own.
    """
    if os.name != "posix":
        return
    parsed = make_url(settings.database_url)
    is_file = parsed.get_backend_name() == "sqlite" and parsed.database not in (None, "", ":memory:")
    database = Path(str(parsed.database)) if is_file else None
    folder = settings.data_dir
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    if _is_open(folder):
        _check_own(folder, database)
        _close(folder, 0o700)
    if database is not None:
        # What SQLite makes beside it later gets the same rights.
        for path in (database, Path(f"{database}-wal"), Path(f"{database}-shm")):
            if path.exists() and _is_open(path):
                _close(path, 0o600)


def _is_open(path: Path) -> bool:
    return bool(path.stat().st_mode & _OF_OTHERS)


def _check_own(folder: Path, database: Path | None) -> None:
    """Refuse a folder that others use too: `/tmp`, or what root owns for the whole machine."""
    is_shared = bool(folder.stat().st_mode & stat.S_ISVTX)
    if os.geteuid() == _ROOT and not is_shared:
        # Root may close every folder, `/var/lib` too. It is the service's own when its files are in it.
        found = {path.name for path in folder.iterdir()}
        own = {"uploads"} if database is None else {"uploads", database.name}
        lock = "" if database is None else f"{database.name}{LOCK_SUFFIX}"
        is_shared = bool(found - {lock, _OF_A_NEW_DISK}) and not found & own
    if is_shared:
        raise InvalidInput(
            f"The data folder {folder} can be read by other accounts of this machine and holds other things too."
            " Set TELEMOTION_DATA_DIR to a folder of its own."
        )


def _close(path: Path, mode: int) -> None:
    try:
        path.chmod(mode)
    except PermissionError as error:
        raise InvalidInput(
            f"{path} can be read by other accounts of this machine, and this account may not change that."
            f" Let its owner run: chmod {mode:o} {path}"
        ) from error
