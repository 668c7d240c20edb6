"""Say who may write for a partition of live sessions, and how far its stream is stored.

Revision: 0013_partition_hold
After: 0012_locale.
"""

import sqlalchemy as sa
from alembic import op

revision = "0013_partition_hold"
down_revision = "0012_locale"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "partition_hold",
        sa.Column("partition", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("fencing", sa.BigInteger(), nullable=False),
        sa.Column("holder", sa.String(length=64), nullable=False),
        sa.Column("position", sa.BigInteger(), nullable=False),
        sa.Column("updated_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("partition", name=op.f("pk_partition_hold")),
    )


def downgrade() -> None:
    op.drop_table("partition_hold")
