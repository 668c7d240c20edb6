"""Store whether an exercise is done standing or seated; those that were there before are shown standing, as they were.

Revision: 0015_posture
After: 0014_live_checkpoint.
"""

import sqlalchemy as sa
from alembic import op

revision = "0015_posture"
down_revision = "0014_live_checkpoint"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "exercise", sa.Column("posture", sa.String(length=10), nullable=False, server_default="standing")
    )


def downgrade() -> None:
    op.drop_column("exercise", "posture")
