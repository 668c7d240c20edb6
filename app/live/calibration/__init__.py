"""Guided calibration of a live session."""
