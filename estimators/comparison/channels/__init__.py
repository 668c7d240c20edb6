"""The compared parts of a session: trajectories, channels of one side, their mirror, and their names for people."""
