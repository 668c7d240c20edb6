"""A table before it is read: its first seconds, and what it is taken for in sentences.

The command, the interface and the upload page say the same, because it is written here.
"""

from app.readers.tables.look.at import Look, SensorLook, look_at

__all__ = ["Look", "SensorLook", "look_at"]
