"""Calibration of an arm by movement instead of a pose."""
