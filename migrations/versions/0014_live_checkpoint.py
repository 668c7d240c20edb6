"""Store where the estimation of live sessions stands, so that it goes on elsewhere.

Revision: 0014_live_checkpoint
After: 0013_partition_hold.
"""

import sqlalchemy as sa
from alembic import op

revision = "0014_live_checkpoint"
down_revision = "0013_partition_hold"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "live_checkpoint",
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("layout", sa.Integer(), nullable=False),
        sa.Column("sequence", sa.BigInteger(), nullable=False),
        sa.Column("data", sa.LargeBinary(), nullable=False),
        sa.Column("updated_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["session_id"],
            ["motion_session.id"],
            name=op.f("fk_live_checkpoint_session_id_motion_session"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("session_id", name=op.f("pk_live_checkpoint")),
    )


def downgrade() -> None:
    op.drop_table("live_checkpoint")
