"""Remember the coils of each magnetic source as they were measured.

Revision: 0003_magnetic_source
After: 0002_sensor_device.
"""

import sqlalchemy as sa
from alembic import op

revision = "0003_magnetic_source"
down_revision = "0002_sensor_device"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "magnetic_source",
        sa.Column("clinic_id", sa.String(length=32), nullable=False),
        sa.Column("serial", sa.String(length=100), nullable=False),
        sa.Column("name", sa.String(length=100), nullable=False),
        sa.Column("coils", sa.JSON(), nullable=False),
        sa.Column("current_limit_a", sa.Float(), nullable=False),
        sa.Column("gain_sigma", sa.Float(), nullable=False),
        sa.Column("found", sa.JSON(), nullable=False),
        sa.Column("method", sa.String(length=20), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=True),
        sa.Column("calibrated_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("calibrated_by", sa.String(length=32), nullable=False),
        sa.Column("retired_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["clinic_id"], ["clinic.id"], name=op.f("fk_magnetic_source_clinic_id_clinic")
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_magnetic_source")),
        sa.UniqueConstraint("clinic_id", "serial", name=op.f("uq_magnetic_source_clinic_id_serial")),
    )


def downgrade() -> None:
    op.drop_table("magnetic_source")
