"""Checks of a stream: link, health, readings that cannot be right."""
