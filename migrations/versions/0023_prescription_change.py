"""Keep what a prescription was before each of its changes, with who and when.

Revision: 0023_prescription_change
After: 0022_merged_into.
"""

import sqlalchemy as sa
from alembic import op

revision = "0023_prescription_change"
down_revision = "0022_merged_into"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "prescription_change",
        sa.Column("prescription_id", sa.String(length=32), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("before", sa.JSON(), nullable=False),
        sa.Column("changed_by", sa.String(length=32), nullable=False),
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["changed_by"], ["account.id"], name=op.f("fk_prescription_change_changed_by_account")
        ),
        sa.ForeignKeyConstraint(
            ["prescription_id"],
            ["prescription.id"],
            name=op.f("fk_prescription_change_prescription_id_prescription"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_prescription_change")),
        sa.UniqueConstraint(
            "prescription_id", "number", name=op.f("uq_prescription_change_prescription_id_number")
        ),
    )


def downgrade() -> None:
    op.drop_table("prescription_change")
