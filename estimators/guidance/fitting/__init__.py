"""Which rules fit an exercise: those to begin with, limits that can hold, words by posture, rules of the other side."""

from estimators.guidance.fitting._default_rules import (
    DEFAULT_STOPS,
    PRAISE,
    SENTENCES,
    default_rules,
    range_limits,
)
from estimators.guidance.fitting._limits import farthest, is_broken, least_room, nearest_limit, proposed_limit
from estimators.guidance.fitting._mirror import mirror_cue_rule, mirror_stop_rule
from estimators.guidance.fitting._wording import fitting_sentence

__all__ = [
    "DEFAULT_STOPS",
    "PRAISE",
    "SENTENCES",
    "default_rules",
    "farthest",
    "fitting_sentence",
    "is_broken",
    "least_room",
    "mirror_cue_rule",
    "mirror_stop_rule",
    "nearest_limit",
    "proposed_limit",
    "range_limits",
]
