"""What `telemotion process` does with a recording of each kind."""
