"""Published filters to compare with, each after its paper; the registry of orientation loads the one that is chosen."""
