"""The legs of one session: which joints the worn sensors show, one call."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import SIDES
from estimators.errors import SetupError, ShapeError
from estimators.leg._kernel import LegTable, leg_kernel
from estimators.leg._names import JOINTS
from estimators.recording import Float


class LegModel:
    """Hips, knees and ankles of which both segments carry a sensor.

    Parameters
    ----------
    placements : sequence of Placement
        Worn sensors; orientations are given in this order. What is no part of a leg is not used.

    Attributes
    ----------
    angles : tuple of str
        Names of what these placements show, in the order of `LEG_ANGLES`; empty when they show no joint of a leg.

    Raises
    ------
    SetupError
        If a placement is given twice.
    """

    def __init__(self, placements: Sequence[str]) -> None:
        worn = tuple(placements)
        if len(set(worn)) != len(worn):
            raise SetupError(f"a placement occurs twice in {worn}; each sensor needs its own")
        names: list[str] = []
        segments, lefts, signs = [], [], []
        for side in SIDES:
            for name, joint in JOINTS.items():
                parent, child = joint.parent.format(side=side), joint.child.format(side=side)
                if parent in worn and child in worn:
                    names += [f"{name}_{side}_{part}" for part in joint.parts]
                    segments.append((worn.index(parent), worn.index(child)))
                    lefts.append(side == "left")
                    signs.append(joint.signs)
        self.angles = tuple(names)
        self._segments = len(worn)
        self._table = LegTable(
            np.array(segments, dtype=np.int64).reshape(-1, 2),
            np.array(lefts, dtype=np.uint8),
            np.array(signs, dtype=np.float64).reshape(-1, 2),
        )

    def write(
        self,
        q_room_segment: Float,
        sigma_room_rad: Float,
        segment_flags: NDArray[np.uint8],
        angle_rad: Float,
        angle_sigma_rad: Float,
        angle_flags: NDArray[np.uint8],
    ) -> None:
        """Fill the last columns of the angles, as many as `angles` has names, tick by tick on its own.

        Parameters
        ----------
        q_room_segment : ndarray, shape (K, S, 4)
            In the order of the placements; NaN gives NaN.
        sigma_room_rad : ndarray, shape (K, S, 3)
            One-sigma about the room axes, independent between sensors; NaN where unknown.
        segment_flags : ndarray of uint8, shape (K, S)
            `OrientationFlag` bits of the sensors.
        angle_rad, angle_sigma_rad : ndarray, shape (K, A)
            Filled.
        angle_flags : ndarray of uint8, shape (K, A)
            Filled: flags of both segments of the joint, and SINGULAR for first and last angle near the singularity.

        Raises
        ------
        ShapeError
            If an array does not fit the placements.
        """
        if not self.angles:
            return
        ticks, columns = angle_rad.shape
        shapes = (q_room_segment.shape, sigma_room_rad.shape, segment_flags.shape)
        fitting = ((ticks, self._segments, 4), (ticks, self._segments, 3), (ticks, self._segments))
        if shapes != fitting or columns < len(self.angles):
            raise ShapeError(f"the legs got {shapes} and {columns} angles; they need {fitting}")
        leg_kernel(
            q_room_segment,
            sigma_room_rad,
            segment_flags,
            self._table,
            angle_rad,
            angle_sigma_rad,
            angle_flags,
        )
