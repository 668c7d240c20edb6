"""Let the empty record of a person who had two know the one into which it was merged, for both are erased together.

Revision: 0022_merged_into
After: 0021_ticket_sign_in.
"""

import sqlalchemy as sa
from alembic import op

revision = "0022_merged_into"
down_revision = "0021_ticket_sign_in"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("patient", sa.Column("merged_into_id", sa.String(length=32), nullable=True))


def downgrade() -> None:
    op.drop_column("patient", "merged_into_id")
