"""Live sessions: state machine, clock alignment, runner and bus."""
