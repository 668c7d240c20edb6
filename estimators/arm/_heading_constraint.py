"""Heading drift between two segments bounded by the joint that connects them, without magnetometers.

Filters without a magnetometer give each sensor a heading of its own, which drifts by some degrees a minute. The
elbow bends and turns, but the flexion axis of the upper arm and the long axis of the forearm stay at nearly right
angles (the carrying angle is nearly constant); at the wrist the flexion axis of the forearm stays at nearly right
angles to the palm's forward axis (the hand does not turn in the forearm). Turning the child's frame by the
right heading about the vertical makes that so; a wrong one does not, unless one of the two axes is vertical.

No single posture tells a heading better than the joint keeps its rule. Therefore a Kalman filter estimates beside
the offset what is wrong with the rule: a constant (carrying angle, calibration), the tilt of both axes (which
changes with the posture in another way than the heading does), and a remainder that is forgotten only as the
joint travels through other postures, so that holding still for a minute counts as one look and not as a thousand.
The offset's variance then says what the excitation has really been worth.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import ClassVar, Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arm._heading_kernel import (
    CHILD_TILT,
    CONSTANT,
    DRIFT,
    INITIAL,
    MEMORY,
    PARAMETERS,
    PARENT_TILT,
    POSTURE,
    STATES,
    Carried,
    Corrections,
    constrain,
)
from estimators.errors import SetupError, ShapeError
from estimators.kernels.array_filter import StoredArrays

Float = NDArray[np.float64]
HingeJoint = Literal["humerus_forearm", "forearm_hand"]

_AXES: Final[dict[HingeJoint, tuple[int, int]]] = {"humerus_forearm": (1, 2), "forearm_hand": (1, 0)}
"""Axis of the parent and axis of the child, in our segment axes, that stay at right angles."""
_UPDATE_HZ: Final = 20.0


@dataclass(frozen=True)
class HeadingConstraintParameters:
    """What is assumed of sensors and joint; one-sigma figures, house values.

    Attributes
    ----------
    initial_sigma_rad : float
        Of the offset after the calibration pose: how well two sensors were put on by the rule.
    drift_radps, drift_time_s : float
        Size of the difference of two heading drifts (6 degrees a minute), and how long it lasts.
    walk_rad_per_root_s, walk_rad_per_root_rad, gap_walk_rad_per_root_s : float
        Random walk of the offset with time, with the joint's travel (scale errors), and where samples lack.
    constant_rad, parent_tilt_rad, child_tilt_rad : float
        Carrying angle against the calibration pose; how far the two axes are off in their segments.
    posture_rad, posture_travel_rad, posture_time_s : float
        What else the joint and the skin do, and the travel and time after which it is something else. Twice
        what is expected: repetitions come through the same postures with the same errors, and products of
        small angles are left out of the rule.
    noise_rad : float
        Of one look, twenty a second.
    least_sensitivity : float
        Below this change of the rule with the heading (sine) a posture does not touch the offset.
    reference_rad, reference_time_s : float
        How well magnetometers that are trusted agree on heading, and for how long their error lasts.
    floor_rad : float
        Reported sigma never falls below: errors that come back with every repetition do not average out.
    slew_rate_radps, slew_time_s : float
        How quickly the correction follows the estimate: softly, so that no curve jumps.
    """

    initial_sigma_rad: float = math.radians(10.0)
    drift_radps: float = math.radians(0.1)
    drift_time_s: float = 60.0
    walk_rad_per_root_s: float = math.radians(0.05)
    walk_rad_per_root_rad: float = math.radians(0.2)
    gap_walk_rad_per_root_s: float = math.radians(10.0)
    constant_rad: float = math.radians(3.0)
    parent_tilt_rad: float = math.radians(5.0)
    child_tilt_rad: float = math.radians(5.0)
    posture_rad: float = math.radians(8.0)
    posture_travel_rad: float = math.radians(25.0)
    posture_time_s: float = 60.0
    noise_rad: float = math.radians(1.5)
    least_sensitivity: float = 0.25
    reference_rad: float = math.radians(4.0)
    reference_time_s: float = 10.0
    floor_rad: float = math.radians(2.5)
    slew_rate_radps: float = math.radians(5.0)
    slew_time_s: float = 1.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not (math.isfinite(value) and value > 0.0):
                raise SetupError(f"{name} is {value}; it must be above zero")
        if self.least_sensitivity >= 1.0:
            raise SetupError("least_sensitivity is a sine, below 1")


WRIST_PARAMETERS: Final = HeadingConstraintParameters(
    constant_rad=math.radians(4.0), posture_rad=math.radians(9.0)
)
"""The hand does turn in the forearm by some degrees, passively."""

_DEFAULTS: Final[dict[HingeJoint, HeadingConstraintParameters]] = {
    "humerus_forearm": HeadingConstraintParameters(),
    "forearm_hand": WRIST_PARAMETERS,
}


class HeadingConstraintResult(NamedTuple):
    """What the joints tell of headings; each array shape (K, J).

    Attributes
    ----------
    offset_rad : ndarray
        Estimate: the turn about the vertical that the child needs to fit its parent.
    sigma_rad : ndarray
        One-sigma of what `correction_rad` still leaves: the filter's, its lag behind the estimate, and the
        floor.
    correction_rad : ndarray
        The estimate followed softly: turn the child by this.
    is_informed : ndarray of bool
        False in postures that say nothing of the heading (arm hanging straight) and in gaps: sigma grows.
    residual_rad : ndarray
        How far the joint was off its rule (about the carrying angle); NaN in gaps.
    """

    offset_rad: Float
    sigma_rad: Float
    correction_rad: Float
    is_informed: NDArray[np.bool_]
    residual_rad: Float


class JointHeadingConstraint(StoredArrays):
    """Streams the relative heading of J joints; chunks of any size give the same bits.

    Parameters
    ----------
    joints : sequence of HingeJoint
        Kind of each joint.
    parameters : mapping of HingeJoint to HeadingConstraintParameters, optional
        For the kinds that shall differ from the defaults.

    Raises
    ------
    SetupError
        For an unknown joint or an impossible time step.
    """

    _ARRAYS: ClassVar[tuple[str, ...]] = ("state", "covariance", "last_relative", "memory")

    def __init__(
        self,
        joints: Sequence[HingeJoint],
        time_step_s: float,
        parameters: Mapping[HingeJoint, HeadingConstraintParameters] | None = None,
    ) -> None:
        self.joints = tuple(joints)
        unknown = [joint for joint in self.joints if joint not in _AXES]
        if unknown:
            raise SetupError(f"no hinge rule for {', '.join(unknown)}; known are {', '.join(_AXES)}")
        if not 1e-4 <= time_step_s <= 0.2:
            raise SetupError(f"time step {time_step_s} s; it must lie between 0.0001 and 0.2 s")
        self.time_step_s = float(time_step_s)
        self._stride = max(1, round(1.0 / (_UPDATE_HZ * self.time_step_s)))
        used = {**_DEFAULTS, **(parameters or {})}
        rows = [list(asdict(used[joint]).values()) for joint in self.joints]
        self._parameters = np.array(rows, dtype=np.float64).reshape(len(self.joints), PARAMETERS)
        self._axes = np.array([_AXES[joint] for joint in self.joints], dtype=np.int64).reshape(-1, 2)
        self.reset()

    def reset(self) -> None:
        """Begin again, as after a calibration pose: no offset known beyond the initial sigma."""
        count = len(self.joints)
        self._state = np.zeros((count, STATES))
        self._covariance = np.zeros((count, STATES, STATES))
        self._last_relative = np.full((count, 4), np.nan)
        self._memory = np.zeros((count, MEMORY))
        spreads = (INITIAL, DRIFT, CONSTANT, PARENT_TILT, PARENT_TILT, CHILD_TILT, CHILD_TILT, POSTURE)
        for state, parameter in enumerate(spreads):
            self._covariance[:, state, state] = np.square(self._parameters[:, parameter])

    def update(
        self,
        q_parent: Float,
        q_child: Float,
        first_tick: int,
        usable: NDArray[np.bool_] | None = None,
        referenced: NDArray[np.bool_] | None = None,
    ) -> HeadingConstraintResult:
        """Take the next ticks.

        Parameters
        ----------
        q_parent, q_child : ndarray, shape (K, J, 4)
            Segment orientations in frames that share the vertical. As the filters gave them: not corrected.
        first_tick : int
            Number of the first tick since the start of the session; says when an update is due.
        usable : ndarray of bool, shape (K, J), optional
            False where either orientation is held or lost; NaN counts as lost too.
        referenced : ndarray of bool, shape (K, J), optional
            True where both headings come from magnetometers that are trusted: the offset is drawn to zero.

        Raises
        ------
        ShapeError
            If the arrays do not fit the joints.
        """
        ticks, count = q_parent.shape[0], len(self.joints)
        for name, values in (("q_parent", q_parent), ("q_child", q_child)):
            if values.shape != (ticks, count, 4):
                raise ShapeError(f"{name} has shape {values.shape}; these joints need {(ticks, count, 4)}")
        finite = np.isfinite(q_parent).all(axis=-1) & np.isfinite(q_child).all(axis=-1)
        for name, flags in (("usable", usable), ("referenced", referenced)):
            if flags is not None and flags.shape != (ticks, count):
                raise ShapeError(f"{name} has shape {flags.shape}, not {(ticks, count)}")
        if usable is not None:
            finite &= usable
        known = np.zeros_like(finite) if referenced is None else referenced
        offset, sigma, correction, residual = (np.empty((ticks, count)) for _ in range(4))
        found = Corrections(offset, sigma, correction, np.empty((ticks, count), dtype=np.uint8), residual)
        constrain(
            np.ascontiguousarray(q_parent, dtype=np.float64),
            np.ascontiguousarray(q_child, dtype=np.float64),
            np.ascontiguousarray(finite),
            np.ascontiguousarray(known),
            first_tick,
            self._stride,
            self.time_step_s,
            self._axes,
            self._parameters,
            Carried(self._state, self._covariance, self._last_relative, self._memory),
            found,
        )
        return HeadingConstraintResult(
            offset, sigma, correction, found.is_informed.astype(np.bool_), residual
        )
