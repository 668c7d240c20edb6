"""Everything held about a patient as one archive."""
