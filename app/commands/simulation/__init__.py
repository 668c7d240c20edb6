"""The simulated patients of `telemotion simulate`."""
