"""Store code and parameters of sentences in the columns of their words.

Both are JSON in the same column, longer than the words; SQLite does not limit what a column holds.

Revision: 0004_sentences
After: 0003_magnetic_source.
"""

import sqlalchemy as sa
from alembic import op

revision = "0004_sentences"
down_revision = "0003_magnetic_source"
branch_labels = None
depends_on = None

COLUMNS = (
    ("motion_session", "state_reason"),
    ("session_event", "text"),
    ("result", "message"),
    ("job", "message"),
)


def upgrade() -> None:
    if op.get_bind().dialect.name == "postgresql":
        for table, column in COLUMNS:
            op.alter_column(table, column, type_=sa.String(), existing_type=sa.String(length=500), existing_nullable=False)


def downgrade() -> None:
    if op.get_bind().dialect.name == "postgresql":
        for table, column in COLUMNS:
            op.alter_column(
                table,
                column,
                type_=sa.String(length=500),
                existing_type=sa.String(),
                existing_nullable=False,
                postgresql_using=f"left({column}, 500)",
            )
