"""Inclination from gyroscopes and accelerometers (Luinge 2005)."""
