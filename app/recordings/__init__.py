"""Stored sessions: raw packets, derived frames, results, events and long tasks.

Nothing is imported here: readers of files need the words of this room without its database.
"""
