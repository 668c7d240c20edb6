"""A ferromagnetic object as the dipole that a field induces in a sphere (method page on the measurement model, 4.9)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from estimators.errors import SetupError
from estimators.magnetic._coil import dipole_field
from estimators.magnetic._loop_kernel import MU0_TM_PER_A
from estimators.recording import Float


@dataclass(frozen=True)
class IronSphere:
    """A magnetisable sphere.

    Attributes
    ----------
    relative_permeability : float
        1000 for structural iron; 0 for the limit of a conductor that still shuts the field out.
    """

    radius_m: float = 0.0454
    relative_permeability: float = 1000.0

    def __post_init__(self) -> None:
        if self.radius_m <= 0.0 or self.relative_permeability < 0.0:
            raise SetupError("an iron sphere needs a radius above zero and a permeability of zero or more")

    @classmethod
    def of_cylinder(
        cls, radius_m: float, height_m: float, relative_permeability: float = 1000.0
    ) -> "IronSphere":
        """Return the sphere of the same volume as a cylinder."""
        return cls((0.75 * radius_m**2 * height_m) ** (1.0 / 3.0), relative_permeability)

    @property
    def coupling(self) -> float:
        """(mu_r - 1)/(mu_r + 2): 1 for soft iron, -1/2 for a flux-excluding conductor."""
        return (self.relative_permeability - 1.0) / (self.relative_permeability + 2.0)

    def disturbance(self, field_at_object_t: ArrayLike, object_to_point_m: ArrayLike) -> Float:
        """Return the field (T) that the object adds at points, shape (..., 3).

        Parameters
        ----------
        field_at_object_t : array_like, shape (..., 3)
            Undisturbed field at the centre of the object.
        object_to_point_m : array_like, shape (..., 3)
            Inside the object the value at its surface is given: a sensor is never inside.
        """
        field = np.asarray(field_at_object_t, dtype=np.float64)
        offset = np.asarray(object_to_point_m, dtype=np.float64)
        distance = np.linalg.norm(offset, axis=-1, keepdims=True)
        outside = offset * np.maximum(1.0, self.radius_m / np.maximum(distance, 1e-9))
        moment = self.coupling * 4.0 * math.pi * self.radius_m**3 * field / MU0_TM_PER_A
        return dipole_field(moment, outside)
