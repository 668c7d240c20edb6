"""Index what is listed in pages in the order of its list.

Revision: 0007_list_order
After: 0006_practice.
"""

from alembic import op

revision = "0007_list_order"
down_revision = "0006_practice"
branch_labels = None
depends_on = None

_LISTS = (
    ("motion_session", "patient_id"),
    ("job", "session_id"),
    ("comparison", "session_id"),
    ("device_token", "patient_id"),
)


def upgrade() -> None:
    # The new index begins with the column of the old one and serves its queries too.
    for table, owner in _LISTS:
        op.create_index(op.f(f"ix_{table}_{owner}_created_at_id"), table, [owner, "created_at", "id"])
        op.drop_index(op.f(f"ix_{table}_{owner}"), table_name=table)
    op.create_index(op.f("ix_audit_event_patient_id_number"), "audit_event", ["patient_id", "number"])


def downgrade() -> None:
    op.drop_index(op.f("ix_audit_event_patient_id_number"), table_name="audit_event")
    for table, owner in reversed(_LISTS):
        op.create_index(op.f(f"ix_{table}_{owner}"), table, [owner])
        op.drop_index(op.f(f"ix_{table}_{owner}_created_at_id"), table_name=table)
