"""The magnetometer and the field around it: ellipsoid, turns, dip, iron."""
