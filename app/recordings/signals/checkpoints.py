"""Where the estimation of live sessions stands, as stored: one row a session, which goes when the session is closed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

from sqlalchemy import Connection, Engine, delete
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from app.database.base import utc_now
from app.database.unit_of_work import read_only
from app.recordings.models import LiveCheckpoint

_CHECKPOINTS: Final[Any] = LiveCheckpoint.__table__


@dataclass(frozen=True)
class Checkpoint:
    """What is stored of one; `app.live.session.checkpoint` reads and writes its bytes.

    Parameters
    ----------
    layout : int
        Of the data.
    sequence : int
        First packet that is not in it.
    """

    layout: int
    sequence: int
    data: bytes


def write_checkpoints(connection: Connection, checkpoints: Mapping[str, Checkpoint]) -> None:
    """Store checkpoints by session, in the place of earlier ones.

    Parameters
    ----------
    connection : Connection
        In a transaction that stores what came before them, or after one that did.
    checkpoints : mapping of str to Checkpoint
        Of sessions that are stored.
    """
    if not checkpoints:
        return
    now = utc_now()
    rows = [
        {
            "session_id": name,
            "layout": one.layout,
            "sequence": one.sequence,
            "data": one.data,
            "updated_at": now,
        }
        for name, one in checkpoints.items()
    ]
    connection.execute(_upsert(connection.dialect.name), rows)


@lru_cache
def _upsert(dialect_name: str) -> Any:
    dialect: Any = postgresql if dialect_name == "postgresql" else sqlite
    statement = dialect.insert(_CHECKPOINTS)
    changed = {name: statement.excluded[name] for name in ("layout", "sequence", "data", "updated_at")}
    return statement.on_conflict_do_update(index_elements=["session_id"], set_=changed)


def load_checkpoint(engine: Engine, session_id: str) -> Checkpoint | None:
    """Return where a session stood; None where nothing is known."""
    with read_only(engine) as session:
        found = session.get(LiveCheckpoint, session_id)
        return None if found is None else Checkpoint(found.layout, found.sequence, bytes(found.data))


def forget_checkpoints(session: Session, session_ids: Sequence[str]) -> None:
    """Delete the checkpoints of sessions that are closed."""
    session.execute(delete(LiveCheckpoint).where(LiveCheckpoint.session_id.in_(session_ids)))
