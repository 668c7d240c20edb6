"""The contract of a pipeline: configuration in, frames out.

`SessionSetup` says everything that a result depends on besides the samples and is stored with it.
`Frames` is the one type that live view, dashboards, the store and replay share.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from estimators.body import BodyDimensions as BodyDimensions
from estimators.calibration import Calibration as Calibration
from estimators.calibration import DeviceCalibration as DeviceCalibration
from estimators.calibration import FunctionalResult as FunctionalResult
from estimators.conventions import Placement
from estimators.errors import SetupError
from estimators.orientation import DEFAULT, OrientationFlag
from estimators.orientation import DeviceConstants as DeviceConstants
from estimators.recording import Float, ImuChunk
from estimators.samples import Samples
from estimators.sentences import CATALOGUE, for_json, say

_LEGS: Final = ("thigh_", "shank_", "foot_")
SLIPPED: Final = 256
"""Beside the bits of `OrientationFlag` where flags leave the service: the sensor has turned in its strap."""


@dataclass(frozen=True)
class SessionSetup:
    """Everything that a result depends on besides the samples.

    Attributes
    ----------
    pipeline : str
        Key of the pipeline registry, for instance `arm`.
    placements : tuple of Placement
        Sensors in the order of the packets.
    rate_hz : float
        The common tick rate.
    orientation : str
        Key of the orientation registry.
    orientation_parameters : dict
        Overrides; empty means the defaults of that version.
    calibration : Calibration or None
        None until the patient was calibrated: frames then show sensor motion only, flagged.
    constrain_joint_headings : bool
        Let elbows and wrists bound the heading drift between their segments: for sensors without
        magnetometers or in disturbed fields. Off, results are those of the sensors alone.
    devices : dict of DeviceCalibration
        By placement: what was calibrated in the hand about the sensor worn there, applied before everything.
    device_constants : dict of DeviceConstants
        By placement: what earlier sessions learnt about the sensor worn there. Sensors not named start unknown.
    feet_apart_m, feet_apart_end_m : float or None
        Of a walk: distance of the feet side by side at its start and at its end, where somebody measured it.
    """

    pipeline: str
    placements: tuple[Placement, ...]
    rate_hz: float
    orientation: str = DEFAULT
    orientation_parameters: dict[str, Any] = field(default_factory=dict)
    body: BodyDimensions = field(default_factory=BodyDimensions)
    calibration: Calibration | None = None
    constrain_joint_headings: bool = False
    devices: dict[Placement, DeviceCalibration] = field(default_factory=dict)
    device_constants: dict[Placement, DeviceConstants] = field(default_factory=dict)
    feet_apart_m: float | None = None
    feet_apart_end_m: float | None = None

    def with_devices(self, found: Mapping[str, DeviceCalibration]) -> "SessionSetup":
        """Return the setup with calibrations of sensors of which there is none; the others stay."""
        worn = {name: found[name] for name in self.placements if name in found}
        return replace(self, devices={**worn, **self.devices}) if worn else self

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON types; `from_dict` reverses it exactly."""
        from dataclasses import asdict

        values = asdict(self)
        if self.calibration is not None:
            values["calibration"]["reasons"] = for_json(self.calibration.reasons)
        return values

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> "SessionSetup":
        """Rebuild from `to_dict` after a trip through JSON."""
        values = dict(stored)
        values["placements"] = tuple(values["placements"])
        values["body"] = BodyDimensions(**values["body"])
        values["devices"] = {
            name: DeviceCalibration.from_dict(known) for name, known in values.get("devices", {}).items()
        }
        values["device_constants"] = {
            name: DeviceConstants.from_dict(known)
            for name, known in values.get("device_constants", {}).items()
        }
        if values.get("calibration") is not None:
            values["calibration"] = calibration_from_dict(values["calibration"])
        return cls(**values)


def calibration_from_dict(stored: Mapping[str, Any]) -> Calibration:
    """Rebuild a calibration from the plain JSON types that `SessionSetup.to_dict` gives of it."""
    values = dict(stored)
    for name in ("q_sensor_segment", "gyroscope_bias_radps", "accelerometer_bias_mps2", "mounting_sigma_rad"):
        values[name] = {placement: tuple(one) for placement, one in values.get(name, {}).items()}
    values["reasons"] = tuple(CATALOGUE.restored(list(values["reasons"])))
    for name in ("unknown_headings", "contradicted"):
        values[name] = tuple(values.get(name, ()))
    return Calibration(**values)


@dataclass(frozen=True)
class FrameLayout:
    """Names of the columns of `Frames`; fixed for a session once its setup is fixed.

    Attributes
    ----------
    segments : tuple of str
        Segments with an orientation, in column order (`sternum` is drawn as the thorax).
    points : tuple of str
        Joint centres and end points with a position, in column order: `shoulder_right`,
        `elbow_right`, `wrist_right`, `hand_right`, `neck`, ... (origin of the segment of that name, or end).
    angles : tuple of str
        Joint angles, named joint, sequence and meaning, e.g. `thorax_humerus_right_yxy_elevation`.
    scalars : tuple of str
        Other measures per tick with their unit as suffix, e.g. `trunk_lean_forward_rad`.
    """

    segments: tuple[str, ...]
    points: tuple[str, ...]
    angles: tuple[str, ...]
    scalars: tuple[str, ...] = ()


@dataclass(frozen=True)
class Frames(Samples):
    """What the pipeline found for K consecutive ticks.

    Attributes
    ----------
    q_room_segment : ndarray, shape (K, G, 4)
    point_room_m : ndarray, shape (K, P, 3)
    angle_rad : ndarray, shape (K, A)
        NaN where the segments it needs are not worn or not calibrated. Unwrapped in time, so curves do
        not jump.
    angle_sigma_rad : ndarray, shape (K, A)
        One-sigma from the uncertainty of orientation and mounting, NaN where unknown.
    scalar : ndarray, shape (K, C)
    segment_flags : ndarray of uint8, shape (K, G)
        `OrientationFlag` bits of the sensor that drives the segment.
    angle_flags : ndarray of uint8, shape (K, A)
        `OrientationFlag` bits; SINGULAR where the sequence is near its singularity.
    segment_sigma_rad : ndarray, shape (K, G, 3), or None
        One-sigma of each segment's orientation about the room axes, NaN where the method tells none. Of live results
        only where no angle carries it; see `as_stored_live`.
    point_sigma_m : ndarray, shape (K, P, 3), or None
        One-sigma of each point's position along the room axes, NaN where the method tells none.
    slipped : ndarray of bool, shape (K, G + A + P), or None
        From where on a sensor has turned in its strap: each segment that wears one, each angle that is off by it, each
        point that is off by it as seen from the shoulder. No flag says so, because restarts and missing compasses raise
        those too. None where none has.
    """

    UNKNOWN_BITS: ClassVar[int] = OrientationFlag.INVALID.value

    layout: FrameLayout
    first_tick: int
    time_step_s: float
    q_room_segment: Float
    point_room_m: Float
    angle_rad: Float
    angle_sigma_rad: Float
    scalar: Float
    segment_flags: NDArray[np.uint8]
    angle_flags: NDArray[np.uint8]
    segment_sigma_rad: Float | None = None
    point_sigma_m: Float | None = None
    slipped: NDArray[np.bool_] | None = None

    @property
    def slipped_parts(self) -> "tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]":
        """Where segments, angles and points are off by a turned sensor, shapes (K, G), (K, A) and (K, P)."""
        segments, angles = len(self.layout.segments), len(self.layout.angles)
        slipped = self.slipped
        if slipped is None:
            shape = len(self.segment_flags), segments + angles + len(self.layout.points)
            slipped = np.zeros(shape, dtype=np.bool_)
        return (
            slipped[:, :segments],
            slipped[:, segments : segments + angles],
            slipped[:, segments + angles :],
        )

    @property
    def segment_bits(self) -> NDArray[Any]:
        """`segment_flags`, with `SLIPPED` where a sensor has turned in its strap."""
        return self._with_slipped(self.segment_flags, 0)

    @property
    def angle_bits(self) -> NDArray[Any]:
        """`angle_flags`, with `SLIPPED` where a sensor has turned in its strap."""
        return self._with_slipped(self.angle_flags, 1)

    def _with_slipped(self, flags: NDArray[np.uint8], part: int) -> NDArray[Any]:
        if self.slipped is None:
            return flags
        return np.asarray(flags | np.where(self.slipped_parts[part], SLIPPED, 0).astype(np.uint16))

    @property
    def time_s(self) -> Float:
        """Time of each tick since the start of the session, shape (K,)."""
        ticks = np.arange(self.first_tick, self.first_tick + self.tick_count, dtype=np.float64)
        return ticks * self.time_step_s

    def as_stored_live(self) -> "Frames":
        """Return the same frames without `segment_sigma_rad` where joint angles carry their own sigma.

        Of a body the sigmas of all segments would cost a third more to store; of feet nothing else says how well
        their orientation is known.
        """
        if self.segment_sigma_rad is None or not self.layout.angles:
            return self
        return self._twin({**self.__dict__, "segment_sigma_rad": None})


class Pipeline(ABC):
    """One session's estimators behind one call.

    Obeys the same rule as an estimator: any chunking and any `state`/`restore` gives the same frames.
    """

    name: ClassVar[str]
    version: ClassVar[str]
    axes: ClassVar[str]
    """Axes of points, orientations and their sigmas, in words."""
    needs_pose: ClassVar[bool] = False
    """Whether angles mean nothing before a pose or movements were evaluated."""
    takes_estimator: ClassVar[bool] = False
    """Whether `SessionSetup.orientation` chooses the filter; otherwise it has its own, named `filter`."""
    filter: ClassVar[str] = ""
    begins_anywhere: ClassVar[bool] = True
    """Whether it finds its way when its samples begin in mid-session."""
    is_worn: ClassVar[bool] = True
    """Whether its sensors sit where a `Placement` names; otherwise they may have any name."""
    is_streamed: ClassVar[bool] = True
    """Whether a session of it can be recorded live."""
    is_uploaded: ClassVar[bool] = True
    """Whether a file can hold a recording of it."""

    @classmethod
    def used(cls, placements: Sequence[Placement], *, with_legs: bool = False) -> tuple[Placement, ...]:
        """Return the sensors that this pipeline uses of those worn; the others stay in the raw data.

        Legs need not be still in a pose: they are left out unless `with_legs`.
        """
        return tuple(name for name in placements if with_legs or not name.startswith(_LEGS))

    @abstractmethod
    def __init__(self, setup: SessionSetup) -> None:
        """Check the setup (`SetupError` says what is wrong) and start with no samples seen."""

    @property
    @abstractmethod
    def layout(self) -> FrameLayout:
        """Column names of every `Frames` this pipeline gives."""

    @property
    def delay_ticks(self) -> int:
        """Ticks between a sample and the frame that shows it, live."""
        return 0

    @abstractmethod
    def step(self, chunk: ImuChunk) -> Frames:
        """Take the next ticks of all sensors, in the order of `setup.placements`."""

    @abstractmethod
    def calibrate(self, pose: ImuChunk, method: str = "n_pose") -> Calibration:
        """Find the calibration from the ticks during which the patient held the pose.

        `pose` are ticks that `step` has already seen (orientation is taken from the running filter).
        The result takes effect from the next `step`. Raises `CalibrationError` with what to redo.
        """

    def calibrate_by_movement(
        self, chunk: ImuChunk, movements: Mapping[str, tuple[int, int]], *, assisted: bool = False
    ) -> FunctionalResult:
        """Find the calibration from movements among the ticks of `chunk`; it holds from the next step.

        Parameters
        ----------
        chunk : ImuChunk
            Consecutive ticks that `step` has seen, the rest and all movements; best up to the newest.
        movements : mapping of str to (start, stop)
            Session ticks; names as for `estimators.calibration.functional`.
        assisted : bool
            Moved by someone else, seated.
        """
        raise SetupError(say("calibration.no_joints"))

    def reset_heading(self, pose: ImuChunk, placements: Sequence[Placement]) -> Calibration:
        """Set the headings of some segments again from an N-pose among the last ticks; the rest stays."""
        raise SetupError(say("calibration.no_directions"))

    def set_devices(self, devices: Mapping[Placement, DeviceCalibration]) -> None:
        """Take calibrations made in the hand; the filters start again, and the body must be calibrated again."""
        raise SetupError(say("calibration.no_devices"))

    @property
    @abstractmethod
    def setup(self) -> SessionSetup:
        """The setup with the calibration in force, to be stored with the results."""

    @property
    def device_constants(self) -> dict[Placement, DeviceConstants]:
        """What is known of each sensor by now, for the next session of its device; empty if nothing is learnt."""
        return {}

    @abstractmethod
    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""

    @abstractmethod
    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
