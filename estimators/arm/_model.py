"""The arm model of one session: which joints the worn sensors can move, how long the bones are, one call."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arm._kernel import Columns, Filled, Segments, evaluate_kernel
from estimators.arm._names import MODEL_ANGLES, MODEL_POINTS, MODEL_SCALARS, MODEL_SEGMENTS
from estimators.body import (
    EYE_HEIGHT_PER_STATURE,
    HIP_HEIGHT_PER_STATURE,
    SHOULDER_HEIGHT_PER_STATURE,
    BodyDimensions,
)
from estimators.conventions import SIDES, Placement
from estimators.errors import SetupError, ShapeError

Float = NDArray[np.float64]

_NOT_GIVEN: Final = np.zeros((0, 0, 3))


class ArmResult(NamedTuple):
    """What the model gives for K ticks; columns are `ArmModel.points`, `.angles` and `.scalars`.

    Attributes
    ----------
    point_room_m : ndarray, shape (K, P, 3)
    angle_rad, angle_sigma_rad : ndarray, shape (K, A)
        NaN where an orientation or its sigma is NaN or not given.
    scalar : ndarray, shape (K, C)
    angle_flags : ndarray of uint8, shape (K, A)
        Flags of both segments of the joint, and SINGULAR.
    previous_angle_rad : ndarray, shape (18,)
        Hand it to the next call: that is all the model remembers.
    """

    point_room_m: Float
    angle_rad: Float
    angle_sigma_rad: Float
    scalar: Float
    angle_flags: NDArray[np.uint8]
    previous_angle_rad: Float


def model_lengths(body: BodyDimensions) -> Float:
    """Return the lengths that the kinematic chain uses, in the order of the kernel.

    Returns
    -------
    ndarray, shape (7,)
        Hip height above the floor, hips to shoulder height, half the distance of the shoulder centres,
        neck (shoulder height) to the middle of the head, upper arm, forearm, hand; metres.

    Notes
    -----
    Hip and head heights are Drillis and Contini's fractions of stature; see `estimators.body`.
    """
    measured = (body.trunk_m, body.shoulder_width_m, body.upper_arm_m, body.forearm_m, body.hand_m)
    if not (0.5 <= body.stature_m <= 2.5 and all(0.02 <= length <= 1.5 for length in measured)):
        raise SetupError(f"{body} is no human body; lengths are metres between joint centres")
    return np.array(
        [
            HIP_HEIGHT_PER_STATURE * body.stature_m,
            body.trunk_m,
            0.5 * body.shoulder_width_m,
            (EYE_HEIGHT_PER_STATURE - SHOULDER_HEIGHT_PER_STATURE) * body.stature_m,
            body.upper_arm_m,
            body.forearm_m,
            body.hand_m,
        ]
    )


class ArmModel:
    """Trunk and arms, moved by the orientations of the worn segments.

    The pelvis stands at the origin; the thorax turns about the hip centre (upright when no sternum sensor is
    worn); a shoulder sensor turns its clavicle about the neck, else the clavicle goes with the thorax; a
    hand without a sensor goes straight on from the forearm.

    Parameters
    ----------
    placements : sequence of Placement
        Worn sensors; orientations are given in this order. Legs and pelvis are carried along unused.
    time_step_s : float
        Only weighs the hold near the shoulder singularity.

    Attributes
    ----------
    points, angles, scalars : tuple of str
        Column names of the results: what these placements allow.

    Raises
    ------
    SetupError
        If neither sternum nor upper arm is worn, a placement is given twice, or lengths or the time step are
        impossible.
    """

    def __init__(self, body: BodyDimensions, placements: Sequence[Placement], time_step_s: float) -> None:
        worn = tuple(placements)
        if len(set(worn)) != len(worn):
            raise SetupError(f"a placement occurs twice in {worn}; each sensor needs its own")
        if not {"sternum", "upper_arm_left", "upper_arm_right"} & set(worn):
            raise SetupError(f"the arm model needs a sensor on the sternum or an upper arm; worn: {worn}")
        if not 0.0 < time_step_s < 1.0:
            raise SetupError(f"time_step_s is {time_step_s}; it must lie between 0 and 1 s")
        self.body = body
        self.placements = worn
        self.time_step_s = float(time_step_s)
        self.points = tuple(name for name in MODEL_POINTS if _has_point(name, worn))
        self.angles = tuple(name for name in MODEL_ANGLES if _has_angle(name, worn))
        self.scalars = tuple(name for name in MODEL_SCALARS if _has_scalar(name, worn))
        self._columns = Columns(
            _columns(MODEL_SEGMENTS, worn),
            model_lengths(body),
            _columns(MODEL_POINTS, self.points),
            _columns(MODEL_ANGLES, self.angles),
            _columns(MODEL_SCALARS, self.scalars),
        )

    @staticmethod
    def initial_previous() -> Float:
        """Return the memory of a model that has seen nothing, shape (18,)."""
        return np.full(len(MODEL_ANGLES), np.nan)

    def evaluate(
        self,
        q_room_segment: Float,
        *,
        segment_flags: NDArray[np.uint8] | None = None,
        angular_velocity_room_radps: Float | None = None,
        sigma_room_rad: Float | None = None,
        previous_angle_rad: Float | None = None,
        more_points: int = 0,
        more_angles: int = 0,
        more_scalars: int = 0,
    ) -> ArmResult:
        """Turn segment orientations into joint centres, joint angles and scalars.

        Parameters
        ----------
        q_room_segment : ndarray, shape (K, G, 4)
            In the order of `placements`.
        segment_flags : ndarray of uint8, shape (K, G), optional
            `OrientationFlag` bits of the sensors.
        angular_velocity_room_radps : ndarray, shape (K, G, 3), optional
            Of the segments, in room axes; without it hand speed is NaN.
        sigma_room_rad : ndarray, shape (K, G, 3), optional
            One-sigma orientation error about the room axes, independent between sensors; without it the
            angle sigmas are NaN.
        previous_angle_rad : ndarray, shape (18,), optional
            `ArmResult.previous_angle_rad` of the ticks before, so that any chunking gives the same bits.
        more_points, more_angles, more_scalars : int
            Columns left empty behind those of the model, for whoever has more to say of these ticks.

        Raises
        ------
        ShapeError
            If an array does not fit the placements.
        """
        ticks, segments = q_room_segment.shape[0], len(self.placements)
        angles = len(self.angles) + more_angles
        q = _array("q_room_segment", q_room_segment, (ticks, segments, 4))
        omega = _optional("angular_velocity_room_radps", angular_velocity_room_radps, (ticks, segments, 3))
        sigma = _optional("sigma_room_rad", sigma_room_rad, (ticks, segments, 3))
        if segment_flags is None:
            flags = np.zeros((ticks, segments), dtype=np.uint8)
        elif segment_flags.shape == (ticks, segments):
            flags = np.ascontiguousarray(segment_flags, dtype=np.uint8)
        else:
            raise ShapeError(f"segment_flags has shape {segment_flags.shape}, not {(ticks, segments)}")
        if previous_angle_rad is None:
            previous = self.initial_previous()
        else:
            previous = np.array(previous_angle_rad, dtype=np.float64)
            if previous.shape != (len(MODEL_ANGLES),):
                raise ShapeError(f"previous_angle_rad has shape {previous.shape}, not ({len(MODEL_ANGLES)},)")
        result = ArmResult(
            np.empty((ticks, len(self.points) + more_points, 3)),
            np.empty((ticks, angles)),
            np.empty((ticks, angles)),
            np.empty((ticks, len(self.scalars) + more_scalars)),
            np.empty((ticks, angles), dtype=np.uint8),
            previous,
        )
        evaluate_kernel(
            Segments(q, omega, sigma, flags),
            self._columns,
            self.time_step_s,
            previous,
            Filled(*result[:5]),
        )
        return result


def _array(name: str, values: Float, shape: tuple[int, ...]) -> Float:
    if values.shape != shape:
        raise ShapeError(f"{name} has shape {values.shape}, not {shape}; one row a placement is needed")
    return np.ascontiguousarray(values, dtype=np.float64)


def _optional(name: str, values: Float | None, shape: tuple[int, ...]) -> Float:
    return _NOT_GIVEN if values is None else _array(name, values, shape)


def _columns(model: tuple[str, ...], available: tuple[str, ...]) -> NDArray[np.int64]:
    return np.array([available.index(name) if name in available else -1 for name in model], dtype=np.int64)


def _has_point(name: str, worn: tuple[str, ...]) -> bool:
    joint, _, side = name.rpartition("_")
    needed = {"elbow": ("upper_arm",), "wrist": ("upper_arm", "forearm"), "hand": ("upper_arm", "forearm")}
    return side not in SIDES or all(f"{segment}_{side}" in worn for segment in needed.get(joint, ()))


def _has_angle(name: str, worn: tuple[str, ...]) -> bool:
    side = "left" if "_left_" in name else "right"
    needed = {
        "thorax_humerus": ("upper_arm",),
        "humerus_forearm": ("upper_arm", "forearm"),
        "forearm_hand": ("forearm", "hand"),
    }[name.partition(f"_{side}")[0]]
    return all(f"{segment}_{side}" in worn for segment in needed)


def _has_scalar(name: str, worn: tuple[str, ...]) -> bool:
    if name.startswith("trunk"):
        return "sternum" in worn
    side = "left" if "_left_" in name else "right"
    if name.startswith("shoulder_hike"):
        return f"shoulder_{side}" in worn
    return f"upper_arm_{side}" in worn and f"forearm_{side}" in worn
