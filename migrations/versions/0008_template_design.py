"""Store what therapists draw on templates, why a version was made, and how a prescription is spread over the week.

Revision: 0008_template_design
After: 0007_list_order.
"""

import sqlalchemy as sa
from alembic import op

revision = "0008_template_design"
down_revision = "0007_list_order"
branch_labels = None
depends_on = None

_COLUMNS = {
    "template": ("tags", "retired_at"),
    "template_version": ("design", "reason"),
    "prescription": ("days", "times", "tolerance_scale", "stops"),
}


def upgrade() -> None:
    for table, column in (
        ("template", sa.Column("tags", sa.JSON(), nullable=False, server_default="[]")),
        ("template", sa.Column("retired_at", sa.DateTime(timezone=True), nullable=True)),
        ("template_version", sa.Column("design", sa.JSON(), nullable=False, server_default="{}")),
        ("template_version", sa.Column("reason", sa.String(length=500), nullable=False, server_default="")),
        ("prescription", sa.Column("days", sa.JSON(), nullable=False, server_default="[]")),
        ("prescription", sa.Column("times", sa.JSON(), nullable=False, server_default="[]")),
        ("prescription", sa.Column("tolerance_scale", sa.Float(), nullable=False, server_default="1.0")),
        ("prescription", sa.Column("stops", sa.JSON(), nullable=False, server_default="[]")),
    ):
        op.add_column(table, column)


def downgrade() -> None:
    for table, columns in _COLUMNS.items():
        for column in columns:
            op.drop_column(table, column)
