"""Migrations: bring a database to the newest schema, or say that it is not there.

Both databases change their schema inside a transaction, so a migration that fails leaves the database as it
was.
"""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine, make_url, text

from app.database.engine import create_from_url
from app.errors import Conflict

SCRIPTS = Path(__file__).resolve().parents[2] / "migrations"


def upgrade(url: str, revision: str = "head") -> None:
    """Bring the database at a URL to a revision; creates a SQLite file that does not exist.

    Parameters
    ----------
    url : str
        As `Settings.database_url`.
    revision : str
        `head`, or the name of an earlier revision.
    """
    engine = create_from_url(url)
    try:
        upgrade_engine(engine, revision)
    finally:
        engine.dispose()


def upgrade_engine(engine: Engine, revision: str = "head") -> None:
    """Bring the database of an engine to a revision.

    Raises
    ------
    Conflict
        A newer version of the service has made the database.
    """
    found = current_revision(engine)
    if found is not None and not is_known(found):
        raise Conflict(
            f"The database is at revision {found}, which a newer version of the service has made; "
            "install that version, or restore a backup of this one.",
            found=found,
        )
    with engine.connect() as connection:
        _run(connection, revision, command.upgrade)


def downgrade(url: str, revision: str) -> None:
    """Take a database back to an earlier revision; what the later one stored is lost.

    Parameters
    ----------
    revision : str
        Name of an earlier revision, or `base` for an empty database.
    """
    engine = create_from_url(url)
    try:
        with engine.connect() as connection:
            _run(connection, revision, command.downgrade)
    finally:
        engine.dispose()


def current_revision(engine: Engine) -> str | None:
    """Return the revision that a database is at; None when it was never migrated."""
    with engine.connect() as connection:
        return MigrationContext.configure(connection).get_current_revision()


def newest_revision() -> str:
    """Return the revision that this version of the service needs."""
    head = ScriptDirectory(str(SCRIPTS)).get_current_head()
    if head is None:
        raise RuntimeError("the installation holds no migrations")
    return head


def is_known(revision: str) -> bool:
    """Return whether this version of the service has a migration of that name."""
    return any(script.revision == revision for script in ScriptDirectory(str(SCRIPTS)).walk_revisions())


def is_newest(url: str) -> bool:
    """Return whether the database at a URL has the schema of this version; nothing is created or changed.

    Parameters
    ----------
    url : str
        As `Settings.database_url`.
    """
    database = make_url(url).database if url.startswith("sqlite") else None
    if database is not None and not Path(database).exists():
        return False
    engine = create_from_url(url)
    try:
        return current_revision(engine) == newest_revision()
    finally:
        engine.dispose()


def require_newest(engine: Engine) -> None:
    """Refuse a database whose schema does not fit this version of the service.

    Raises
    ------
    Conflict
        The message says which command to run.
    """
    found, needed = current_revision(engine), newest_revision()
    if found != needed:
        raise Conflict(
            f"The database is at revision {found or 'none'}, this version needs {needed}; "
            "run `telemotion migrate` (after `telemotion backup`).",
            found=found,
            needed=needed,
        )


def _run(connection: Connection, revision: str, step: object) -> None:
    config = Config()
    config.set_main_option("script_location", str(SCRIPTS))
    config.attributes["connection"] = connection
    is_sqlite = connection.dialect.name == "sqlite"
    if is_sqlite:
        # Batch mode drops and renames tables; with enforcement on, dropping would delete the rows that refer
        # to them. The pragma does nothing inside a transaction, so it is set on the driver's connection
        # before one begins.
        _enforce_foreign_keys(connection, on=False)
    try:
        with connection.begin():
            step(config, revision)  # type: ignore[operator]
            if is_sqlite:
                broken = connection.execute(text("PRAGMA foreign_key_check")).fetchall()
                if broken:
                    raise RuntimeError(f"the migration leaves {len(broken)} rows that refer to nothing")
    finally:
        if is_sqlite:
            _enforce_foreign_keys(connection, on=True)


def _enforce_foreign_keys(connection: Connection, *, on: bool) -> None:
    driver = connection.connection.driver_connection
    if driver is None:
        raise RuntimeError("the database connection is closed")
    driver.execute(f"PRAGMA foreign_keys = {'ON' if on else 'OFF'}")
