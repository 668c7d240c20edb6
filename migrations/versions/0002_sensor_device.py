"""Remember what was calibrated and learnt about each sensor.

Revision: 0002_sensor_device
After: 0001_initial.
"""

import sqlalchemy as sa
from alembic import op

revision = "0002_sensor_device"
down_revision = "0001_initial"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "sensor_device",
        sa.Column("clinic_id", sa.String(length=32), nullable=False),
        sa.Column("serial", sa.String(length=100), nullable=False),
        sa.Column("calibration", sa.JSON(), nullable=False),
        sa.Column("scores", sa.JSON(), nullable=False),
        sa.Column("constants", sa.JSON(), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("updated_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(["clinic_id"], ["clinic.id"], name=op.f("fk_sensor_device_clinic_id_clinic")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_sensor_device")),
        sa.UniqueConstraint("clinic_id", "serial", name=op.f("uq_sensor_device_clinic_id_serial")),
    )


def downgrade() -> None:
    op.drop_table("sensor_device")
