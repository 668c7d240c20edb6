"""Orientation beside iron (Roetenberg 2006, chapters 2 and 3)."""
