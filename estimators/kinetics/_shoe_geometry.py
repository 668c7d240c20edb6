"""Where things are in an instrumented shoe."""

from dataclasses import dataclass

import numpy as np

from estimators.recording import Float

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class ShoeGeometry:
    """Where things are in a shoe, metres.

    The heel frame has its origin in the heel sensor, x to the toes, y left, z up while the foot is flat; the
    forefoot frame has its origin in the hinge (first metatarsal head) and equals the heel frame when flat.

    Attributes
    ----------
    sensor_height_m : float
        Of both sensors' centres above the ground while flat.
    rear_edge_m, hinge_m, ankle_m, shoe_length_m : float or tuple
        In the heel frame: x of the rear edge of the sole; the hinge; the ankle.
    forefoot_sensor_m, toe_edge_m : float
        Ahead of the hinge, in the forefoot frame.
    plate_distance_m : float
        Between the points where the heel and the forefoot plate carry the load.
    """

    sensor_height_m: float = 0.030
    rear_edge_m: float = -0.04
    hinge_m: float = 0.15
    forefoot_sensor_m: float = 0.03
    toe_edge_m: float = 0.07
    ankle_m: Vector = (0.03, 0.0, 0.10)
    shoe_length_m: float = 0.30
    plate_distance_m: float = 0.17

    @property
    def rear_point_m(self) -> Float:
        """Rear edge of the sole in the heel frame, shape (3,)."""
        return np.array([self.rear_edge_m, 0.0, -self.sensor_height_m])

    @property
    def hinge_point_m(self) -> Float:
        """Hinge in the heel frame, shape (3,)."""
        return np.array([self.hinge_m, 0.0, 0.0])

    @property
    def toe_point_m(self) -> Float:
        """Toe edge of the sole in the forefoot frame, shape (3,)."""
        return np.array([self.toe_edge_m, 0.0, -self.sensor_height_m])

    @property
    def forefoot_sensor_point_m(self) -> Float:
        """Forefoot sensor in the forefoot frame, shape (3,)."""
        return np.array([self.forefoot_sensor_m, 0.0, 0.0])
