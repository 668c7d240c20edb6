"""Relative pose from a magnetic source (Schepers 2010, chapter 6)."""
