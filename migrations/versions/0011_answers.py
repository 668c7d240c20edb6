"""Store what a patient says after an exercise, and the question that a therapist asks besides.

Revision: 0011_answers
After: 0010_course_notes.
"""

import sqlalchemy as sa
from alembic import op

revision = "0011_answers"
down_revision = "0010_course_notes"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "prescription", sa.Column("question", sa.String(length=200), nullable=False, server_default="")
    )
    op.create_table(
        "session_answers",
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("pain", sa.Integer(), nullable=True),
        sa.Column("effort", sa.Integer(), nullable=True),
        sa.Column("third", sa.Integer(), nullable=True),
        sa.Column("question", sa.String(length=200), nullable=False),
        sa.Column("note", sa.String(length=2000), nullable=False),
        sa.Column("answered_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("answered_by", sa.String(length=32), nullable=False),
        sa.ForeignKeyConstraint(
            ["session_id"],
            ["motion_session.id"],
            name=op.f("fk_session_answers_session_id_motion_session"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("session_id", name=op.f("pk_session_answers")),
    )


def downgrade() -> None:
    op.drop_table("session_answers")
    op.drop_column("prescription", "question")
