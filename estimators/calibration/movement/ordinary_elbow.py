"""Mounting and heading of an arm from ordinary movement, by what every elbow keeps to.

After a standing pose the inclination of upper arm and forearm is known, but where each sensor faces about the
vertical is the mounting rule's word, and without a compass the two headings drift apart. Any movement that bends
the elbow in some postures tells both: the flexion axis of the humerus and the long axis of the forearm stay at a
nearly constant angle (the carrying angle).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import Side
from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float
from estimators.sentences import say

_RATE_HZ: Final = 10.0
_KNOT_S: Final = 15.0
_RULE_RAD: Final = math.radians(45.0)
"""How far a sensor may face off the mounting rule; starts cover half a turn."""
_TILT_RAD: Final = math.radians(4.0)
_DRIFT_RAD_PER_ROOT_S: Final = math.radians(1.0)
_CARRYING_RAD: Final = math.radians(10.0)
_CARRYING_SIGMA_RAD: Final = math.radians(5.0)
_RULE_SIGMA_RAD: Final = math.radians(4.0)
"""How well an elbow keeps to it: skin, and the bones' own obliquity."""
_INDEPENDENT_S: Final = 2.0
"""Errors of skin and posture come back with every movement: samples nearer than this say the same."""
_RANGE_SIGMA_RAD: Final = math.radians(4.0)
_FLEXION_RAD: Final = (math.radians(-3.0), math.radians(150.0))
_PRONATION_RAD: Final = (math.radians(-10.0), math.radians(185.0))
_LEAST_BEND_RAD: Final = math.radians(30.0)
_LEAST_BENT_S: Final = 1.5
_STARTS_RAD: Final = tuple(math.radians(a) for a in (-90.0, -45.0, 0.0, 45.0, 90.0))


@dataclass(frozen=True)
class OrdinaryElbow:
    """What ordinary movement showed of one arm.

    Attributes
    ----------
    q_upper_correction, q_forearm_correction : ndarray, shape (4,)
        Multiply the mountings from the right: `q_sensor_segment * correction`.
    upper_turn_rad : float
        Turn about the vertical of the upper arm's earth frame: its sensor faced so far off the rule.
    knots_s, forearm_turn_rad : ndarray, shape (J,)
        The same of the forearm over time, to be interpolated: its own, and the drift against the upper arm.
    carrying_rad : float
        The constant angle that fits.
    residual_rad : float
        Root mean square of how far the elbow was off it.
    sigma_rad : float
        Expected error of the turn that is known least.
    """

    q_upper_correction: Float
    q_forearm_correction: Float
    upper_turn_rad: float
    knots_s: Float
    forearm_turn_rad: Float
    carrying_rad: float
    residual_rad: float
    sigma_rad: float


def elbow_from_movement(
    side: Side,
    q_upper: Float,
    q_forearm: Float,
    time_s: Float,
    usable: NDArray[np.bool_] | None = None,
    *,
    pose_s: float = 0.0,
) -> OrdinaryElbow:
    """Find how the sensors of an arm face from any movement of the elbow.

    Parameters
    ----------
    q_upper, q_forearm : ndarray, shape (K, 4)
        Segments in the room under the calibration of a standing pose.
    time_s : ndarray, shape (K,)
    usable : ndarray of bool, shape (K,), optional
        False where either is held or lost.
    pose_s : float
        When the standing pose was held: drift counts from there.

    Raises
    ------
    CalibrationError
        If the elbow was hardly bent.

    Notes
    -----
    A wrong heading in the pose goes into the mounting, so one turn d acts twice: the corrected segment is
    `R_z(d) q R_z(-d)`, unchanged in the pose. The flexion axis of the humerus then lies at a wrong place about its
    long axis; the long axis of the forearm is free of it. Unknown are the upper arm's turn, the forearm's over time
    (a random walk between knots), small tilts of both, and the constant carrying angle. What no elbow does
    (bending backward, turning the palm all round) costs too: it decides between solutions half a turn apart.
    Laidig, Lehmann, Begin and Seel (2019) use the first of these rules; parameters and priors are the house's.
    """
    if q_upper.shape != q_forearm.shape or q_upper.shape != (len(time_s), 4):
        raise ShapeError(
            f"orientations {q_upper.shape} and {q_forearm.shape} must both be ({len(time_s)}, 4)"
        )
    picked = _pick(q_upper, q_forearm, time_s, usable)
    one, other, at = q_upper[picked], q_forearm[picked], time_s[picked]
    bend = np.arccos(
        np.clip(np.sum(rotation.rotate(one, _Z) * rotation.rotate(other, _Z), axis=1), -1.0, 1.0)
    )
    if np.count_nonzero(bend > _LEAST_BEND_RAD) < _LEAST_BENT_S * _RATE_HZ:
        raise CalibrationError(say("calibration.elbow_hardly_bent", side=side))
    knots = np.arange(at[0], at[-1] + _KNOT_S, _KNOT_S)
    model = _Model(side, one, other, at, knots, pose_s)
    best = None
    for upper in _STARTS_RAD:
        for fore in _STARTS_RAD:
            start = np.zeros(model.size)
            start[0], start[_FIXED:] = upper, fore
            start[_CARRY] = _CARRYING_RAD
            # A coarse look first: most starts are hopeless.
            coarse = scipy.optimize.least_squares(model.residual, start, max_nfev=6)
            if best is None or coarse.cost < best.cost:
                best = coarse
    assert best is not None
    found = scipy.optimize.least_squares(model.residual, best.x, max_nfev=60)
    return model.result(found)


_Z: Final = np.array([0.0, 0.0, 1.0])
_CARRY: Final = 5
_FIXED: Final = 6
"""Upper turn, tilts of upper arm (2) and forearm (2), carrying angle; then the knots."""


class _Model:
    """Residuals of one arm, each over its sigma."""

    def __init__(self, side: Side, one: Float, other: Float, at: Float, knots: Float, pose_s: float) -> None:
        self.sign = 1.0 if side == "right" else -1.0
        self.one, self.other, self.at, self.knots = one, other, at, knots
        self.size = _FIXED + len(knots)
        self.pose_knot = int(np.argmin(np.abs(knots - pose_s)))
        step = float(np.median(np.diff(at))) if len(at) > 1 else 1.0
        self.weight = math.sqrt(min(1.0, step / _INDEPENDENT_S))

    def segments(self, x: Float) -> tuple[Float, Float]:
        """Return corrected orientations, shape (N, 4) each."""
        upper, fore = self.corrections(x)
        turn = np.interp(self.at, self.knots, x[_FIXED:])
        return (
            rotation.multiply(rotation.about_z(x[0]), rotation.multiply(self.one, upper)),
            rotation.multiply(rotation.about_z(turn), rotation.multiply(self.other, fore)),
        )

    def corrections(self, x: Float) -> tuple[Float, Float]:
        """Return what multiplies the mountings from the right."""
        in_pose = x[_FIXED + self.pose_knot]
        turn, upper_x, upper_y, fore_x, fore_y = x[:_CARRY]
        upper = rotation.multiply(rotation.about_z(-turn), rotation.exp(np.array([upper_x, upper_y, 0.0])))
        fore = rotation.multiply(rotation.about_z(-in_pose), rotation.exp(np.array([fore_x, fore_y, 0.0])))
        return upper, fore

    def angles(self, x: Float) -> tuple[Float, Float, Float]:
        """Return flexion, carrying and pronation of every sample, mirrored to a right arm, shape (N,) each."""
        upper, fore = self.segments(x)
        r = rotation.to_matrix(rotation.multiply(rotation.conjugate(upper), fore))
        # Flexion about -y, carrying about x, pronation about z of the forearm: on the right: R = Ry(-f) Rx(-c) Rz(p).
        carrying = np.arcsin(np.clip(r[:, 1, 2], -1.0, 1.0))
        flexion = -np.arctan2(r[:, 0, 2], r[:, 2, 2])
        pronation = np.arctan2(r[:, 1, 0], r[:, 1, 1])
        return flexion, self.sign * carrying, self.sign * pronation

    def residual(self, x: Float) -> Float:
        """Return everything that should be small, data softly and priors squarely."""
        flexion, carrying, pronation = self.angles(x)
        # Unwrapped about the middle of the human range.
        pronation = np.remainder(pronation - 0.5 * np.pi + np.pi, 2.0 * np.pi) - 0.5 * np.pi
        drift = np.diff(x[_FIXED:]) / (_DRIFT_RAD_PER_ROOT_S * math.sqrt(_KNOT_S))
        return np.concatenate(
            (
                self.weight * _soft((carrying - x[_CARRY]) / _RULE_SIGMA_RAD),
                self.weight * _beyond(flexion, _FLEXION_RAD) / _RANGE_SIGMA_RAD,
                self.weight * _beyond(pronation, _PRONATION_RAD) / _RANGE_SIGMA_RAD,
                [x[0] / _RULE_RAD, x[_FIXED + self.pose_knot] / _RULE_RAD],
                x[1:_CARRY] / _TILT_RAD,
                [(x[_CARRY] - _CARRYING_RAD) / _CARRYING_SIGMA_RAD],
                drift,
            )
        )

    def result(self, found: "scipy.optimize.OptimizeResult") -> OrdinaryElbow:
        """Return what was found as people and pipelines use it."""
        x = found.x
        upper, fore = self.corrections(x)
        _, carrying, _ = self.angles(x)
        covariance = np.linalg.pinv(found.jac.T @ found.jac)
        stated = [0, _FIXED + self.pose_knot]
        return OrdinaryElbow(
            rotation.positive(upper),
            rotation.positive(fore),
            float(x[0]),
            self.knots,
            np.asarray(x[_FIXED:]),
            float(x[_CARRY]),
            float(np.sqrt(np.mean((carrying - x[_CARRY]) ** 2))),
            float(np.sqrt(np.diag(covariance)[stated].max())),
        )


def _pick(
    q_upper: Float, q_forearm: Float, time_s: Float, usable: NDArray[np.bool_] | None
) -> NDArray[np.intp]:
    """Return ten samples a second that can be used."""
    good = np.isfinite(q_upper).all(axis=1) & np.isfinite(q_forearm).all(axis=1)
    if usable is not None:
        good &= usable
    step = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 1.0
    return np.flatnonzero(good)[:: max(1, round(1.0 / (_RATE_HZ * step)))]


def _soft(values: Float) -> Float:
    """Return residuals whose square grows only linearly beyond one sigma; priors keep theirs."""
    return np.asarray(np.sign(values) * np.sqrt(2.0 * (np.sqrt(1.0 + values**2) - 1.0)))


def _beyond(angle: Float, limits: tuple[float, float]) -> Float:
    return np.maximum(angle - limits[1], 0.0) + np.maximum(limits[0] - angle, 0.0)
