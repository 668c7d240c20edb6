"""Backup to one portable file and restore from it, on SQLite and PostgreSQL alike (and from one to the
other).

The file is a ZIP: `manifest.json` and one entry per table, its rows in the order of the primary key, each row
a length (u32, little endian) and a MessagePack array. It is read in one consistent transaction while the
service runs, checked after writing and then moved into place, so a file under its final name is always whole.
Browser sessions, tickets and pairing codes are left out: an old backup must not sign anybody in; so are counts of
failed sign-ins. It holds everything else, so it is as confidential as the database; only its owner may read it.

The manifest carries the head of each clinic's audit chain; with a manifest stored elsewhere a cut or rewritten
chain shows (`app.accounts.audit.verify`).
"""

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, date, datetime
from pathlib import Path
from typing import IO, Any

import msgspec
from sqlalchemy import (
    Boolean,
    Column,
    Connection,
    Date,
    DateTime,
    Engine,
    LargeBinary,
    MetaData,
    Table,
    func,
    inspect,
    select,
)

from app.database import migrate
from app.database.engine import create_from_url
from app.errors import Conflict, RecordingFormatError

FORMAT = "telemotion-backup"
FORMAT_VERSION = 1
LEFT_OUT = frozenset({"sign_in", "ticket", "pairing_code", "attempt_count", "alembic_version"})
_ROWS_AT_ONCE = 500
_ROW_LIMIT_BYTES = 1 << 30
_NOT_A_BACKUP = "This is not a whole backup of this service; take another one."


@dataclass(frozen=True)
class Manifest:
    """What a backup holds.

    Attributes
    ----------
    revision : str
        Of the schema.
    created_at : str
        ISO 8601, UTC.
    sha256 : dict of table to hexadecimal digest
    audit_heads : dict of clinic to (number, hash)
        Last event of each clinic's audit chain.
    """

    format: str
    format_version: int
    revision: str
    created_at: str
    rows: dict[str, int]
    sha256: dict[str, str]
    audit_heads: dict[str, tuple[int, str]]


More = Callable[[Connection], Mapping[str, Sequence[bytes]]]
"""Returns what is not in the database, as rows by name, asked within the view of the database that is written."""


def backup(engine: Engine, path: Path, more: More = lambda _: {}) -> Manifest:
    """Write everything to one file; the service may run meanwhile.

    Parameters
    ----------
    engine : Engine
        Migrated.
    path : Path
        Replaced when it exists.
    more : More, optional
        What belongs to it besides; read it with `rows_of`.

    Returns
    -------
    Manifest
        After the written file has been read again and found whole.
    """
    revision = migrate.current_revision(engine)
    if revision is None:
        raise Conflict("There is nothing to back up: this database was never migrated.")
    unfinished = path.with_name(path.name + ".unfinished")
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    try:
        with os.fdopen(descriptor, "wb") as file:
            with _snapshot(engine) as connection, zipfile.ZipFile(file, "w", allowZip64=True) as archive:
                manifest = _write(connection, archive, revision, more(connection))
            file.flush()
            os.fsync(file.fileno())
        verify(unfinished)
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
    return manifest


def verify(path: Path) -> Manifest:
    """Read a whole backup and check every row count and digest.

    Raises
    ------
    RecordingFormatError
        Not a backup, cut off or changed.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            manifest = _manifest(archive)
            for table, expected in manifest.rows.items():
                with archive.open(_entry(table)) as stream:
                    digest, count = hashlib.sha256(), 0
                    for row in _rows(stream):
                        digest.update(row)
                        count += 1
                if count != expected or digest.hexdigest() != manifest.sha256.get(table):
                    raise RecordingFormatError(_NOT_A_BACKUP, table=table)
    except (zipfile.BadZipFile, KeyError, EOFError, OSError) as error:
        raise RecordingFormatError(_NOT_A_BACKUP) from error
    return manifest


def restore(path: Path, url: str) -> Manifest:
    """Fill an empty database from a backup and bring it to the newest schema.

    Parameters
    ----------
    url : str
        Of a database that does not exist yet (SQLite) or holds no tables (PostgreSQL).

    Raises
    ------
    Conflict
        The database holds something already.
    RecordingFormatError
        The backup is not whole, or of a newer version of the service.
    """
    manifest = verify(path)
    engine = create_from_url(url)
    try:
        if inspect(engine).get_table_names():
            raise Conflict("The database to restore to is not empty; move it away or name another one.")
        if not migrate.is_known(manifest.revision):
            raise RecordingFormatError(
                "This backup was made by a newer version of the service; install that version.",
                revision=manifest.revision,
            )
        migrate.upgrade_engine(engine, manifest.revision)
        with engine.begin() as connection, zipfile.ZipFile(path) as archive:
            _read(connection, archive, manifest)
        migrate.upgrade_engine(engine)
    finally:
        engine.dispose()
    return manifest


def rows_of(path: Path, name: str) -> Iterator[bytes]:
    """Yield the rows of one table, or of what was written besides.

    Parameters
    ----------
    path : Path
        Of a backup that was found whole.
    """
    with zipfile.ZipFile(path) as archive, archive.open(_entry(name)) as stream:
        yield from _rows(stream)


class _snapshot:  # noqa: N801 - used like a function
    """One consistent view of the whole database."""

    def __init__(self, engine: Engine) -> None:
        options: dict[str, Any] = {"read_only": True}
        if engine.dialect.name == "postgresql":
            options |= {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
        self._connection = engine.execution_options(**options).connect()

    def __enter__(self) -> Connection:
        return self._connection.__enter__()

    def __exit__(self, *error: Any) -> None:
        self._connection.__exit__(*error)


def _write(
    connection: Connection, archive: zipfile.ZipFile, revision: str, more: Mapping[str, Sequence[bytes]]
) -> Manifest:
    rows: dict[str, int] = {}
    digests: dict[str, str] = {}
    tables = _tables(connection)
    for table in tables:
        # Signals are compressed already.
        has_blobs = any(isinstance(column.type, LargeBinary) for column in table.columns)
        found = _write_rows(archive, table.name, _encoded_rows(connection, table), is_compressed=has_blobs)
        rows[table.name], digests[table.name] = found
    for name, content in more.items():
        rows[name], digests[name] = _write_rows(archive, name, content, is_compressed=True)
    manifest = Manifest(
        format=FORMAT,
        format_version=FORMAT_VERSION,
        revision=revision,
        created_at=datetime.now(UTC).isoformat(timespec="seconds"),
        rows=rows,
        sha256=digests,
        audit_heads=_audit_heads(connection, {table.name: table for table in tables}),
    )
    archive.writestr("manifest.json", json.dumps(asdict(manifest), indent=1))
    return manifest


def _write_rows(
    archive: zipfile.ZipFile, name: str, rows: Iterable[bytes], *, is_compressed: bool
) -> tuple[int, str]:
    """Write one entry; return how many rows it has and their digest."""
    entry = zipfile.ZipInfo(_entry(name), date_time=(1980, 1, 1, 0, 0, 0))
    entry.compress_type = zipfile.ZIP_STORED if is_compressed else zipfile.ZIP_DEFLATED
    digest, count = hashlib.sha256(), 0
    with archive.open(entry, "w", force_zip64=True) as stream:
        for row in rows:
            stream.write(len(row).to_bytes(4, "little"))
            stream.write(row)
            digest.update(row)
            count += 1
    return count, digest.hexdigest()


def _read(connection: Connection, archive: zipfile.ZipFile, manifest: Manifest) -> None:
    is_sqlite = connection.dialect.name == "sqlite"
    for table in _tables(connection):
        columns = list(table.columns)
        batch: list[dict[str, Any]] = []
        with archive.open(_entry(table.name)) as stream:
            for row in _rows(stream):
                batch.append(_decoded(columns, msgspec.msgpack.decode(row), is_sqlite))
                if len(batch) >= _ROWS_AT_ONCE:
                    connection.execute(table.insert(), batch)
                    batch = []
        if batch:
            connection.execute(table.insert(), batch)
        found = connection.scalar(select(func.count()).select_from(table))
        if found != manifest.rows[table.name]:
            raise RecordingFormatError(_NOT_A_BACKUP, table=table.name)
        if not is_sqlite and "id" in table.c and table.c.id.type.python_type is int:
            # Rows came with their numbers; the next one must be higher.
            highest = select(func.coalesce(func.max(table.c.id), 1)).scalar_subquery()
            connection.execute(select(func.setval(func.pg_get_serial_sequence(table.name, "id"), highest)))


def _tables(connection: Connection) -> list[Table]:
    """Return the tables as they are in the database, whatever version made it, parents before children."""
    metadata = MetaData()
    metadata.reflect(connection)
    return [table for table in metadata.sorted_tables if table.name not in LEFT_OUT]


def _encoded_rows(connection: Connection, table: Table) -> Iterator[bytes]:
    query = select(table).order_by(*table.primary_key.columns)
    streamed = connection.execution_options(yield_per=_ROWS_AT_ONCE).execute(query)
    for row in streamed:
        yield msgspec.msgpack.encode([_plain(value) for value in row])


def _plain(value: Any) -> Any:
    if isinstance(value, datetime):
        zoned = value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)
        return zoned.isoformat(timespec="microseconds")
    if isinstance(value, date):
        return value.isoformat()
    return bytes(value) if isinstance(value, memoryview) else value


def _decoded(columns: list[Column[Any]], values: list[Any], is_sqlite: bool) -> dict[str, Any]:
    if len(values) != len(columns):
        raise RecordingFormatError(_NOT_A_BACKUP)
    return {
        column.name: _typed(column, value, is_sqlite) for column, value in zip(columns, values, strict=True)
    }


def _typed(column: Column[Any], value: Any, is_sqlite: bool) -> Any:
    if value is None:
        return None
    if isinstance(column.type, DateTime):
        moment = datetime.fromisoformat(value)
        return moment.replace(tzinfo=None) if is_sqlite else moment
    if isinstance(column.type, Date):
        return date.fromisoformat(value)
    return bool(value) if isinstance(column.type, Boolean) else value


def _rows(stream: IO[bytes]) -> Iterator[bytes]:
    while prefix := stream.read(4):
        length = int.from_bytes(prefix, "little")
        if len(prefix) < 4 or length > _ROW_LIMIT_BYTES:
            raise EOFError("a row is cut off")
        row = stream.read(length)
        if len(row) < length:
            raise EOFError("a row is cut off")
        yield row


def _manifest(archive: zipfile.ZipFile) -> Manifest:
    try:
        manifest = msgspec.json.decode(archive.read("manifest.json"), type=Manifest)
    except msgspec.DecodeError as error:
        raise RecordingFormatError(_NOT_A_BACKUP) from error
    if manifest.format != FORMAT or manifest.format_version != FORMAT_VERSION:
        raise RecordingFormatError(_NOT_A_BACKUP, format_version=manifest.format_version)
    return manifest


def _audit_heads(connection: Connection, tables: dict[str, Table]) -> dict[str, tuple[int, str]]:
    events = tables.get("audit_event")
    if events is None:
        return {}
    last = (
        select(events.c.clinic_id, func.max(events.c.number).label("number"))
        .group_by(events.c.clinic_id)
        .subquery()
    )
    rows = connection.execute(
        select(events.c.clinic_id, events.c.number, events.c.hash).join(
            last, (last.c.clinic_id == events.c.clinic_id) & (last.c.number == events.c.number)
        )
    )
    return {clinic: (number, digest) for clinic, number, digest in rows}


def _entry(table: str) -> str:
    return f"tables/{table}"
