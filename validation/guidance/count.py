"""Repetitions counted as they end, among partial and wrong ones."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np

from estimators.guidance import Guide
from validation.guidance.sessions import STEP_S, VALID_SHARE, matched, session
from validation.protocol import Data, Figure, Protocol, Values

_SETS: Final = ("pauses", "no rest", "mild", "moderate", "mixed", "faults")


def _measure(seeds: Sequence[int], data: Data) -> Values:
    counted: Counter[tuple[str, str]] = Counter()
    for kind in _SETS:
        for seed in seeds:
            one = session(kind, seed)
            guide = Guide(one.ready, STEP_S, valid_share=VALID_SHARE.get(kind, 0.8), rules=(), stops=())
            found = matched(one, guide.feed(one.values, one.sigma))
            for number, how in enumerate(found):
                # A plane that is 30 degrees off is another movement: the page leaves it out as well.
                if number < len(one.plan) and one.faults[number] not in ("front", "out"):
                    counted[one.truth_of(number), how] += 1
                elif number >= len(one.plan):
                    counted["none", how.removeprefix("extra ")] += 1
    of = Counter[str]()
    for (truth, _), number in counted.items():
        of[truth] += number
    said = sum(number for (_, how), number in counted.items() if how == "valid")
    right = counted["valid", "valid"]
    return {
        _RECALL: np.array([right / of["valid"]]),
        _PRECISION: np.array([right / max(said, 1)]),
        _PARTIAL: np.array([counted["partial", "partial"] / of["partial"] if of["partial"] else 1.0]),
        _WRONG: np.array([float(counted["wrong", "valid"])]),
        _WRONG_SEEN: np.array([counted["wrong", "wrong"] / of["wrong"] if of["wrong"] else 1.0]),
    }


_RECALL: Final = "valid ones counted"
_PRECISION: Final = "counted ones that are valid"
_PARTIAL: Final = "partial ones counted as partial"
_WRONG: Final = "wrong ones counted as valid, in a batch"
_WRONG_SEEN: Final = "wrong ones counted as wrong"

COUNT = Protocol(
    name="guidance_count",
    title="Repetitions counted while they are made",
    source="House page on live guidance, sections 4 and 9",
    what="Six sets of six repetitions a seed, through sensors and filters: with pauses, tremor and stops, without "
    "rest, after a mild and a moderate stroke, among partial (0.3 to 0.6 of the size) and wrong ones, with single "
    "faults. An attempt is of the repetition with which it shares 40 % of its time or more.",
    figures=(
        Figure(_RECALL, "1", 0.98, at_most=False, judged_by="mean"),
        Figure(_PRECISION, "1", 0.98, at_most=False, judged_by="mean"),
        Figure(_PARTIAL, "1", 0.85, at_most=False, judged_by="mean"),
        Figure(_WRONG, "count", 0.0, judged_by="mean"),
        Figure(_WRONG_SEEN, "1"),
    ),
    measure=_measure,
)
