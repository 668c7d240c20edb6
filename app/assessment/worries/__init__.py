"""Worries: what happened in a patient's sessions that a therapist must have seen.

Pain, a stop rule, compensation and a dead link are worries. They are read from what is stored of the sessions; nothing
that follows hides them. Only what a therapist has marked as seen is stored besides, with who and when.
"""
