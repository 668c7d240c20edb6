"""Patients, body dimensions, remembered mountings and grants."""
