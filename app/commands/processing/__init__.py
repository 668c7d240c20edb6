"""`telemotion process` for a recording of each kind."""
