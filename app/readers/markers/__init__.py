"""Marker tracks of optical systems: C3D files and tables."""
