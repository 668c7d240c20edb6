"""Shared steps of every calibration from a held pose: mean orientation, verdict, words."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import Placement
from estimators.errors import CalibrationError
from estimators.orientation import OrientationFlag
from estimators.recording import Float
from estimators.sentences import say

SWAY_RAD = math.radians(3.0)
_MOVED_RAD = math.radians(12.0)


@dataclass
class Verdict:
    """Collects what lowers the score."""

    score: float = 1.0
    reasons: list[str] = field(default_factory=list)

    def lower(self, factor: float, reason: str) -> None:
        """Multiply the score and say why."""
        self.score *= factor
        self.reasons.append(reason)


def wrapped(angle_rad: float) -> float:
    """Return the angle within half a turn."""
    return float(math.remainder(angle_rad, 2.0 * math.pi))


def mostly(flags: NDArray[np.uint8], flag: OrientationFlag) -> NDArray[np.bool_]:
    """Return which sensors carry a flag more often than not, shape (S, K) to (S,)."""
    return np.asarray(np.mean((flags & int(flag)) != 0, axis=1) > 0.5)


def mean_orientation(
    q: Float,
    flags: NDArray[np.uint8],
    placement: Placement,
    verdict: Verdict,
    *,
    seated: bool = False,
) -> Float:
    """Average one sensor's orientation robustly and judge how much it moved."""
    usable = np.isfinite(q).all(axis=-1) & ((flags & int(OrientationFlag.INVALID)) == 0)
    if not usable.any():
        raise CalibrationError(say("calibration.no_data", where=[placement]))
    retained = q[usable]
    centre = rotation.mean(retained)
    away = rotation.angle_between(centre, retained)
    # The middle half decides where the pose was; what lies far from it was a twitch.
    close = away <= 2.0 * np.median(away) + 1e-9
    centre = rotation.mean(retained[close])
    spread = float(np.quantile(rotation.angle_between(centre, retained), 0.9))
    if spread > _MOVED_RAD:
        if seated:
            raise CalibrationError(say("calibration.seat_moved", where=[placement], angle_rad=spread))
        raise CalibrationError(say("calibration.pose_moved", where=[placement], angle_rad=spread))
    if spread > SWAY_RAD:
        verdict.lower(SWAY_RAD / spread, say("calibration.swayed", where=[placement]))
    return centre
