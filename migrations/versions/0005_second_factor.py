"""Know browsers again that have signed in before; a second factor; passwords that must be changed.

Revision: 0005_second_factor
After: 0004_sentences.
"""

import sqlalchemy as sa
from alembic import op

revision = "0005_second_factor"
down_revision = "0004_sentences"
branch_labels = None
depends_on = None


def _columns() -> list[sa.Column]:
    return [
        sa.Column("must_change_password", sa.Boolean(), nullable=False, server_default=sa.false()),
        sa.Column("totp_secret", sa.String(length=64), nullable=True),
        sa.Column("totp_since", sa.DateTime(timezone=True), nullable=True),
        sa.Column("totp_last_step", sa.BigInteger(), nullable=False, server_default="0"),
        sa.Column("recovery_hashes", sa.JSON(), nullable=False, server_default="[]"),
    ]


def upgrade() -> None:
    op.create_table(
        "known_browser",
        sa.Column("account_id", sa.String(length=32), nullable=False),
        sa.Column("token_hash", sa.String(length=64), nullable=False),
        sa.Column("seen_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["account_id"],
            ["account.id"],
            name=op.f("fk_known_browser_account_id_account"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_known_browser")),
        sa.UniqueConstraint("account_id", "token_hash", name=op.f("uq_known_browser_account_id_token_hash")),
    )
    for column in _columns():
        op.add_column("account", column)


def downgrade() -> None:
    for column in reversed(_columns()):
        op.drop_column("account", column.name)
    op.drop_table("known_browser")
