"""The samples of a calibration by movement, and what can be said against them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.calibration._placement import MisplacedError, PlacementFinding
from estimators.calibration._placement import check_segments as forearm_and_upper_arm
from estimators.calibration._rest import Verdict, mostly, wrapped
from estimators.calibration.movement.joint_axes import AxisEstimate
from estimators.conventions import Placement, Side
from estimators.errors import CalibrationError, ShapeError
from estimators.orientation import OrientationFlag
from estimators.recording import Float
from estimators.sentences import say

_LEAST_RANGE_RAD: Final[dict[str, float]] = {
    "elbow_flexion": math.radians(60.0),
    "pronation": math.radians(50.0),
    "raise_forward": math.radians(40.0),
    "raise_sideways": math.radians(40.0),
}
_PASSIVE_SHARE: Final = 0.45
_TURNED_ROUND_RAD: Final = math.radians(90.0)
_GOOD_RAD: Final = math.radians(6.5)
"""As good as it gets: palm and skin alone make about six."""


class JudgedSession:
    """The samples of a calibration, and what can be said against them."""

    bias: Float
    q_rest: Float

    def __init__(
        self,
        q: Float,
        gyroscope: Float,
        accelerometer: Float,
        placements: Sequence[Placement],
        flags: NDArray[np.uint8] | None,
        time_step_s: float,
    ) -> None:
        sensors, ticks = len(placements), q.shape[1] if q.ndim == 3 else 0
        if q.shape != (sensors, ticks, 4) or gyroscope.shape != (sensors, ticks, 3):
            raise ShapeError(
                f"{q.shape} and {gyroscope.shape} must be ({sensors}, K, 4) and ({sensors}, K, 3)"
            )
        if accelerometer.shape != gyroscope.shape:
            raise ShapeError(
                f"accelerometer {accelerometer.shape} must be as the gyroscope {gyroscope.shape}"
            )
        self.q, self.gyroscope, self.accelerometer = q, gyroscope, accelerometer
        self.flags = np.zeros((sensors, ticks), dtype=np.uint8) if flags is None else flags
        self.placements = tuple(placements)
        self.step_s = time_step_s
        self.own_heading = mostly(self.flags, OrientationFlag.HEADING_NOT_TRUSTED)
        self.verdict = Verdict()
        self.axes: list[AxisEstimate] = []

    def rate_earth(self, sensor: int, ticks: tuple[int, int]) -> Float:
        """Rate of a sensor in its earth frame, bias taken out, shape (N, 3)."""
        part = slice(*ticks)
        return rotation.rotate(self.q[sensor, part], self.gyroscope[sensor, part] - self.bias[sensor])

    def check_segments(self, sides: Sequence[Side], movements: Mapping[str, tuple[int, int]]) -> None:
        """Refuse sensors of upper arm and forearm that are swapped."""
        swapped: list[PlacementFinding] = []
        for side in sides:
            upper, fore = (self.placements.index(p) for p in limb_of(side)[:2])
            parts = [movements[f"{kind}_{side}"] for kind in ("elbow_flexion", "pronation")]
            swapped += forearm_and_upper_arm(
                side,
                [self.rate_earth(upper, part) for part in parts],
                [self.rate_earth(fore, part) for part in parts],
            )
        if swapped:
            raise MisplacedError(swapped)

    def judge_ranges(self, axes: Iterable[AxisEstimate], assisted: bool) -> None:
        """Refuse movements that were too small."""
        for axis in axes:
            kind, _, side = axis.name.rpartition("_")
            least = _LEAST_RANGE_RAD[kind] * (_PASSIVE_SHARE if assisted else 1.0)
            if axis.range_rad < least:
                raise CalibrationError(
                    say(
                        "calibration.movement_small",
                        side=side,
                        kind=kind,
                        angle_rad=axis.range_rad,
                        least_rad=least,
                    ),
                    redo=[kind],
                )

    def judge_sigma(self, sigma: Mapping[Placement, float], facing_sigma: float) -> None:
        """Lower the score by how little is known."""
        # What the hand adds is the wrist at rest, which larger movements do not tell.
        sigma = {p: value for p, value in sigma.items() if not p.startswith("hand")}
        worst = max([*sigma.values(), 0.0 if math.isnan(facing_sigma) else facing_sigma])
        if worst > _GOOD_RAD:
            self.verdict.score *= _GOOD_RAD / worst
        for placement, value in sigma.items():
            if value > _GOOD_RAD:
                self.verdict.reasons.append(say("calibration.uncertain", where=[placement], sigma_rad=value))

    def judge_trunk(self, facing: float, facing_sigma: float) -> None:
        """Say where the facing comes from, and what the trunk sensor thinks of it."""
        if "sternum" not in self.placements or math.isnan(facing_sigma):
            if math.isnan(facing_sigma) and not self.own_heading.all():
                self.verdict.lower(0.7, say("calibration.not_raised"))
            return
        outward = rotation.rotate(self.q_rest[self.placements.index("sternum")], [0.0, 0.0, 1.0])
        away = abs(wrapped(math.atan2(outward[1], outward[0]) - facing))
        if math.hypot(outward[0], outward[1]) > 0.5 and away > _TURNED_ROUND_RAD:
            self.verdict.reasons.append(say("calibration.faces_backward", where=["sternum"]))


def upper_arm_of(side: Side) -> Placement:
    """Return the placement on the upper arm."""
    return "upper_arm_left" if side == "left" else "upper_arm_right"


def limb_of(side: Side) -> tuple[Placement, Placement, Placement]:
    """Return the placements of an arm from upper arm to hand."""
    if side == "left":
        return "upper_arm_left", "forearm_left", "hand_left"
    return "upper_arm_right", "forearm_right", "hand_right"
