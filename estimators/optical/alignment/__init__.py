"""How a sensor's frame and clock lie to the markers on the same segment."""
