"""Live guidance along a template: phase with its uncertainty, repetitions, one true cue at a time, what stops.

::

    ready = prepare_template(template, "right", reach_m=0.55)
    guide = Guide(ready, tick_s=0.01)
    chunk = guide.feed(*signals(trajectory(frames), ready))
"""

from estimators.guidance._contract import (
    KINDS,
    CountedRepetition,
    GuidanceChunk,
    GuidanceTemplate,
    RepetitionKind,
)
from estimators.guidance._guide import Guide
from estimators.guidance._orders import CuePace
from estimators.guidance._parameters import GuidanceParameters
from estimators.guidance._rules import Cue, CueRule, Stopped, StopRule
from estimators.guidance._template import prepare_template, signals, steers
from estimators.guidance.fitting import (
    DEFAULT_STOPS,
    PRAISE,
    SENTENCES,
    default_rules,
    farthest,
    fitting_sentence,
    is_broken,
    mirror_cue_rule,
    mirror_stop_rule,
    nearest_limit,
    proposed_limit,
    range_limits,
)

__all__ = [
    "DEFAULT_STOPS",
    "KINDS",
    "PRAISE",
    "SENTENCES",
    "CountedRepetition",
    "Cue",
    "CuePace",
    "CueRule",
    "GuidanceChunk",
    "GuidanceParameters",
    "GuidanceTemplate",
    "Guide",
    "RepetitionKind",
    "StopRule",
    "Stopped",
    "default_rules",
    "farthest",
    "fitting_sentence",
    "is_broken",
    "mirror_cue_rule",
    "mirror_stop_rule",
    "nearest_limit",
    "prepare_template",
    "proposed_limit",
    "range_limits",
    "signals",
    "steers",
]
