"""Store each measure of a comparison drawn together over its repetitions, so that progress reads a tenth of the rows.

The database fills it in one statement for comparisons that are there: what progress drew together until now.

Revision: 0018_comparison_measure
After: 0017_attempt_count.
"""

import sqlalchemy as sa
from alembic import op

revision = "0018_comparison_measure"
down_revision = "0017_attempt_count"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "comparison_measure",
        sa.Column("comparison_id", sa.String(length=32), nullable=False),
        sa.Column("measure", sa.String(length=80), nullable=False),
        sa.Column("unit", sa.String(length=12), nullable=False),
        sa.Column("mean", sa.Float(), nullable=False),
        sa.Column("mean_square", sa.Float(), nullable=False),
        sa.Column("repetitions", sa.Integer(), nullable=False),
        sa.Column("is_of_all", sa.Boolean(), nullable=False),
        sa.Column("uncertainty", sa.Float(), nullable=True),
        sa.ForeignKeyConstraint(
            ["comparison_id"],
            ["comparison.id"],
            name=op.f("fk_comparison_measure_comparison_id_comparison"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("comparison_id", "measure", name=op.f("pk_comparison_measure")),
    )
    op.execute(
        "INSERT INTO comparison_measure"
        " (comparison_id, measure, unit, mean, mean_square, repetitions, is_of_all, uncertainty)"
        " SELECT comparison_id, measure, MIN(unit), AVG(value), AVG(value * value), COUNT(*),"
        " MIN(repetition) = 0, MAX(uncertainty) FROM repetition_measure GROUP BY comparison_id, measure"
    )


def downgrade() -> None:
    op.drop_table("comparison_measure")
