"""Optical and inertial fusion (Roetenberg 2006, chapter 4)."""
