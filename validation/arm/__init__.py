"""Arm monitoring (Marzouk 2009), calibration, repetitions and whole sessions of the arm."""
