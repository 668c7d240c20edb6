"""Let a ticket know the browser session that asked for it, so that the socket it opens ends with that session.

Tickets that are there are good for seconds more and know none.

Revision: 0021_ticket_sign_in
After: 0020_worry_seen.
"""

import sqlalchemy as sa
from alembic import op

revision = "0021_ticket_sign_in"
down_revision = "0020_worry_seen"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("ticket", sa.Column("sign_in_id", sa.String(32), nullable=True))


def downgrade() -> None:
    op.drop_column("ticket", "sign_in_id")
