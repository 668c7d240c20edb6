"""Store counts of failed sign-ins and wrong pairing codes, so that many edges share them.

Revision: 0017_attempt_count
After: 0016_pairing_code.
"""

import sqlalchemy as sa
from alembic import op

revision = "0017_attempt_count"
down_revision = "0016_pairing_code"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "attempt_count",
        sa.Column("key_hash", sa.String(length=64), nullable=False),
        sa.Column("empty_at", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("key_hash", name=op.f("pk_attempt_count")),
    )
    op.create_index(op.f("ix_attempt_count_empty_at"), "attempt_count", ["empty_at"])


def downgrade() -> None:
    op.drop_table("attempt_count")
