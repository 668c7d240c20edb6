"""What of a session is compared: trajectories, the channels of one side, their mirror, and their names for people."""
