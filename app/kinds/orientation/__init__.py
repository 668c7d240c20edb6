"""Single sensors that nobody wears: each for itself."""
