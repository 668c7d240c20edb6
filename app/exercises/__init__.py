"""Exercises, templates (versioned) and prescriptions."""
