"""Comparison with the template, scores and progress."""
