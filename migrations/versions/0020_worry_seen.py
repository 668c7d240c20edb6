"""Keep which worries a therapist has seen, and with each comparison its largest compensation.

What is older than four weeks was shown, or hidden by what followed, long ago: pain of that time counts as seen, by
nobody in particular, and compensation of that time is not asked about. What is newer waits for a therapist.

Revision: 0020_worry_seen
After: 0019_walk_followed.
"""

import json
import math
import uuid
from datetime import UTC, datetime, timedelta
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0020_worry_seen"
down_revision = "0019_walk_followed"
branch_labels = None
depends_on = None

_WHEN = sa.DateTime(timezone=True)
_EVENTS = sa.table(
    "session_event", sa.column("session_id"), sa.column("kind"), sa.column("created_at", _WHEN)
)
_ANSWERS = sa.table(
    "session_answers",
    sa.column("session_id"),
    sa.column("pain"),
    sa.column("most_pain"),
    sa.column("answered_at", _WHEN),
)
_COMPARISONS = sa.table(
    "comparison",
    sa.column("id"),
    sa.column("created_at", _WHEN),
    sa.column("summary", sa.JSON()),
    sa.column("compensation", sa.JSON()),
)
_SEEN = sa.table(
    "worry_seen",
    sa.column("id"),
    sa.column("created_at", _WHEN),
    sa.column("session_id"),
    sa.column("kind"),
    sa.column("known_until", _WHEN),
    sa.column("seen_by"),
)
_NEW = timedelta(days=28)


def upgrade() -> None:
    op.create_table(
        "worry_seen",
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("kind", sa.String(length=20), nullable=False),
        sa.Column("known_until", _WHEN, nullable=False),
        sa.Column("seen_by", sa.String(length=32), nullable=False),
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", _WHEN, nullable=False),
        sa.ForeignKeyConstraint(
            ["session_id"],
            ["motion_session.id"],
            name=op.f("fk_worry_seen_session_id_motion_session"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_worry_seen")),
    )
    op.create_index(op.f("ix_worry_seen_session_id"), "worry_seen", ["session_id"])
    op.create_index(op.f("ix_session_event_session_id_kind"), "session_event", ["session_id", "kind"])
    op.drop_index(op.f("ix_session_event_session_id"), "session_event")
    op.add_column("session_answers", sa.Column("most_pain", sa.Integer(), nullable=True))
    op.add_column("comparison", sa.Column("compensation", sa.JSON(), nullable=True))
    connection, since = op.get_bind(), datetime.now(UTC) - _NEW
    connection.execute(sa.update(_ANSWERS).values(most_pain=_ANSWERS.c.pain))
    _mark_old_pain(connection, since)
    _find_compensation(connection, since)


def downgrade() -> None:
    op.drop_column("comparison", "compensation")
    op.drop_column("session_answers", "most_pain")
    op.create_index(op.f("ix_session_event_session_id"), "session_event", ["session_id"])
    op.drop_index(op.f("ix_session_event_session_id_kind"), "session_event")
    op.drop_table("worry_seen")


def _mark_old_pain(connection: sa.Connection, since: datetime) -> None:
    stopped = ("pain", "guidance_stop", "guidance_pause")
    events = sa.select(_EVENTS.c.session_id, _EVENTS.c.kind).where(
        _EVENTS.c.kind.in_(stopped), _EVENTS.c.created_at < since
    )
    answers = sa.select(_ANSWERS.c.session_id).where(_ANSWERS.c.pain >= 5, _ANSWERS.c.answered_at < since)
    old = {
        (session_id, "pain" if kind == "pain" else "stop") for session_id, kind in connection.execute(events)
    }
    old |= {(session_id, "pain") for (session_id,) in connection.execute(answers)}
    now = datetime.now(UTC)
    rows = [
        {
            "id": uuid.uuid4().hex,
            "created_at": now,
            "session_id": session_id,
            "kind": kind,
            "known_until": since,
            "seen_by": "",
        }
        for session_id, kind in sorted(old)
    ]
    if rows:
        connection.execute(sa.insert(_SEEN), rows)


def _find_compensation(connection: sa.Connection, since: datetime) -> None:
    new = sa.select(_COMPARISONS.c.id, _COMPARISONS.c.summary).where(_COMPARISONS.c.created_at >= since)
    for comparison_id, summary in connection.execute(new).all():
        found = _largest(summary if isinstance(summary, dict) else json.loads(summary))
        if found is not None:
            connection.execute(
                sa.update(_COMPARISONS).where(_COMPARISONS.c.id == comparison_id).values(compensation=found)
            )


def _largest(summary: dict[str, Any]) -> dict[str, Any] | None:
    largest, found = 1.0, None
    for one in summary.get("measures", []):
        if one["group"] != "compensation" or one["value"] is None or one["template_value"] is None:
            continue
        more = one["value"] - one["template_value"]
        chance = 2.0 * (one["uncertainty"] or 0.0) / math.sqrt(max(one["count"], 1))
        share = more / {"deg": 5.0, "m": 0.025}.get(one["unit"], math.inf)
        if more > chance and share > largest:
            largest = share
            found = {"channel": one["measure"].partition(":")[2], "more": more, "unit": one["unit"]}
    return found
