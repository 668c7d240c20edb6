"""The mistakes that are distinguished: ways to name and sign three axes, and units taken for one another."""

import math
from itertools import permutations, product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2

SIGNED_PERMUTATIONS: Final = np.stack(
    [
        np.eye(3)[list(order)] * np.array(signs)[:, None]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
)
"""All 48 ways to name and sign three axes, shape (48, 3, 3): 24 rotations, 24 reflections; the identity is first."""
IS_PROPER: Final[NDArray[np.bool_]] = np.linalg.det(SIGNED_PERMUTATIONS) > 0.0
"""Which of them are rotations, shape (48,)."""
SCALES: Final = (
    1.0,
    180.0 / math.pi,
    math.pi / 180.0,
    GRAVITY_MPS2,
    1.0 / GRAVITY_MPS2,
    100.0,
    0.01,
    1e3,
    1e-3,
    1e6,
    1e-6,
)
"""What a gyroscope may have to be multiplied with: units taken for one another, and lost prefixes."""
