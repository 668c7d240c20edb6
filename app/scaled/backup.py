"""Backup and restore of the whole: the database, the register of what was ended for good, and of a service on many
machines what lies only in its streams.

Acknowledged packets that no worker has stored yet are in the streams alone. They are read first, then the database in
one view of it: what a worker stored and deleted from a stream in between is in that view, and what lies in both is left
out by the position that the view has. A restore puts the rest into empty streams.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import msgspec
from sqlalchemy import Connection, Engine, make_url, select, update

from app.accounts.audit_reading import note_ended
from app.database import backup as archives
from app.database import ended
from app.database import engine as engines
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict
from app.scaled.models import PartitionHold
from app.settings import Settings
from estimators.sentences import say

_ENTRY: Final = "stream."


def backup(engine: Engine, settings: Settings, path: Path) -> archives.Manifest:
    """Write everything to one file; the service may run meanwhile. See `app.database.backup.backup`.

    Raises
    ------
    InvalidInput
        Workers have held sessions of this database, and NATS cannot be reached.
    """
    register = ended.path_of(settings)
    note_ended(engine, register)
    more = {ended.ENTRY: ended.lines_of(register)}
    if not _has_partitions(engine):
        return archives.backup(engine, path, lambda _: more)
    # The client of NATS is of the extra `scaled`.
    from app.scaled.streams import read_all

    streams = read_all(settings)
    return archives.backup(engine, path, lambda connection: more | dict(_not_stored(connection, streams)))


def restore(path: Path, settings: Settings) -> archives.Manifest:
    """Fill an empty database from a backup, and empty streams where it has some; see `app.database.backup.restore`.

    Raises
    ------
    Conflict
        Something is in the database or the streams already, the number of partitions is another one, or nobody would
        read what was in streams: that needs workers.
    InvalidInput
        NATS cannot be reached.
    """
    manifest = archives.verify(path)
    names = _streams_of(manifest)
    if make_url(settings.database_url).get_backend_name() != "postgresql":
        if any(manifest.rows[name] for name in names):
            raise Conflict(say("scaled.unread_packets"))
        names = []
    if not names:
        return archives.restore(path, settings.database_url)
    if len(names) != settings.partitions:
        raise Conflict(say("scaled.other_partitions", count=len(names)))
    from app.scaled.streams import fill

    def prepare(positions: Sequence[int]) -> None:
        archives.restore(path, settings.database_url)
        _begin(settings, positions)

    contents = [
        (msgspec.msgpack.decode(row, type=bytes) for row in archives.rows_of(path, name)) for name in names
    ]
    fill(settings, contents, prepare)
    return manifest


def _has_partitions(engine: Engine) -> bool:
    with read_only(engine) as session:
        return session.scalar(select(PartitionHold.partition).limit(1)) is not None


def _streams_of(manifest: archives.Manifest) -> list[str]:
    count = sum(name.startswith(_ENTRY) for name in manifest.rows)
    return [f"{_ENTRY}{partition}" for partition in range(count)]


def _not_stored(
    connection: Connection, streams: Sequence[Sequence[tuple[int, bytes]]]
) -> Iterator[tuple[str, list[bytes]]]:
    rows = connection.execute(select(PartitionHold.partition, PartitionHold.position)).all()
    stored: dict[int, int] = {row[0]: row[1] for row in rows}
    for partition, messages in enumerate(streams):
        position = stored.get(partition, 0)
        if messages and messages[-1][0] < position and messages[0][0] == 1:
            # A stream that was made again begins at one, and no worker has looked at it yet: all of it is unread.
            position = 0
        unread = [msgspec.msgpack.encode(data) for number, data in messages if number > position]
        yield f"{_ENTRY}{partition}", unread


def _begin(settings: Settings, positions: Sequence[int]) -> None:
    """Have workers begin behind what streams numbered before, not where those of the backup stood."""
    engine = engines.create(settings)
    try:
        with unit_of_work(engine) as session:
            for partition, position in enumerate(positions):
                session.execute(
                    update(PartitionHold)
                    .where(PartitionHold.partition == partition)
                    .values(position=position)
                    .execution_options(synchronize_session=False)
                )
    finally:
        engine.dispose()
