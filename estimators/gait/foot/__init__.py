"""One foot's sensor: the foot filter there and back, off-line and live, with what it costs to lose samples."""
