"""Leave the language to the browser until somebody chooses one; so far nobody could.

Revision: 0012_locale
After: 0011_answers.
"""

from alembic import op

revision = "0012_locale"
down_revision = "0011_answers"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.execute("UPDATE account SET locale = '' WHERE locale = 'en'")


def downgrade() -> None:
    op.execute("UPDATE account SET locale = 'en' WHERE locale = ''")
