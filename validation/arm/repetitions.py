"""Repetitions of any movement, found in sets that were made without regard to how they are found."""

from collections.abc import Sequence

import numpy as np

from estimators.comparison import Trajectory, find_repetitions, judge_repetitions
from estimators.recording import Float
from estimators.simulation import REPEATED_FAMILIES, RepeatedMovement, simulate_repetitions
from validation.protocol import Data, Figure, Protocol, Values

_SETS = 20
"""Sets a seed."""
_OVERLAP = 0.5
"""Share of the time of both together that a repetition found and a true one share, or they are not the same."""
_PHASES = 20
"""Where a set may be cut that shows no home."""


def _found(made: RepeatedMovement) -> Float:
    moved = Trajectory(
        time_s=made.time_s,
        channels=made.channels,
        values=made.values,
        sigma=np.full(made.values.shape, np.nan),
        valid=np.isfinite(made.values),
    )
    judged = judge_repetitions(moved, find_repetitions(moved, "right"), "right")
    return np.array([(one.start_s, one.end_s) for one in judged if one.is_kept]).reshape(-1, 2)


def _truths(made: RepeatedMovement) -> list[Float]:
    """Return the bounds that may be found: one list, or one for each phase where the set shows no home."""
    if made.has_home:
        return [made.cycles_s]
    last = len(made.time_s) - 1
    truths = []
    for phase in np.arange(_PHASES) / _PHASES:
        whole = phase + np.arange(np.floor(made.phase[-1] - phase + 1e-9) + 1)
        leaves = made.time_s[np.minimum(np.searchsorted(made.phase, whole, side="right"), last)]
        arrives = made.time_s[np.minimum(np.searchsorted(made.phase, whole), last)]
        truths.append(np.stack([leaves[:-1], arrives[1:]], axis=1))
    return truths


def _hits(found: Float, truth: Float) -> int:
    """Count true repetitions that were found, each by another."""
    free = np.ones(len(found), dtype=bool)
    hits = 0
    for start, end in truth:
        shared = np.minimum(found[:, 1], end) - np.maximum(found[:, 0], start)
        both = np.maximum(found[:, 1], end) - np.minimum(found[:, 0], start)
        share = np.where(free, shared / both, 0.0)
        if len(share) and share.max() >= _OVERLAP:
            free[np.argmax(share)] = False
            hits += 1
    return hits


def _any_movement(seeds: Sequence[int], data: Data) -> Values:
    rows = []
    for seed in seeds:
        counts = np.zeros(4)
        for number in range(_SETS * seed, _SETS * (seed + 1)):
            made = simulate_repetitions(number, REPEATED_FAMILIES[number % len(REPEATED_FAMILIES)])
            found = _found(made)
            shown = len(made.cycles_s) if made.has_home else int(made.phase[-1] + 1e-9)
            hits = max(_hits(found, truth) for truth in _truths(made))
            counts += hits, shown, len(found), len(found) == shown
        rows.append((counts[0] / counts[1], counts[0] / max(counts[2], 1.0), 100.0 * counts[3] / _SETS))
    return {
        figure.name: np.array(column)
        for figure, column in zip(_FIGURES, zip(*rows, strict=True), strict=True)
    }


_FIGURES = (
    Figure("repetitions found, share of the true ones", "1", 0.97, at_most=False, judged_by="mean"),
    Figure("true ones, share of those found", "1", 0.97, at_most=False, judged_by="mean"),
    Figure("sets with the true count", "%", 90.0, at_most=False, judged_by="mean"),
)

ANY_REPETITIONS = Protocol(
    name="repetitions",
    title="Repetitions of any movement",
    source="House requirement; movements with least jerk after Flash and Hogan 1985, Journal of Neuroscience 5:1688",
    what="Twenty sets a seed in any channels of an arm, a leg, the trunk or the path of a hand (stops, smooth paths, "
    "jumps, orbits, swings, efforts), at 0.3 to 3 times their pace, with pauses or none, holds, partial tries, tremor, "
    "drift, and recordings that begin or end inside a movement. A repetition is found when it shares half of the time "
    "with a true one.",
    figures=_FIGURES,
    measure=_any_movement,
)
