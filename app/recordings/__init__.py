"""Stored sessions, signal chunks, reprocessing, replay and export."""
