"""The time of the rows of a table: stamps, times of day as text, counters, and which of them a table has."""
