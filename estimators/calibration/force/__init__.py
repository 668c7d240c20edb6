"""Offset and scale of an accelerometer, found in movement that nobody made for it."""
