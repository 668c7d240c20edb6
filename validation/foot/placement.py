"""Schepers, chapter 3: lateral foot placement and stride length of simulated walks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from estimators.conventions import SIDES
from estimators.gait import find_strides, foot_placement, smooth
from estimators.kinetics import ShoeGeometry
from estimators.kinetics.published import shoe_contact, shoe_pose
from estimators.recording import Float
from estimators.simulation import SimulatedWalk, gait_preset, simulate_gait
from validation.protocol import Data, Figure, Protocol, Values

_TRIALS = 3
_WINDOWS = (3, 4, 5, 6)
_RATE_HZ = 100.0
_MODELS = {"nominal": "shoe_nominal", "stress": "shoe_stress"}


@dataclass(frozen=True)
class Feet:
    """Footholds of one foot in one trial, shape (n, 2): found and true."""

    found: Float
    true: Float


@lru_cache(maxsize=2 * _TRIALS)
def _trial(seed: int, trial: int, errors: str) -> SimulatedWalk:
    """Walk one trial; retained for the methods that are compared on it."""
    scenario = gait_preset("placement", 1000 * seed + trial)
    return simulate_gait(replace(scenario, rate_hz=_RATE_HZ, errors=errors))


def subject(seed: int, errors: str) -> list[Feet]:
    """Walk some trials as one person and find the footholds of both feet."""
    result = []
    for trial in range(_TRIALS):
        walk = _trial(seed, trial, errors)
        for side in SIDES:
            strides = find_strides(smooth(walk.recording.sensors[f"heel_{side}"]), side)
            true = walk.truth.feet[side].foothold_m[:, :2]
            found = strides.footholds.position_m[:, :2]
            if len(found) != len(true):
                found = np.full_like(true, np.nan)
            result.append(Feet(found, true))
    return result


def _windows(feet: list[Feet], window: int, steady: bool = True) -> tuple[Float, Float, Float, Float]:
    """Return placement and length of all windows, found and true, each flat."""
    rows: list[list[Float]] = [[], [], [], []]
    for foot in feet:
        # The first and last foothold are standing: strides from and to them begin and end the walk.
        part = slice(1, -1) if steady else slice(None)
        if np.isnan(foot.found).any():
            return (np.full(1, np.nan),) * 4
        found, true = (foot_placement(p[part], window) for p in (foot.found, foot.true))
        for row, values in zip(
            rows, (found.lateral_m, true.lateral_m, found.length_m, true.length_m), strict=True
        ):
            row.append(values.reshape(-1))
    lateral, true_lateral, length, true_length = (np.concatenate(row) for row in rows)
    return lateral, true_lateral, length, true_length


def _rms(values: Float) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _scores(feet: list[Feet]) -> dict[str, float]:
    lateral, true_lateral, length, true_length = _windows(feet, 3)
    _, _, all_length, all_true = _windows(feet, 3, steady=False)
    error = length - true_length
    by_window = [_windows(feet, window) for window in _WINDOWS]
    lateral_rms = [_rms(found - true) for found, true, _, _ in by_window]
    length_rms = [_rms(found - true) for _, _, found, true in by_window]
    return {
        "lateral placement, rms error": lateral_rms[0],
        "stride length, rms error": length_rms[0],
        "lateral placement, correlation": float(np.corrcoef(lateral, true_lateral)[0, 1]),
        "stride length, correlation": float(np.corrcoef(length, true_length)[0, 1]),
        "stride length with first and last strides, correlation": float(
            np.corrcoef(all_length, all_true)[0, 1]
        ),
        "spread of lateral placement, change": abs(float(lateral.std(ddof=1) / true_lateral.std(ddof=1)) - 1),
        "spread of stride length, change": abs(float(length.std(ddof=1) / true_length.std(ddof=1)) - 1),
        "spread of all stride lengths, change": abs(float(all_length.std(ddof=1) / all_true.std(ddof=1)) - 1),
        "stride length, size of the mean error": abs(float(error.mean())),
        "stride length, SD of the error": float(error.std(ddof=1)),
        "lateral placement, error at N = 6 over N = 3": lateral_rms[3] / lateral_rms[0],
        "stride length, largest over smallest error, N = 3 to 6": max(length_rms) / min(length_rms),
    }


# name, unit, published, limit (nominal, stress), at most
_TABLE: tuple[tuple[str, str, float | None, tuple[float | None, float | None], bool], ...] = (
    ("lateral placement, rms error", "m", None, (0.002, 0.005), True),
    ("stride length, rms error", "m", None, (0.005, 0.014), True),
    ("lateral placement, correlation", "1", 0.77, (0.97, 0.90), False),
    ("stride length, correlation", "1", 0.82, (0.97, 0.90), False),
    ("stride length with first and last strides, correlation", "1", 0.995, (0.995, 0.995), False),
    ("spread of lateral placement, change", "1", 0.078, (0.05, 0.078), True),
    ("spread of stride length, change", "1", None, (0.03, 0.08), True),
    ("spread of all stride lengths, change", "1", 0.0067, (0.0067, 0.0067), True),
    ("stride length, size of the mean error", "m", None, (0.003, 0.003), True),
    ("stride length, SD of the error", "m", None, (0.006, 0.012), True),
    ("lateral placement, error at N = 6 over N = 3", "1", None, (1.5, None), False),
    ("stride length, largest over smallest error, N = 3 to 6", "1", None, (1.15, None), True),
)


def _published_errors(seed: int) -> dict[str, Float]:
    """Return errors of stride length of the strapdown methods between force events, one trial, both feet, m."""
    walk = _trial(seed, 0, _MODELS["nominal"])
    errors: dict[str, list[Float]] = {"flat": [], "published": []}
    for side in SIDES:
        heel, forefoot = (walk.recording.sensors[f"{part}_{side}"] for part in ("heel", "forefoot"))
        if heel.force_n is None or forefoot.force_n is None:
            raise ValueError("simulated shoes have load cells")
        contact = shoe_contact(heel.force_n[:, 2], forefoot.force_n[:, 2], _RATE_HZ)
        true = walk.truth.feet[side].foothold_m[:, :2]
        for mode, found in errors.items():
            pose = shoe_pose(
                (heel.gyroscope_radps, heel.accelerometer_mps2),
                (forefoot.gyroscope_radps, forefoot.accelerometer_mps2),
                contact,
                _RATE_HZ,
                ShoeGeometry(),
                mode="flat" if mode == "flat" else "published",
            )
            holds = np.array([pose.heel_m[a:b, :2].mean(axis=0) for a, b in contact.core])
            if len(holds) != len(true):
                return {name: np.full(1, np.nan) for name in errors}
            length = np.linalg.norm(np.diff(holds, axis=0), axis=1)
            found.append(length - np.linalg.norm(np.diff(true, axis=0), axis=1))
    return {mode: np.concatenate(found)[1:-1] for mode, found in errors.items()}


def _placement(seeds: Sequence[int], data: Data) -> Values:
    found: dict[str, list[float]] = {}
    for seed in seeds:
        for model, errors in _MODELS.items():
            for name, value in _scores(subject(seed, errors)).items():
                found.setdefault(f"{name}, {model}", []).append(value)
        for mode, error in _published_errors(seed).items():
            found.setdefault(f"stride length, mean error of the {mode} strapdown", []).append(
                float(error.mean())
            )
    ideal = _windows(subject(10_000, "ideal"), 3)
    exact = {
        "lateral placement, rms error without sensor errors": np.array([_rms(ideal[0] - ideal[1])]),
        "stride length, rms error without sensor errors": np.array([_rms(ideal[2] - ideal[3])]),
    }
    return {name: np.array(values) for name, values in found.items()} | exact


FOOT_PLACEMENT = Protocol(
    name="foot_placement",
    title="Foot placement against the sliding average path",
    source="Schepers 2009, chapter 3: table 3.1, figures 3.3 to 3.5, section 3.3",
    what="Simulated people walk three trials of 16 steps; footholds of both feet from inertial sensors alone, "
    "put through the same windows as the true ones. A seed is a person; the median person is judged, as the "
    "published figures are means over persons. The first and last strides count only where it says so.",
    figures=(
        *(
            Figure(f"{name}, {model}", unit, limits[i], published, at_most, "median")
            for i, model in enumerate(_MODELS)
            for name, unit, published, limits, at_most in _TABLE
        ),
        Figure("stride length, mean error of the flat strapdown", "m", 0.003, judged_by="median"),
        Figure("stride length, mean error of the published strapdown", "m", -0.020, judged_by="median"),
        Figure("lateral placement, rms error without sensor errors", "m", 0.0002),
        Figure("stride length, rms error without sensor errors", "m", 0.001),
    ),
    measure=_placement,
)
