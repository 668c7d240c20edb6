"""The gait pipeline: sensors on the feet to the movement of both feet, their events and strides."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import Side
from estimators.errors import CalibrationError, SetupError
from estimators.gait import (
    FootFlag,
    FootParameters,
    FootTracker,
    FootTrajectory,
    GaitSummary,
    Measure,
    Strides,
    find_strides,
    foot_parameters,
    measure_steps,
    smooth,
    summarise,
)
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, Pipeline, SessionSetup
from estimators.recording import Float, ImuChunk, Recording
from estimators.signals import interpolate_rotations

WORN: tuple[str, ...] = ("foot_left", "foot_right", "heel_left", "heel_right")
"""Placements that this pipeline follows; others are left out."""
SCALARS = ("stance", "contact", "toe_off", "speed_mps", "stride_length_m", "stride_time_s", "clearance_m")
"""Per foot, named `foot_left_stance` and so on. Stance, contact and toe-off are 0 or 1; lengths and times are those
of the stride that the last contact ended, NaN before the first, and off-line only."""
_LEAST_COURSE_M = 3.0
_STEP_WIDTH_M = 0.15
"""Feet are drawn this far apart: how far they are cannot be told from two inertial sensors."""


def feet_of(setup: SessionSetup) -> dict[Side, int]:
    """Return which sensor of a setup is on which foot, a whole foot before a heel.

    Raises
    ------
    SetupError
        When there is none.
    """
    found: dict[Side, int] = {}
    for side in ("left", "right"):
        for name in (f"foot_{side}", f"heel_{side}"):
            if name in setup.placements and side not in found:
                found[side] = list(setup.placements).index(name)
    if not found:
        raise SetupError(f"the gait pipeline needs a sensor on a foot: {', '.join(WORN)}")
    return found


class GaitPipeline(Pipeline):
    """Sensors on one or both feet to poses, stances and speeds, less than a second late.

    Live, the frame of a tick shows the feet as they were `delay_ticks` before it, INVALID until then: a stance is
    understood only after it. Off-line (`run`) frames show their own ticks. Room is the world of each foot: z up,
    heading of the sensor at its first sample; the feet are drawn apart. The setup's `orientation_parameters` are
    `FootParameters`. Nothing is to be calibrated.
    """

    name: ClassVar[str] = "gait"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Walking"

    def __init__(self, setup: SessionSetup) -> None:
        self._setup = setup
        self._feet = feet_of(setup)
        self._tracker = FootTracker(len(self._feet), 1.0 / setup.rate_hz, setup.orientation_parameters)
        self._layout = layout_of(tuple(self._feet))
        delay, feet = self._tracker.delay_ticks, len(self._feet)
        # Released and not yet shown; before the first released tick there is nothing to show.
        self._waiting: dict[str, NDArray[Any]] = {
            "waiting_q": rotation.identity((delay, feet)),
            "waiting_position": np.stack([_apart(np.zeros((delay, 3)), side) for side in self._feet], axis=1),
            "waiting_scalar": np.full((delay, feet, 2), np.nan),
            "waiting_flags": np.full((delay, feet), int(OrientationFlag.INVALID), dtype=np.uint8),
        }

    @property
    def layout(self) -> FrameLayout:
        """Column names of every `Frames` this pipeline gives."""
        return self._layout

    @property
    def setup(self) -> SessionSetup:
        """The setup, as it was given."""
        return self._setup

    @property
    def delay_ticks(self) -> int:
        """Ticks between a sample and the frame that shows it."""
        return self._tracker.delay_ticks

    def step(self, chunk: ImuChunk) -> Frames:
        """Take the next ticks of all sensors, in the order of `setup.placements`."""
        rows = list(self._feet.values())
        found = self._tracker.update(
            replace(
                chunk,
                gyroscope_radps=chunk.gyroscope_radps[rows],
                accelerometer_mps2=chunk.accelerometer_mps2[rows],
                magnetometer_t=None if chunk.magnetometer_t is None else chunk.magnetometer_t[rows],
                quality=chunk.quality[rows],
            )
        )
        speed = np.linalg.norm(found.velocity_mps, axis=2)
        released = {
            "waiting_q": found.q_world_sensor.transpose(1, 0, 2),
            "waiting_position": np.stack(
                [_apart(found.position_m[i], side) for i, side in enumerate(self._feet)], axis=1
            ),
            "waiting_scalar": np.stack([found.is_stance.T, speed.T], axis=2),
            "waiting_flags": _flags(found.flags).T,
        }
        ticks = chunk.tick_count
        shown = {}
        for name, values in self._waiting.items():
            together = np.concatenate([values, released[name]])
            shown[name], self._waiting[name] = together[:ticks], together[ticks:]
        scalar = np.full((ticks, len(self._layout.scalars)), np.nan)
        for i in range(len(self._feet)):
            first = i * len(SCALARS)
            scalar[:, first], scalar[:, first + 3] = shown["waiting_scalar"][:, i].T
        return self._frames(
            chunk.first_tick,
            chunk.time_step_s,
            np.ascontiguousarray(shown["waiting_q"]),
            np.ascontiguousarray(shown["waiting_position"]),
            scalar,
            np.ascontiguousarray(shown["waiting_flags"]),
        )

    def _frames(
        self,
        first_tick: int,
        step_s: float,
        q: Float,
        position: Float,
        scalar: Float,
        flags: NDArray[np.uint8],
    ) -> Frames:
        ticks = len(q)
        return Frames(
            layout=self._layout,
            first_tick=first_tick,
            time_step_s=step_s,
            q_room_segment=q,
            point_room_m=position,
            angle_rad=np.empty((ticks, 0)),
            angle_sigma_rad=np.empty((ticks, 0)),
            scalar=scalar,
            segment_flags=flags,
            angle_flags=np.empty((ticks, 0), dtype=np.uint8),
        )

    def calibrate(self, pose: ImuChunk, method: str = "static") -> Calibration:
        """Refuse: where a sensor sits on the foot is found from the walk."""
        raise CalibrationError("walking needs no calibration pose; stand still for a second and walk")

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        return self._tracker.state() | {name: values.copy() for name, values in self._waiting.items()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        waiting = {name: np.array(state[name]) for name in self._waiting}
        self._tracker.restore({name: values for name, values in state.items() if name not in waiting})
        self._waiting = waiting


@dataclass(frozen=True)
class Walk:
    """A whole walk off-line.

    Attributes
    ----------
    frames : Frames
        Both feet on common ticks; segments have x to the toes, room has x along the walk's course.
    trajectories : dict of Side to FootTrajectory
        On the sensors' own stamps, each in its own world.
    strides : dict of Side to Strides
    summary : GaitSummary
    steps : dict of str to Measure, or None
        Step width and lengths, where somebody or something tells how far the feet are apart.
    """

    frames: Frames
    trajectories: Mapping[Side, FootTrajectory]
    strides: Mapping[Side, Strides]
    summary: GaitSummary
    steps: Mapping[str, Measure] | None = None


def analyse_walk(recording: Recording, setup: SessionSetup) -> Walk:
    """Follow the feet of a whole recording on their own time stamps, smoothed, and find their strides.

    Parameters
    ----------
    recording : Recording
        Its metadata may give `gyroscope_clip_radps` of the device, used unless the setup says otherwise.
    setup : SessionSetup
        `orientation_parameters` are those of `FootParameters`.

    Raises
    ------
    SetupError, ShapeError
        For placements, parameters or samples that cannot be used.
    """
    feet = feet_of(setup)
    given = dict(setup.orientation_parameters)
    if "gyroscope_clip_radps" in recording.metadata:
        given.setdefault("gyroscope_clip_radps", float(recording.metadata["gyroscope_clip_radps"]))
    parameters: FootParameters = foot_parameters(given)
    names = {side: setup.placements[i] for side, i in feet.items()}
    paths = {side: smooth(recording.sensors[name], parameters) for side, name in names.items()}
    strides = {side: find_strides(path, side) for side, path in paths.items()}
    start_s = min(float(path.time_s[0]) for path in paths.values())
    end_s = max(float(path.time_s[-1]) for path in paths.values())
    ticks = int((end_s - start_s) * setup.rate_hz + 1e-6) + 1
    time_s = start_s + np.arange(ticks) / setup.rate_hz
    parts = [_on_ticks(paths[side], strides[side], side, time_s) for side in feet]
    pipeline = GaitPipeline(replace(setup, orientation_parameters=given))
    frames = pipeline._frames(
        round(start_s * setup.rate_hz),
        1.0 / setup.rate_hz,
        np.stack([part[0] for part in parts], axis=1),
        np.stack([part[1] for part in parts], axis=1),
        np.concatenate([part[2] for part in parts], axis=1),
        np.stack([part[3] for part in parts], axis=1),
    )
    summary = summarise(strides)
    return Walk(frames, paths, strides, summary, _steps(strides, summary, setup.feet_apart_m))


def _steps(
    strides: Mapping[Side, Strides], summary: GaitSummary, apart_m: float | None
) -> Mapping[str, Measure] | None:
    """Return steps between the feet: their worlds can be related on a straight course from a known distance."""
    if apart_m is None or set(strides) != {"left", "right"} or summary.turn_count:
        return None
    left, right = strides["left"].footholds, strides["right"].footholds
    ways = [np.linalg.norm(holds.position_m[-1] - holds.position_m[0]) for holds in (left, right)]
    if min(ways) < _LEAST_COURSE_M:
        return None
    beside = np.array([0.0, -apart_m])
    return measure_steps(left.position_m, left.quietest_s, right.position_m, right.quietest_s, beside)


def layout_of(sides: tuple[Side, ...]) -> FrameLayout:
    """Return the columns of the gait pipeline for the feet that are worn."""
    names = tuple(f"foot_{side}" for side in sides)
    return FrameLayout(
        segments=names,
        points=names,
        angles=(),
        scalars=tuple(f"{name}_{scalar}" for name in names for scalar in SCALARS),
    )


def _apart(position_m: Float, side: Side) -> Float:
    aside = 0.5 * _STEP_WIDTH_M * (1.0 if side == "left" else -1.0)
    return np.asarray(position_m + np.array([0.0, aside, 0.0]))


def _flags(flags: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Say in the words of frames what is known of a foot."""
    invalid = (flags & (FootFlag.INVALID | FootFlag.NO_STANCE)) != 0
    bits = (
        invalid * OrientationFlag.INVALID
        + ((flags & FootFlag.BRIDGED) != 0) * OrientationFlag.BRIDGED
        + ((flags & FootFlag.SATURATED) != 0) * OrientationFlag.SATURATED
    )
    return np.asarray(bits, dtype=np.uint8)


def course_of(strides: Strides) -> float:
    """Return where a foot's walk went in its own world, rad about z."""
    holds = strides.footholds
    way = holds.position_m[-1] - holds.position_m[0] if strides.count else np.array([1.0, 0.0, 0.0])
    if np.linalg.norm(way[:2]) < 1.0 and strides.count:
        # There and back: the first stride tells where the walk went.
        way = holds.position_m[1] - holds.position_m[0]
    return float(np.arctan2(way[1], way[0]))


def _on_ticks(
    path: FootTrajectory, strides: Strides, side: Side, time_s: Float
) -> tuple[Float, Float, Float, NDArray[np.uint8]]:
    """Return orientation, position, scalars and flags of one foot on common ticks."""
    turn = rotation.exp([0.0, 0.0, -course_of(strides)])
    q = rotation.multiply(turn, interpolate_rotations(path.time_s, path.q_world_sensor, time_s))
    q = rotation.multiply(q, strides.q_sensor_foot)
    position, velocity = (
        np.stack([np.interp(time_s, path.time_s, rotated[:, i]) for i in range(3)], axis=1)
        for rotated in (rotation.rotate(turn, path.position_m - path.position_m[0]), path.velocity_mps)
    )
    nearest = np.clip(np.searchsorted(path.time_s, time_s), 0, len(path.time_s) - 1)
    flags = _flags(path.flags[nearest])
    outside = (time_s < path.time_s[0]) | (time_s > path.time_s[-1])
    flags[outside] |= np.uint8(OrientationFlag.INVALID)
    scalar = np.full((len(time_s), len(SCALARS)), np.nan)
    scalar[:, 0] = path.stance.is_stance[nearest]
    scalar[:, 1:3] = 0.0
    scalar[:, 3] = np.linalg.norm(velocity, axis=1)
    for column, events in ((1, strides.contact_s), (2, strides.toe_off_s)):
        scalar[np.minimum(np.searchsorted(time_s, events), len(time_s) - 1), column] = 1.0
    last = np.searchsorted(strides.contact_s, time_s, side="right") - 1
    known = last >= 0
    for column, values in ((4, strides.length_m), (5, strides.duration_s), (6, strides.clearance_m)):
        scalar[known, column] = values[last[known]]
    return q, _apart(position, side), scalar, flags


__all__ = ["SCALARS", "WORN", "GaitPipeline", "Walk", "analyse_walk", "course_of", "feet_of", "layout_of"]
