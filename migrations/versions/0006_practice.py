"""Count what was valid in a session, and let a clinic say in which time zone its weeks begin; note who lost a
second factor to an administrator.

Sessions that were compared get their repetitions from the comparison of their main result, and their time from the
measure `duration` of each repetition; walks get the time of their steady strides. What stays empty, also where a
stored walk is damaged, is counted as before: as a session that recorded something.

Revision: 0006_practice
After: 0005_second_factor.
"""

import json
import zlib

import sqlalchemy as sa
from alembic import op

revision = "0006_practice"
down_revision = "0005_second_factor"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("clinic", sa.Column("time_zone", sa.String(length=64), nullable=True))
    op.add_column("motion_session", sa.Column("valid_repetitions", sa.Integer(), nullable=True))
    op.add_column("motion_session", sa.Column("active_s", sa.Float(), nullable=True))
    op.add_column("account", sa.Column("totp_removed_at", sa.DateTime(timezone=True), nullable=True))
    _count_compared()
    _count_walks()


def downgrade() -> None:
    op.drop_column("account", "totp_removed_at")
    op.drop_column("motion_session", "active_s")
    op.drop_column("motion_session", "valid_repetitions")
    op.drop_column("clinic", "time_zone")


def _count_compared() -> None:
    newest = (
        "(SELECT c.id FROM comparison c WHERE c.session_id = motion_session.id"
        " AND c.result_id = motion_session.main_result_id ORDER BY c.created_at DESC, c.id DESC LIMIT 1)"
    )
    op.execute(
        "UPDATE motion_session SET"  # noqa: S608 - no word of it comes from outside
        f" valid_repetitions = (SELECT k.repetition_count FROM comparison k WHERE k.id = {newest}),"
        " active_s = (SELECT COALESCE(SUM(m.value), 0.0) FROM repetition_measure m"
        f" WHERE m.measure = 'duration' AND m.comparison_id = {newest})"
        " WHERE state = 'analysed' AND purpose = 'exercise' AND EXISTS"
        " (SELECT 1 FROM comparison e WHERE e.session_id = motion_session.id"
        " AND e.result_id = motion_session.main_result_id)"
    )


def _count_walks() -> None:
    connection = op.get_bind()
    walks = connection.execute(
        sa.text(
            "SELECT s.id AS id, c.data AS data FROM motion_session s JOIN signal_chunk c"
            " ON c.session_id = s.id AND c.stream = 'gait/' || s.main_result_id"
            " WHERE s.state = 'analysed' AND s.purpose = 'exercise'"
        ),
        # Walks are up to 100 kB each: not all of a clinic's at once.
        execution_options={"yield_per": 50},
    )
    measured = ((row.id, _walked_s(bytes(row.data))) for row in walks)
    counted = [{"of": of, "active_s": active_s} for of, active_s in measured if active_s is not None]
    if counted:
        connection.execute(
            sa.text("UPDATE motion_session SET valid_repetitions = 0, active_s = :active_s WHERE id = :of"),
            counted,
        )


def _walked_s(data: bytes) -> float | None:
    try:
        walk = json.loads(zlib.decompress(data))
    except (zlib.error, ValueError):
        return None
    test = walk.get("test")
    if test and test["kind"] != "walk":
        return float(test["time_s"])
    feet = [
        [one["duration_s"] or 0.0 for one in foot["strides"] if one["is_counted"]] for foot in walk["feet"]
    ]
    return float(max(map(sum, feet), default=0.0))
