"""Guidance while a session streams: phase, repetitions, one cue at a time, what stops it."""
