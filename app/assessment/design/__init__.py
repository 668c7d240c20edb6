"""Templates: recorded from a session, drawn on by a therapist, compiled for whoever judges, shown, in a library."""
