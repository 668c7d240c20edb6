"""The filter's mechanisms switched off in turn, in random worlds: the change that each one makes."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

import numpy as np

from validation.protocol import Data, Figure, Protocol, Values
from validation.worlds.conditions import WHOLE
from validation.worlds.scores import METHODS, Score, is_beyond, package_error_deg, scored
from validation.worlds.world import TUNING_SEEDS, draw, world_seed

_WHOLE_FILTER: Final = "whole filter"
VARIANTS: Final[Mapping[str, Mapping[str, float]]] = MappingProxyType(
    {
        "accelerometer offset": {"force_offset_sigma_mps2": 1e-3},
        "gravity": {"gravity_sigma_mps2": 1e-3},
        "gyroscope gain": {"gain_sigma": 1e-6},
        "two hypotheses on gains": {"gain_narrow": 0.01},
        "magnetometer delay": {"delay_sigma_s": 1e-6},
        "hard iron hypotheses": {"iron_narrow_odds": 0.98, "iron_middle_odds": 0.01},
        "start place hypotheses": {"start_narrow_odds": 0.98, "start_middle_odds": 0.01},
        "iron opened": {"iron_ratio": 1e9},
        "restless first field": {"steady_change_ut": 1e6},
        "contradiction of force": {"upright_limit_deg": 179.0},
        "surprise at rest": {"rest_surprise_degps": 1e3},
        "sway at rest": {"rest_sway_s": 0.0},
        "quiet field": {"quiet_least": 1.0},
        "rest says one thing once": {"field_same_s": 1e6},
        "turn forgiven": {"field_turn_free": 0.0},
        "wander in sigma": {"wander_share": 0.0},
        "doubt of the young field": {"wander_doubt": 0.0},
        "wander in the region": {"region_share": 0.0},
        "near one place": {"position_prior_m_sqrt_s": 100.0},
        "gap filling": {"coast_s": 0.0},
    }
)
"""Mechanism, and the parameters that switch it off."""


_KINDS: Final[dict[str, tuple[str, Callable[[Score], float]]]] = {
    "error": ("deg", lambda score: score.error_deg),
    "runs beyond 1.5 vqf + 0.5 deg": ("%", lambda score: 100.0 * is_beyond(score)),
    "inside the 95 % region": ("%", lambda score: score.inside_percent),
}


def _measured(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {figure.name: [] for figure in _FIGURES}
    for seed in seeds:
        world = draw(world_seed(seed))
        if WHOLE in world.conditions.rows():
            continue
        for method in METHODS:
            package_deg = package_error_deg(world, method)
            whole = scored(world, method, package_deg=package_deg)
            for kind, (_, value) in _KINDS.items():
                values[f"{_WHOLE_FILTER}, {method}, {kind}"].append(value(whole))
            for variant, parameters in VARIANTS.items():
                other = scored(world, method, parameters, package_deg)
                for kind, (_, value) in _KINDS.items():
                    values[f"without {variant}, {method}, {kind}"].append(value(other) - value(whole))
    return {name: np.array(found) for name, found in values.items()}


_FIGURES: Final = tuple(
    Figure(f"{row}, {method}, {kind}", unit, judged_by="mean")
    for row in (_WHOLE_FILTER, *(f"without {variant}" for variant in VARIANTS))
    for method in METHODS
    for kind, (unit, _) in _KINDS.items()
)

ORIENTATION_ABLATION = Protocol(
    name="orientation_ablation",
    title="Our filter and smoother with one mechanism switched off",
    source="Ours (validation/worlds)",
    what="The worlds of orientation_worlds. Parameters switch off one mechanism of filter and smoother at a time. A "
    "figure of a variant is its value less that of the whole filter in the same world: a positive change of the error "
    "is what the mechanism brings. Worlds whose field is turned all along do not count. There are no limits. Seeds "
    f"below {TUNING_SEEDS} are for tuning.",
    figures=_FIGURES,
    measure=_measured,
)
