"""The mechanical cost of walking: energy of the centre of mass and how much of it is recovered."""

from dataclasses import dataclass

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ShapeError
from estimators.recording import Float


@dataclass(frozen=True)
class WalkingWork:
    """External work over a stretch of walking.

    Attributes
    ----------
    forward_j, vertical_j, external_j : float
        Sums of what forward (and sideways) kinetic, potential with vertical kinetic, and total energy gain.
    recovery : float
        Part that the pendulum gives back, 0 to 1: `(forward + vertical - external) / (forward + vertical)`.
    """

    forward_j: float
    vertical_j: float
    external_j: float
    recovery: float
    distance_m: float

    @property
    def external_j_per_m(self) -> float:
        """External work a metre walked."""
        return self.external_j / self.distance_m if self.distance_m > 0.0 else float("nan")


def walking_work(position_m: Float, velocity_mps: Float, mass_kg: float) -> WalkingWork:
    """Return the external work of the centre of mass, best over whole strides.

    Parameters
    ----------
    position_m, velocity_mps : ndarray, shape (N, 3)

    Raises
    ------
    ShapeError
        For fewer than two samples or different shapes.

    Notes
    -----
    Cavagna, Thys and Zamboni (1976): only gains of energy count as work.
    """
    if position_m.shape != velocity_mps.shape or position_m.shape[0] < 2:
        raise ShapeError("work needs positions and velocities of the same two samples or more")
    forward = 0.5 * mass_kg * np.sum(velocity_mps[:, :2] ** 2, axis=1)
    vertical = mass_kg * GRAVITY_MPS2 * position_m[:, 2] + 0.5 * mass_kg * velocity_mps[:, 2] ** 2
    gains = [
        float(np.maximum(np.diff(energy), 0.0).sum()) for energy in (forward, vertical, forward + vertical)
    ]
    parts = gains[0] + gains[1]
    way = float(np.linalg.norm(np.diff(position_m[:, :2], axis=0), axis=1).sum())
    return WalkingWork(gains[0], gains[1], gains[2], (parts - gains[2]) / parts if parts > 0.0 else 0.0, way)
