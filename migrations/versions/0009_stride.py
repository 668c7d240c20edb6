"""Store of how many ticks a result keeps one: live frames are kept at 25 Hz where the analysis finds them all again.

Revision: 0009_stride
After: 0008_template_design.
"""

import sqlalchemy as sa
from alembic import op

revision = "0009_stride"
down_revision = "0008_template_design"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("result", sa.Column("stride", sa.Integer(), nullable=False, server_default="1"))


def downgrade() -> None:
    op.drop_column("result", "stride")
