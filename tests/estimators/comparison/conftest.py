"""A planar arm in closed form: minimum-jerk repetitions with known bounds, angles and positions."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from estimators.comparison import Repetition, Trajectory

FLEXION = "humerus_forearm_{side}_zxy_flexion"


def minimum_jerk(time_s: np.ndarray, duration_s: float) -> np.ndarray:
    share = np.clip(time_s / duration_s, 0.0, 1.0)
    return share**3 * (10 - 15 * share + 6 * share**2)


@dataclass(frozen=True)
class Planar:
    """What was made, and the truth beside it."""

    trajectory: Trajectory
    truth: list[Repetition]
    side: str
    reach_m: float

    @property
    def primary(self) -> str:
        return FLEXION.format(side=self.side)


def make_planar(
    repetitions: int = 5,
    out_s: float = 1.2,
    hold_s: float = 0.3,
    rest_s: float = 1.0,
    sizes: float | list[float] = 1.0,
    noise_rad: float = 0.0,
    tremor_rad: float = 0.0,
    lean_rad: float = 0.1,
    side: str = "right",
    reach_m: float = 0.55,
    lead_s: float = 2.0,
    rate_hz: float = 100.0,
    seed: int = 0,
) -> Planar:
    generator = np.random.default_rng(seed)
    each = sizes if isinstance(sizes, list) else [sizes] * repetitions
    cycle_s = 2 * out_s + hold_s + rest_s
    time_s = np.arange(round((2 * lead_s + len(each) * cycle_s) * rate_hz)) / rate_hz
    activity = np.zeros_like(time_s)
    truth = []
    for number, size in enumerate(each, start=1):
        start_s = lead_s + (number - 1) * cycle_s
        end_s = start_s + 2 * out_s + hold_s
        back = minimum_jerk(time_s - start_s - out_s - hold_s, out_s)
        activity += size * (minimum_jerk(time_s - start_s, out_s) - back)
        truth.append(Repetition(number, start_s, end_s))
    elevation = 0.3 + 1.0 * activity
    flexion = 0.2 + 0.9 * activity + tremor_rad * np.sin(2 * np.pi * 5.0 * time_s)
    outward = -1.0 if side == "right" else 1.0
    zero = np.zeros_like(time_s)
    shoulder = np.stack([zero, outward * 0.18 + zero, 1.4 + zero], axis=1)
    upper = np.stack([np.sin(elevation), 0.1 * outward * activity, -np.cos(elevation)], axis=1)
    fore = np.stack([np.sin(elevation + flexion), zero, -np.cos(elevation + flexion)], axis=1)
    elbow = shoulder + 6 / 11 * reach_m * upper
    wrist = elbow + 5 / 11 * reach_m * fore
    columns = {
        f"thorax_humerus_{side}_yxy_elevation": elevation,
        FLEXION.format(side=side): flexion,
        f"humerus_forearm_{side}_zxy_pronation": 1.5 + 0.4 * activity,
        "trunk_lean_forward_rad": lean_rad * activity,
        "trunk_lean_lateral_rad": -outward * 0.05 * activity,
    }
    for name, point in (("shoulder", shoulder), ("elbow", elbow), ("wrist", wrist)):
        columns.update({f"{name}_{side}.{axis}": point[:, i] for i, axis in enumerate("xyz")})
    values = np.stack(list(columns.values()), axis=1)
    values += generator.normal(0.0, noise_rad, values.shape) if noise_rad else 0.0
    sigma = np.where([("." in name) for name in columns], np.nan, 0.01) * np.ones_like(values)
    trajectory = Trajectory(time_s, tuple(columns), values, sigma, np.isfinite(values))
    return Planar(trajectory, truth, side, reach_m)


@pytest.fixture
def planar() -> Callable[..., Planar]:
    return make_planar
