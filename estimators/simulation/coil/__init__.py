"""A magnetic source and the sensors around it, with exact truth."""
