"""Engine, declarative base and unit of work."""
