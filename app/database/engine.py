"""Engine creation: SQLite by default, PostgreSQL by URL.

Durability, said plainly. SQLite runs in WAL mode with `synchronous=NORMAL`: a committed transaction is in the
operating system's page cache before `COMMIT` returns, so it survives the death of the process (SIGKILL,
crash, out of memory). A loss of power or a kernel panic may lose the transactions since the last checkpoint,
but never corrupts the file. A clinic that must survive power loss too sets
`TELEMOTION_DATABASE_DURABILITY=power_loss` (`synchronous=FULL`: one fsync a commit) or uses PostgreSQL, which
syncs every commit by default.

Transactions that may write take SQLite's single write lock at their start (`BEGIN IMMEDIATE`). A transaction
that reads first and asks for the lock later would be refused at once with "database is locked" when somebody
else wrote in between; waiting at the start with `busy_timeout` cannot deadlock.
"""

import contextlib
import os
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event, make_url
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.pool import ConnectionPoolEntry

from app.database import ended
from app.settings import Settings

BUSY_TIMEOUT_MS = 15_000
"""How long a writer waits for SQLite's write lock before it fails."""

CHECKPOINT_PATIENCE_MS = 500

POOL_SIZE = 16
MAX_OVERFLOW = 48
"""Together above the 40 threads of the request pool plus recorder, jobs and live runners."""


def create(settings: Settings) -> Engine:
    """Create the engine that the settings describe.

    Parameters
    ----------
    settings : Settings
        `database_url`, `database_durability` and `data_dir` are used.

    Returns
    -------
    Engine
        Not yet connected; dispose of it when the service stops. It knows the register of what is ended for good.
    """
    engine = create_from_url(settings.database_url, durability=settings.database_durability)
    engine.update_execution_options(**{ended.OPTION: ended.path_of(settings)})
    return engine


def create_from_url(url: str, *, durability: str = "process_death") -> Engine:
    """Create an engine for a database URL.

    Parameters
    ----------
    url : str
        `sqlite:///path`, or `postgresql://...` (psycopg 3 is used whatever driver is named).
    durability : {"process_death", "power_loss"}
        What a commit survives on SQLite; see the module text.

    Returns
    -------
    Engine
        With foreign keys enforced, and with the values of statements left out of error messages and logs:
        they are patient data.

    Notes
    -----
    The folder of a SQLite file is created here, readable by its owner only.
    """
    parsed = make_url(url)
    if parsed.get_backend_name() == "postgresql":
        return create_engine(
            parsed.set(drivername="postgresql+psycopg"),
            pool_size=POOL_SIZE,
            max_overflow=MAX_OVERFLOW,
            pool_pre_ping=True,
            hide_parameters=True,
        )
    if parsed.database and parsed.database != ":memory:":
        Path(parsed.database).parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    engine = create_engine(
        parsed,
        pool_size=POOL_SIZE,
        max_overflow=MAX_OVERFLOW,
        hide_parameters=True,
        connect_args={"check_same_thread": False, "timeout": BUSY_TIMEOUT_MS / 1000},
    )
    synchronous = "FULL" if durability == "power_loss" else "NORMAL"
    _prepare_sqlite(engine, parsed.database or "", synchronous=synchronous)
    return engine


def _prepare_sqlite(engine: Engine, database: str, *, synchronous: str) -> None:
    """Set the pragmas of each connection and begin transactions ourselves."""

    @event.listens_for(engine, "connect")
    def on_connect(connection: DBAPIConnection, _: ConnectionPoolEntry) -> None:
        # The driver must not begin transactions by itself: it would do so late and deferred.
        raw: Any = connection
        raw.isolation_level = None
        cursor = raw.cursor()
        for pragma in (
            f"busy_timeout = {BUSY_TIMEOUT_MS}",
            "journal_mode = WAL",
            f"synchronous = {synchronous}",
            "foreign_keys = ON",
            "temp_store = MEMORY",
            "cache_size = -4000",
            # What is erased is overwritten, not only unlinked.
            "secure_delete = ON",
        ):
            cursor.execute(f"PRAGMA {pragma}")
        cursor.close()
        for suffix in ("", "-wal", "-shm"):
            # Others' reading is taken away wherever the folder was; SQLite makes later files like the first.
            with contextlib.suppress(FileNotFoundError, PermissionError):
                os.chmod(f"{database}{suffix}", 0o600)

    @event.listens_for(engine, "begin")
    def on_begin(connection: Connection) -> None:
        if connection.get_execution_options().get("read_only"):
            connection.exec_driver_sql("PRAGMA query_only = ON")
            connection.exec_driver_sql("BEGIN")
        else:
            connection.exec_driver_sql("PRAGMA query_only = OFF")
            connection.exec_driver_sql("BEGIN IMMEDIATE")


def try_to_write(engine: Engine, patience_ms: int) -> None:
    """Commit the smallest change that there is; nothing that anybody reads becomes another.

    Parameters
    ----------
    patience_ms : int
        How long to wait for SQLite's write lock.

    Raises
    ------
    DBAPIError
        Nothing can be written: locked, full, read-only or not reachable.
    """
    if engine.dialect.name != "sqlite":
        with engine.connect() as connection:
            # A transaction with a number is written to the log of the server.
            connection.exec_driver_sql("SELECT txid_current()")
            connection.commit()
        return
    with engine.connect() as connection:
        driver: Any = connection.connection.driver_connection
        driver.execute(f"PRAGMA busy_timeout = {patience_ms}")
        try:
            connection.exec_driver_sql("PRAGMA user_version = 0")
            connection.commit()
        finally:
            driver.execute(f"PRAGMA busy_timeout = {BUSY_TIMEOUT_MS}")


def forget_deleted(engine: Engine) -> bool:
    """Empty SQLite's write-ahead log, which still holds pages as they were before something was erased.

    Parameters
    ----------
    engine : Engine
        Of a database from which something was erased and committed.

    Returns
    -------
    bool
        False when others read or wrote too long at that moment; the log is then reused from its beginning later.
        True on PostgreSQL, which cleans up by itself.
    """
    if engine.dialect.name != "sqlite":
        return True
    raw = engine.raw_connection()
    try:
        cursor = raw.cursor()
        # While the log waits for a long reader, writers wait too: not longer than they can bear.
        cursor.execute(f"PRAGMA busy_timeout = {CHECKPOINT_PATIENCE_MS}")
        try:
            (is_busy, _, _) = cursor.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
        finally:
            cursor.execute(f"PRAGMA busy_timeout = {BUSY_TIMEOUT_MS}")
            cursor.close()
    finally:
        raw.close()
    return not is_busy
