"""Elbows and wrists keep the headings of a body network together; see `estimators.arm.JointHeadingConstraint`."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.arm import HingeJoint, JointHeadingConstraint
from estimators.conventions import SIDES
from estimators.orientation import OrientationFlag
from estimators.recording import Float

_JOINTS: Final[tuple[tuple[HingeJoint, str, str], ...]] = (
    ("humerus_forearm", "upper_arm", "forearm"),
    ("forearm_hand", "forearm", "hand"),
)
TRUSTED_RAD: Final = math.radians(8.0)
"""Relative heading known better than this: angles of the joint lose the flag HEADING_NOT_TRUSTED."""
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_INVALID = int(OrientationFlag.INVALID)


class ConstrainedSegments(NamedTuple):
    """Segments after the correction, shapes as given, and where a joint knows its heading, shape (K, J)."""

    q_room_segment: Float
    omega_room_radps: Float
    sigma_room_rad: Float
    is_trusted: NDArray[np.bool_]


class JointHeadings:
    """Turns forearms and hands about the vertical so that elbows and wrists keep their rule."""

    def __init__(self, placements: Sequence[str], time_step_s: float) -> None:
        worn = tuple(placements)
        found = [
            (kind, side, worn.index(f"{parent}_{side}"), worn.index(f"{child}_{side}"))
            for side in SIDES
            for kind, parent, child in _JOINTS
            if f"{parent}_{side}" in worn and f"{child}_{side}" in worn
        ]
        self.names = tuple(f"{kind}_{side}" for kind, side, *_ in found)
        self._parent = np.array([parent for *_, parent, _ in found], dtype=np.int64)
        self._child = np.array([child for *_, child in found], dtype=np.int64)
        self._constraint = JointHeadingConstraint([kind for kind, *_ in found], time_step_s)

    def reset(self) -> None:
        """Begin again, as after a calibration."""
        self._constraint.reset()

    def apply(
        self, q: Float, omega: Float, sigma: Float, flags: NDArray[np.uint8], first_tick: int
    ) -> ConstrainedSegments:
        """Correct the next ticks; arrays of shape (K, S, ...) are not changed but copied.

        `is_trusted` of the result has shape (K, J), one column a joint of `names`.
        """
        parent, child = self._parent, self._child
        either = flags[:, parent] | flags[:, child]
        found = self._constraint.update(
            np.ascontiguousarray(q[:, parent]),
            np.ascontiguousarray(q[:, child]),
            first_tick,
            (either & _INVALID) == 0,
            (either & (_NO_HEADING | _DISTURBED)) == 0,
        )
        q, omega, sigma = q.copy(), omega.copy(), sigma.copy()
        turn = np.zeros(q.shape[:2])
        for j in range(len(self.names)):
            p, c = parent[j], child[j]
            # Elbows come before wrists: a hand takes its forearm's turn along.
            turn[:, c] = turn[:, p] + found.correction_rad[:, j]
            about = rotation.about_z(turn[:, c])
            q[:, c] = rotation.multiply(about, q[:, c])
            omega[:, c] = rotation.rotate(about, omega[:, c])
            bounded = np.hypot(sigma[:, p, 2], found.sigma_rad[:, j])
            sigma[:, c, 2] = np.fmin(sigma[:, c, 2], bounded)
        return ConstrainedSegments(q, omega, sigma, found.sigma_rad < TRUSTED_RAD)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next call depends on."""
        return {f"joint_headings.{name}": values for name, values in self._constraint.state().items()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue where the instance that gave `state` stood."""
        prefix = "joint_headings."
        self._constraint.restore(
            {k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)}
        )
