"""When is a change a change: the trend of a measure over days, its interval, and what sessions differ by.

Arrays in, arrays out. Times are days, values in any unit; nothing here knows a database or a screen.
"""

from estimators.progress._discovery import discoveries
from estimators.progress._scatter import (
    FEWEST_SESSIONS,
    NO_PRIOR,
    Scatter,
    detectable_change,
    learn_scatter,
    second_differences,
)
from estimators.progress._trend import FEWEST_DAYS, WINDOW_DAYS, Trends, trends

__all__ = [
    "FEWEST_DAYS",
    "FEWEST_SESSIONS",
    "NO_PRIOR",
    "WINDOW_DAYS",
    "Scatter",
    "Trends",
    "detectable_change",
    "discoveries",
    "learn_scatter",
    "second_differences",
    "trends",
]
