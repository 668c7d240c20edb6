"""Our filter and smoother in random worlds, beside the `vqf` package: over all of them, and by condition."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from validation.protocol import Data, Figure, Protocol, Values
from validation.worlds.conditions import ROWS, WHOLE
from validation.worlds.scores import METHODS, Score, is_beyond, scored
from validation.worlds.world import TUNING_SEEDS, draw, world_seed

_ALL: Final = "all"
_MOST_BEYOND, _MOST_UNTRUSTED = 1.0, 5.0
_LEAST_INSIDE, _MOST_INSIDE, _LEAST_INSIDE_ROW = 90.0, 97.0, 85.0
_FAR_DEG: Final = 20.0
_INSIDE: Final = "inside the 95 % region"


_KINDS: Final[dict[str, tuple[str, Callable[[Score], float | None]]]] = {
    "error": ("deg", lambda score: score.error_deg),
    "error of vqf": ("deg", lambda score: score.package_deg),
    "runs beyond 1.5 vqf + 0.5 deg": ("%", lambda score: 100.0 * is_beyond(score)),
    "runs above 20 deg": ("%", lambda score: 100.0 * (score.error_deg > _FAR_DEG)),
    "runs of vqf above 20 deg": ("%", lambda score: 100.0 * (score.package_deg > _FAR_DEG)),
    _INSIDE: ("%", lambda score: score.inside_percent),
    "median sigma": ("deg", lambda score: score.sigma_deg),
    "heading not trusted within 10 deg": ("%", lambda score: score.untrusted_percent),
}
"""What every row of the table has: its unit, and its value of a run, where there is one."""
_JUDGED: Final[dict[str, tuple[str, float, bool, Callable[[Score], float | None]]]] = {
    f"{_INSIDE}, at least": ("%", _LEAST_INSIDE, False, lambda score: score.inside_percent),
    f"{_INSIDE}, at most": ("%", _MOST_INSIDE, True, lambda score: score.inside_percent),
    "runs above 20 deg times three, less those of vqf": (
        "%",
        0.0,
        True,
        lambda score: 300.0 * (score.error_deg > _FAR_DEG) - 100.0 * (score.package_deg > _FAR_DEG),
    ),
    "runs that end in an error": ("%", 0.0, True, lambda score: 100.0 * score.has_failed),
}
"""What is judged over all worlds besides: unit, limit, whether it is an upper one, and the value of a run."""
_LIMITS_OF_ALL: Final = {
    "runs beyond 1.5 vqf + 0.5 deg": _MOST_BEYOND,
    "heading not trusted within 10 deg": _MOST_UNTRUSTED,
}


def _measured(seeds: Sequence[int], data: Data) -> Values:
    runs: dict[tuple[str, str], list[Score]] = {
        (row, method): [] for row in (_ALL, *ROWS) for method in METHODS
    }
    for seed in seeds:
        world = draw(world_seed(seed))
        rows = world.conditions.rows()
        for method in METHODS:
            score = scored(world, method)
            for row in (WHOLE,) if WHOLE in rows else (_ALL, *rows):
                runs[row, method].append(score)
    values: Values = {}
    for (row, method), scores in runs.items():
        for kind, (_, value) in _KINDS.items():
            if row != _ALL or kind != _INSIDE:
                values[f"{row}, {method}, {kind}"] = _known(scores, value)
        if row == _ALL:
            for kind, (_, _, _, value) in _JUDGED.items():
                values[f"{row}, {method}, {kind}"] = _known(scores, value)
    return values


def _known(scores: Sequence[Score], value: Callable[[Score], float | None]) -> np.ndarray:
    return np.array([found for score in scores if (found := value(score)) is not None], dtype=np.float64)


def _figures() -> tuple[Figure, ...]:
    figures = []
    for method in METHODS:
        for kind, (unit, _) in _KINDS.items():
            if kind != _INSIDE:
                limit = _LIMITS_OF_ALL.get(kind)
                figures.append(Figure(f"{_ALL}, {method}, {kind}", unit, limit, judged_by="mean"))
        for kind, (unit, limit, at_most, _) in _JUDGED.items():
            name = f"{_ALL}, {method}, {kind}"
            figures.append(Figure(name, unit, limit, at_most=at_most, judged_by="mean"))
    for row in ROWS:
        for method in METHODS:
            for kind, (unit, _) in _KINDS.items():
                is_inside = kind == _INSIDE
                limit = _LEAST_INSIDE_ROW if is_inside and row != WHOLE else None
                name = f"{row}, {method}, {kind}"
                figures.append(Figure(name, unit, limit, at_most=not is_inside, judged_by="mean"))
    return tuple(figures)


ORIENTATION_WORLDS = Protocol(
    name="orientation_worlds",
    title="Our filter and smoother in random worlds",
    source="Worlds ours (validation/worlds); the vqf package: Laidig and Seel 2023, Information Fusion 91",
    what="A world a seed, 60 to 120 s of one sensor, drawn at random: motion, grade of the sensor, field, dip, rate, "
    "rest at the start, a range that cuts off, samples lost or frozen, soft tissue, warming. Our filter stands beside "
    "VQF, our smoother beside offlineVQF, with default parameters; the package gets lost stretches bridged by straight "
    "lines. Scored from the tenth second on, where anything is measured: one value a run, so that n counts the runs. "
    "Without magnetometer the heading is counted from the truth at the tenth second. Worlds whose field is turned all "
    f"along count in their own row alone: no sensor can know it. Seeds below {TUNING_SEEDS} are for tuning; others are "
    "moved by a digest of the versions of filter and smoother.",
    figures=_figures(),
    measure=_measured,
)
