"""Coils for a shoe and how the relative-pose filter is set from foot to foot (Schepers 2009, F-35; method page 7.4)."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from estimators.magnetic._coil import Coil, Source

SHOE_PARAMETERS: Mapping[str, Any] = MappingProxyType(
    {
        "current_a": 1.36,
        "force_sigma_mps2": 0.03,
        "rate_sigma_radps": 0.018,
        "position_limit_m": 0.007,
        "attitude_limit_deg": 2.0,
        "mounting_direction": (0.0, -1.0, 0.0),
    }
)
"""For `RelativePoseFilter`, source on the left shoe with x to the toes: the right foot is to the right.

Noise above that of the sensors: samples at 100 Hz leave something of what a foot does between them. The limits are
lower than for other segments because a step is to be reported to a centimetre.
"""


def shoe_source() -> Source:
    """Return three coils of 7.5 cm radius, 6 cm out along their axes: 1.2 A m^2 at 1.36 A reach a metre (page 7.4)."""
    return Source(
        tuple(Coil(50.0, 0.075, tuple((0.06 * axis).tolist()), tuple(axis.tolist())) for axis in np.eye(3)),
        current_limit_a=1.5,
    )
