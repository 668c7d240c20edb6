"""What the commands ask for on the command line."""
