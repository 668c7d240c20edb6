"""Where repetitions of any movement begin and end: its path, the stays at home between, the cycles that come back."""

from estimators.comparison.repetitions.counted import counted_repetitions
from estimators.comparison.repetitions.finder import find_repetitions

__all__ = ["counted_repetitions", "find_repetitions"]
