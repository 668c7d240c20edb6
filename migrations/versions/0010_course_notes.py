"""Store the therapist's words for the report of a course of therapy.

Revision: 0010_course_notes
After: 0009_stride.
"""

import sqlalchemy as sa
from alembic import op

revision = "0010_course_notes"
down_revision = "0009_stride"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "course_note",
        sa.Column("patient_id", sa.String(length=32), nullable=False),
        sa.Column("exercise_id", sa.String(length=32), nullable=False),
        sa.Column("text", sa.String(length=4000), nullable=False),
        sa.Column("written_by", sa.String(length=32), nullable=False),
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["patient_id"],
            ["patient.id"],
            name=op.f("fk_course_note_patient_id_patient"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["exercise_id"], ["exercise.id"], name=op.f("fk_course_note_exercise_id_exercise")
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_course_note")),
    )
    op.create_index(op.f("ix_course_note_patient_id"), "course_note", ["patient_id"])


def downgrade() -> None:
    op.drop_index(op.f("ix_course_note_patient_id"), table_name="course_note")
    op.drop_table("course_note")
