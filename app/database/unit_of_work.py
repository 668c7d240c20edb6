"""Units of work: one request, message or task is one transaction; services never commit.

Two types keep reading and writing apart. A `ReadOnlySession` refuses to flush changes, and the database
refuses them too; reading never waits for a writer. A `WritableSession` holds SQLite's one write lock from its
first statement, so it must be short: no estimation, no network, no waiting inside.

Work that has to happen in the transaction of a commit (the audit trail) is registered with `before_commit`.
In a read-only unit the same work is done right after the reading, in a short writing transaction of its own,
and before the caller gets its answer: an answer that could not be audited is not given.
"""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from sqlalchemy import Engine
from sqlalchemy.orm import Session

logger = logging.getLogger(__name__)

_PENDING = "before_commit"
_AFTERWARDS = "after_commit"

Finisher = Callable[[Session, list[Any]], None]


class WritableSession(Session):
    """A session that may change the database."""


class ReadOnlySession(Session):
    """A session that only reads; a flush with changes is a programming error."""

    def flush(self, objects: Any = None) -> None:
        """Refuse changes.

        Raises
        ------
        RuntimeError
            When anything was added, changed or deleted.
        """
        if self.new or self.deleted or any(self.is_modified(item) for item in self.dirty):
            raise RuntimeError("this unit of work only reads; use a writing unit of work")
        super().flush(objects)


@contextmanager
def unit_of_work(engine: Engine) -> Iterator[WritableSession]:
    """Open a writing transaction; commit on success, roll back on any error.

    Parameters
    ----------
    engine : Engine
        From `app.database.engine.create`.

    Yields
    ------
    WritableSession
        Objects stay readable after the commit (`expire_on_commit` is off).
    """
    with WritableSession(engine, expire_on_commit=False) as session:
        try:
            yield session
            session.flush()
            _run_pending(session, session.info.pop(_PENDING, {}))
            session.commit()
        except BaseException:
            session.rollback()
            raise
        for action in session.info.pop(_AFTERWARDS, []):
            try:
                action()
            except OSError:
                # What was committed stands; whoever left something behind looks for it again, `remove_orphans`.
                logger.exception("what follows a commit failed")


@contextmanager
def read_only(engine: Engine) -> Iterator[ReadOnlySession]:
    """Open a reading transaction: one consistent view, no lock, no changes.

    Parameters
    ----------
    engine : Engine
        From `app.database.engine.create`.

    Yields
    ------
    ReadOnlySession
        Closed at the end; pending work (audit) is then written in its own transaction.
    """
    reader = engine.execution_options(read_only=True, **_postgresql_read_only(engine))
    with ReadOnlySession(reader, expire_on_commit=False) as session:
        yield session
        pending = session.info.pop(_PENDING, {})
    if pending:
        with unit_of_work(engine) as writer:
            _run_pending(writer, pending)


def before_commit(session: Session, finisher: Finisher, item: Any) -> None:
    """Hand `item` to `finisher` in the transaction that ends this unit of work.

    Parameters
    ----------
    session : Session
        Of `unit_of_work` or `read_only`.
    finisher : callable(session, items)
        Called once with all items of this unit, in order.
    item : object
        What to finish.
    """
    pending: dict[Finisher, list[Any]] = session.info.setdefault(_PENDING, {})
    pending.setdefault(finisher, []).append(item)


def after_commit(session: Session, action: Callable[[], None]) -> None:
    """Do something outside of the database once this unit of work is committed; nothing if it is not.

    Parameters
    ----------
    session : Session
        Of `unit_of_work`.
    action : callable()
        An `OSError` is logged: what is stored is stored.
    """
    session.info.setdefault(_AFTERWARDS, []).append(action)


def _run_pending(session: Session, pending: dict[Finisher, list[Any]]) -> None:
    for finisher, items in pending.items():
        finisher(session, items)


def _postgresql_read_only(engine: Engine) -> dict[str, Any]:
    return {"postgresql_readonly": True} if engine.dialect.name == "postgresql" else {}
