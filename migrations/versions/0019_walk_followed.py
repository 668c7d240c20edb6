"""Store with the result of a walk the measures that progress follows, so that it reads these alone.

They are read from the walks that are there, some at a time. Where a stored walk is damaged there are none, and
progress leaves that session out.

Revision: 0019_walk_followed
After: 0018_comparison_measure.
"""

import json
import zlib
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0019_walk_followed"
down_revision = "0018_comparison_measure"
branch_labels = None
depends_on = None

_RESULTS = sa.table("result", sa.column("id"), sa.column("session_id"), sa.column("followed", sa.JSON()))
_CHUNKS = sa.table("signal_chunk", sa.column("session_id"), sa.column("stream"), sa.column("data"))
_AT_ONCE = 50
"""Walks are up to 100 kB each: not all of a clinic's at once."""


def upgrade() -> None:
    op.add_column("result", sa.Column("followed", sa.JSON(), nullable=True))
    connection = op.get_bind()
    keep = (
        sa.update(_RESULTS).where(_RESULTS.c.id == sa.bindparam("of")).values(followed=sa.bindparam("rows"))
    )
    last = ""
    while walks := connection.execute(_after(last)).all():
        last = walks[-1].id
        read = ((one.id, _followed(bytes(one.data))) for one in walks)
        kept = [{"of": of, "rows": rows} for of, rows in read if rows is not None]
        if kept:
            connection.execute(keep, kept)


def downgrade() -> None:
    op.drop_column("result", "followed")


def _after(last: str) -> sa.Select[Any]:
    return (
        sa.select(_RESULTS.c.id, _CHUNKS.c.data)
        .join(
            _CHUNKS,
            (_CHUNKS.c.session_id == _RESULTS.c.session_id)
            & (_CHUNKS.c.stream == sa.literal("gait/").concat(_RESULTS.c.id)),
        )
        .where(_RESULTS.c.id > last)
        .order_by(_RESULTS.c.id)
        .limit(_AT_ONCE)
    )


def _followed(data: bytes) -> list[list[Any]] | None:
    try:
        # What is no number here is none in PostgreSQL either.
        return _measures(json.loads(zlib.decompress(data), parse_constant=lambda _: None))
    except (zlib.error, ValueError, KeyError, TypeError, AttributeError):
        return None


def _measures(walk: dict[str, Any]) -> list[list[Any]]:
    found: dict[str, list[Any]] = {}
    test = walk.get("test") or {}
    if test.get("kind") == "timed_up_and_go":
        found["test_time"] = ["s", test["time_s"], None, 1]
    if test.get("kind") == "six_minute_walk":
        found["test_distance"] = ["metres", test["distance_m"], None, 1]
    parts = [
        (one, f"{one['measure']}:{foot['side']}") for foot in walk["feet"] for one in foot.get("measures", [])
    ]
    parts += [(one, f"uneven:{one['measure']}") for one in walk.get("asymmetry", [])]
    parts += [(one, one["measure"]) for one in walk.get("both", [])]
    parts += [(one, one["measure"]) for one in (walk.get("balance") or {}).get("measures", [])]
    found |= {name: [one["unit"], one["value"], one["spread"], one["count"]] for one, name in parts}
    return [[name, *one] for name, one in found.items() if one[1] is not None]
