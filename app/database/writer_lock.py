"""One writer a database: the lock that a service, a migration or a restore holds before it touches anything.

Two services on one database would take each other's live sessions, uploads and tasks for abandoned. On SQLite the
lock is an operating system's lock on a file beside the database, on PostgreSQL a session-level advisory lock on a
connection of its own. Both die with their process, however it ends, and both say who holds them. Short transactions of
other commands (`create-clinic`, `backup`, `reprocess`, `audit-verify`) need no lock and run beside a service.

The file lock needs a file system that knows `flock`, and the advisory lock a direct connection: a pooler that shares
connections between transactions would lose it.
"""

import contextlib
import fcntl
import os
import secrets
import socket
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import psycopg
from sqlalchemy import URL, make_url

from app.database.base import utc_now
from app.errors import Conflict, InvalidInput, TelemotionError, Unavailable

LOCK_SUFFIX: Final = ".writer"
_ADVISORY_KEY: Final = 7_305_792_114_563_087
"""Any number, the same in every version; PostgreSQL keeps such locks apart by database."""
_NAME_BYTES: Final = 63
"""PostgreSQL keeps so much of an application's name."""
_CONNECT: Final[dict[str, Any]] = {
    "connect_timeout": 3,
    "keepalives_idle": 5,
    "keepalives_interval": 2,
    "keepalives_count": 3,
    "tcp_user_timeout": 5000,
    "options": "-c tcp_keepalives_idle=10 -c tcp_keepalives_interval=5 -c tcp_keepalives_count=3"
    " -c statement_timeout=3000",
}
"""A host that is gone is noticed on both ends within half a minute, and its lock is free then."""


class DatabaseInUse(Conflict):
    """Another process holds the database."""


class WriterLock(ABC):
    """The right to write one database; `writer_lock` makes one.

    Parameters
    ----------
    purpose : str
        What it is held for, e.g. `telemotion serve`.
    address : str
        Where the holder answers; empty when nowhere.

    Attributes
    ----------
    on_taken_over : callable or None
        Called with a sentence when the lock was lost and somebody else holds it: this process must not write again.
    """

    def __init__(self, purpose: str, address: str) -> None:
        self.purpose = purpose
        self.address = address
        self.on_taken_over: Callable[[str], None] | None = None

    @abstractmethod
    def take(self) -> None:
        """Take the lock or refuse at once.

        Raises
        ------
        DatabaseInUse
            Somebody else holds it; the message names them.
        InvalidInput, Unavailable
            The database cannot be reached.
        """

    @abstractmethod
    def release(self) -> None:
        """Give the lock back; nothing when it is not held."""

    @abstractmethod
    def _is_alive(self) -> bool:
        """Whether what was taken is still held; asks the operating system or the database."""

    def trouble(self) -> str | None:
        """Return why the lock is not held, None while it is; takes it again when it is free.

        Blocks for some seconds when the database does not answer, so not on an event loop.
        """
        if self._is_alive():
            return None
        self.release()
        try:
            self.take()
        except DatabaseInUse as error:
            if self.on_taken_over is not None:
                self.on_taken_over(error.message)
            return error.message
        except TelemotionError as error:
            return error.message
        return None

    def __enter__(self) -> "WriterLock":
        self.take()
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


class _FileLock(WriterLock):
    """`flock` on a file beside a SQLite database; the file stays, only the lock ends."""

    def __init__(self, database: Path, purpose: str, address: str) -> None:
        super().__init__(purpose, address)
        # One database has one lock, whatever link it is opened by.
        self._path = Path(f"{database.resolve()}{LOCK_SUFFIX}")
        self._database = database
        self._file: int | None = None

    def take(self) -> None:
        if self._file is not None:
            return
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise InvalidInput(
                f"The database {self._database} cannot be opened ({error.strerror}); "
                "name a folder that may be written in TELEMOTION_DATABASE_URL."
            ) from error
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            holder = os.pread(file, 1000, 0).decode("utf-8", "replace").strip()
            os.close(file)
            raise _in_use(str(self._database), holder) from error
        words = f"{self.purpose}, process {os.getpid()} on {socket.gethostname()}"
        words += f", at {self.address}" if self.address else ""
        words += f", since {utc_now():%Y-%m-%d %H:%M:%S} UTC"
        os.ftruncate(file, 0)
        os.pwrite(file, words.encode(), 0)
        self._file = file

    def release(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            os.ftruncate(file, 0)
            os.close(file)

    def _is_alive(self) -> bool:
        if self._file is None:
            return False
        try:
            # Somebody who removed the folder and made another one has another lock.
            return os.path.samestat(os.stat(self._path), os.fstat(self._file))
        except OSError:
            return False


class _AdvisoryLock(WriterLock):
    """A session-level advisory lock of PostgreSQL; its holder is named by the name of the connection."""

    def __init__(
        self, url: URL, purpose: str, address: str, key: int = _ADVISORY_KEY, *, is_shared: bool = False
    ) -> None:
        super().__init__(purpose, address)
        self._url = url
        self._key = key
        self._try = "pg_try_advisory_lock_shared" if is_shared else "pg_try_advisory_lock"
        self._connection: psycopg.Connection[Any] | None = None

    def take(self) -> None:
        if self._connection is not None:
            return
        place = URL.create(
            "postgresql", host=self._url.host, port=self._url.port, database=self._url.database
        ).render_as_string()
        try:
            self._connection = self._connect()
            row = self._connection.execute(f"SELECT {self._try}(%s)".encode(), [self._key]).fetchone()
            if row is not None and row[0]:
                return
            holder = self._holder(self._connection, self._key)
        except psycopg.Error as error:
            self.release()
            reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
            raise Unavailable(
                f"The database {place} cannot be reached: {reason}. Check TELEMOTION_DATABASE_URL and whether "
                "PostgreSQL runs."
            ) from error
        self.release()
        raise _in_use(place, holder)

    def _connect(self) -> psycopg.Connection[Any]:
        plain = self._url.set(drivername="postgresql").render_as_string(hide_password=False)
        name = f"{self.purpose}, process {os.getpid()} on {socket.gethostname()[:20]}, {self.address}"
        short = name.rstrip(", ").encode()[:_NAME_BYTES].decode("utf-8", "ignore")
        return psycopg.connect(plain, autocommit=True, application_name=short, **_CONNECT)

    @staticmethod
    def _holder(connection: psycopg.Connection[Any], key: int) -> str:
        row = connection.execute(
            "SELECT application_name, client_addr::text, to_char(backend_start AT TIME ZONE 'UTC',"
            " 'YYYY-MM-DD HH24:MI:SS') FROM pg_locks JOIN pg_stat_activity USING (pid)"
            " WHERE locktype = 'advisory' AND granted AND objsubid = 1"
            " AND database = (SELECT oid FROM pg_database WHERE datname = current_database())"
            " AND (classid::bigint << 32) + objid::bigint = %s",
            [key],
        ).fetchone()
        if row is None:
            return ""
        words = str(row[0] or "another process")
        words += f", connected from {row[1]}" if row[1] else ""
        return f"{words}, since {row[2]} UTC"

    def release(self) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            # The server notices a closed connection a moment later: the next client would find the lock held.
            with contextlib.suppress(psycopg.Error):
                connection.execute("SELECT pg_advisory_unlock_all()")
            connection.close()

    def _is_alive(self) -> bool:
        if self._connection is None:
            return False
        try:
            self._connection.execute("SELECT 1")
        except psycopg.Error:
            return False
        return True


def writer_lock(url: str, purpose: str, address: str = "") -> WriterLock:
    """Return the lock of the database at a URL, not yet taken.

    Parameters
    ----------
    url : str
        As `Settings.database_url`.
    purpose : str
        What it is held for; others read it.
    address : str
        Where the holder answers.
    """
    parsed = make_url(url)
    if parsed.get_backend_name() == "postgresql":
        return _AdvisoryLock(parsed, purpose, address)
    return _FileLock(Path(parsed.database or ""), purpose, address)


def shared_lock(url: str, purpose: str, address: str = "") -> WriterLock:
    """Return the lock that edges and workers of one database hold together, apart from a service in one process.

    Parameters
    ----------
    url, purpose, address
        As of `writer_lock`.

    Raises
    ------
    InvalidInput
        The database is not PostgreSQL.
    """
    return _AdvisoryLock(_postgresql(url), purpose, address, is_shared=True)


class RunnerLock(_AdvisoryLock):
    """Says that a runner of long tasks lives; others see by its key, stored with what it runs, that it does not.

    Parameters
    ----------
    url : str
        As `Settings.database_url`.

    Raises
    ------
    InvalidInput
        The database is not PostgreSQL.

    Attributes
    ----------
    key : str
        No other runner has it.
    """

    def __init__(self, url: str, purpose: str) -> None:
        super().__init__(_postgresql(url), purpose, "", secrets.randbits(62))
        self.key = str(self._key)

    @contextlib.contextmanager
    def ended(self, key: str) -> Iterator[bool]:
        """Yield whether the runner of a key has ended; while this is so, nobody else finds the same."""
        connection, number = self._connection, int(key)
        if connection is None or number == self._key:
            yield False
            return
        try:
            row = connection.execute(b"SELECT pg_try_advisory_lock(%s)", [number]).fetchone()
        except psycopg.Error:
            # Whether this one still lives is looked at elsewhere.
            yield False
            return
        has_ended = row is not None and bool(row[0])
        try:
            yield has_ended
        finally:
            if has_ended:
                with contextlib.suppress(psycopg.Error):
                    connection.execute(b"SELECT pg_advisory_unlock(%s)", [number])


def _postgresql(url: str) -> URL:
    parsed = make_url(url)
    if parsed.get_backend_name() != "postgresql":
        raise InvalidInput(
            "Edges and workers need PostgreSQL: set TELEMOTION_DATABASE_URL to postgresql://user:password@host/name."
        )
    return parsed


def _in_use(place: str, holder: str) -> DatabaseInUse:
    return DatabaseInUse(
        f"The database {place} is in use by {holder or 'another process'}. One service at a time may write it: "
        "stop that one first, or name another database in TELEMOTION_DATABASE_URL.",
        holder=holder,
    )
