"""Schepers, chapter 3: eyes open and closed, seen by the system and by the truth."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from estimators.conventions import SIDES
from estimators.gait import find_strides, foot_placement, smooth
from estimators.recording import Float
from estimators.simulation import GaitScenario, Leg, eyes_closed, gait_preset, simulate_gait
from validation.protocol import Data, Figure, Protocol, Values

_SUBJECTS, _TRIALS = 8, 2
_RATE_HZ = 100.0


def _subject(random: np.random.Generator) -> tuple[GaitScenario, GaitScenario]:
    """Draw a person as section 5.3 says, with open and with closed eyes."""
    base = gait_preset("placement")
    stride, lateral = random.normal(1.28, 0.06), 0.016 * random.normal(1.0, 0.15)
    shorter, wider = random.normal(-0.10, 0.06), 0.008 * random.normal(1.0, 0.4)
    walk = replace(
        base.walk,
        stride_length_m=stride,
        stride_time_s=random.normal(1.15, 0.04),
        step_width_m=0.11,
        lateral_sd_m=lateral,
    )
    bout = replace(base.course[0], legs=(Leg(14),))
    eyes_open = replace(base, walk=walk, course=(bout,), rate_hz=_RATE_HZ)
    return eyes_open, eyes_closed(eyes_open, wider, shorter)


def _means(scenario: GaitScenario, seed: int) -> Float:
    """Return mean size of lateral placement and mean stride length: found, then true; shape (2, 2)."""
    values: list[list[Float]] = [[], [], [], []]
    for trial in range(_TRIALS):
        walk = simulate_gait(replace(scenario, seed=seed + trial))
        for side in SIDES:
            strides = find_strides(smooth(walk.recording.sensors[f"heel_{side}"]), side)
            for i, holds in enumerate((strides.footholds.position_m, walk.truth.feet[side].foothold_m)):
                placed = foot_placement(holds[1:-1])
                values[2 * i].append(np.abs(placed.lateral_m).reshape(-1))
                values[2 * i + 1].append(placed.length_m.reshape(-1))
    return np.array([np.concatenate(part).mean() for part in values]).reshape(2, 2)


def effects(values: Float) -> dict[str, float]:
    """Return the p-values of a repeated-measures comparison of two conditions by two systems.

    Parameters
    ----------
    values : ndarray, shape (n, 2, 2)
        Subject, condition, system.

    Returns
    -------
    dict
        `condition`, `system` and `interaction`. With two levels each effect is a paired t-test of its contrast.
    """
    contrasts = {
        "condition": values[:, 0].mean(axis=1) - values[:, 1].mean(axis=1),
        "system": values[:, :, 0].mean(axis=1) - values[:, :, 1].mean(axis=1),
        "interaction": (values[:, 0, 0] - values[:, 0, 1]) - (values[:, 1, 0] - values[:, 1, 1]),
    }
    return {name: float(stats.ttest_1samp(contrast, 0.0).pvalue) for name, contrast in contrasts.items()}


def _conditions(seeds: Sequence[int], data: Data) -> Values:
    # Eight persons are one experiment, and its p-values one draw: a batch of seeds is one experiment.
    first = seeds[0]
    random = np.random.default_rng([first, 77])
    table = np.empty((_SUBJECTS, 2, 2, 2))  # subject, condition, system, quantity
    for subject in range(_SUBJECTS):
        for condition, scenario in enumerate(_subject(random)):
            table[subject, condition] = _means(scenario, 1000 * first + 100 * subject + 10 * condition)
    result: dict[str, float] = {}
    for quantity, name in enumerate(("lateral placement", "stride length")):
        for effect, p in effects(table[..., quantity]).items():
            result[f"{name}, p of {effect}"] = p
        change = table[:, 1, 0, quantity].mean() - table[:, 0, 0, quantity].mean()
        result[f"{name}, eyes closed less open"] = float(change)
        bias = float((table[:, :, 0, quantity] - table[:, :, 1, quantity]).mean())
        result[f"{name}, size of the system's bias"] = abs(bias)
    return {name: np.array([value]) for name, value in result.items()}


FOOT_CONDITIONS = Protocol(
    name="foot_placement_conditions",
    title="Eyes open and eyes closed",
    source="Schepers 2009, table 3.1 and figure 3.5; method page 5.3",
    what="Eight simulated people walk with open and closed eyes, two trials of 14 steps each; repeated-measures "
    "comparison of conditions and of the system with the truth. A system effect on lateral placement is to be "
    "expected, as noise makes its size larger. One experiment a batch of seeds.",
    figures=(
        Figure("lateral placement, p of condition", "1", 0.05, 0.021, judged_by="median"),
        Figure("lateral placement, p of system", "1", published=0.001),
        Figure("lateral placement, p of interaction", "1", 0.05, 0.823, at_most=False),
        Figure("lateral placement, eyes closed less open", "m", 0.0, at_most=False),
        Figure("lateral placement, size of the system's bias", "m", 0.0005),
        Figure("stride length, p of condition", "1", 0.05, 0.007, judged_by="median"),
        Figure("stride length, p of system", "1", published=0.063),
        Figure("stride length, p of interaction", "1", 0.05, 0.453, at_most=False),
        Figure("stride length, eyes closed less open", "m", 0.0),
        Figure("stride length, size of the system's bias", "m", 0.003),
    ),
    measure=_conditions,
)
