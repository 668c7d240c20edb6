"""The gait pipeline: sensors on the feet to the movement of both feet, their events and strides."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import Side
from estimators.errors import CalibrationError
from estimators.gait import (
    USUAL_APART_M,
    FootChunk,
    FootFlag,
    FootParameters,
    FootTracker,
    FootTrajectory,
    GaitSummary,
    LiveStepTracker,
    Measure,
    Strides,
    find_strides,
    foot_parameters,
    measure_steps,
    smooth,
    summarise,
)
from estimators.kinetics import ShoeGeometry
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, Pipeline, SessionSetup
from estimators.pipelines._gait_layout import CENTRE_PER_STATURE, SCALARS, WORN, cells_of, feet_of, layout_of
from estimators.pipelines._live_shoes import LiveShoes
from estimators.recording import Float, ImuChunk, Recording
from estimators.signals import interpolate_rotations

_LEAST_COURSE_M = 3.0
_AHEAD_S = 0.7
"""So much of the forces to come says whether somebody stands or is about to walk."""


class GaitPipeline(Pipeline):
    """Sensors on one or both feet to poses, stances, strides and speeds, less than a second late.

    Live, the frame of a tick shows the feet as they were `delay_ticks` before it, INVALID until then: a stance is
    understood only after it. Off-line (`run`) frames show their own ticks. The setup's `orientation_parameters` are
    `FootParameters`. Nothing is to be calibrated.

    Feet with one sensor each are drawn apart, each in its own world: z up, heading of the sensor at its first sample.
    Two instrumented shoes (sensors under both heels and forefeet) share a room, with x along the first strides, the
    floor at zero, and their forces (`FORCE_SCALARS`, `BALANCE_POINTS`): a foot's own from the first sample on, those of
    both together once each has made a stride, which tells the course and the zero of its load cells. What is not
    measured is NaN, and `force_state` says why.
    """

    name: ClassVar[str] = "gait"
    version: ClassVar[str] = "2"
    title: ClassVar[str] = "Walking"

    def __init__(self, setup: SessionSetup) -> None:
        self._setup = setup
        self._feet = feet_of(setup)
        cells = cells_of(setup)
        self._rows = list(self._feet.values()) if cells is None else [row for pair in cells for row in pair]
        self._heels = list(range(len(self._rows))) if cells is None else [0, 2]
        step_s = 1.0 / setup.rate_hz
        self._tracker = FootTracker(len(self._rows), step_s, setup.orientation_parameters)
        self._steps = LiveStepTracker(
            tuple(self._feet),
            step_s,
            setup.feet_apart_m,
            height_m=0.0 if cells is None else ShoeGeometry().sensor_height_m,
            has_foot_axes=cells is not None,
        )
        self._shoes = None if cells is None else _live_shoes(setup, self._tracker)
        self._layout = layout_of(tuple(self._feet), with_forces=cells is not None)
        self._waiting = np.tile(self._nothing(), (self._tracker.delay_ticks, 1))
        """Released and not yet shown; before the first released tick there is nothing to show."""

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
        rows, ticks = self._rows, chunk.tick_count
        found = self._tracker.update(
            replace(
                chunk,
                gyroscope_radps=chunk.gyroscope_radps[rows],
                accelerometer_mps2=chunk.accelerometer_mps2[rows],
                magnetometer_t=None if chunk.magnetometer_t is None else chunk.magnetometer_t[rows],
                quality=chunk.quality[rows],
                force_n=None,
                moment_nm=None,
            )
        )
        if self._shoes is not None:
            force, moment = chunk.force_n, chunk.moment_nm
            is_felt = force is not None and moment is not None
            self._shoes.take(
                force[rows] if is_felt and force is not None else None,
                moment[rows] if is_felt and moment is not None else None,
                ticks,
            )
        if found.tick_count:
            self._waiting = np.concatenate([self._waiting, self._released(found)])
        shown, self._waiting = self._waiting[:ticks], self._waiting[ticks:]
        feet, points = len(self._feet), len(self._layout.points)
        ends = np.cumsum([4 * feet, 3 * points, len(self._layout.scalars)])
        return self._frames(
            chunk.first_tick,
            chunk.time_step_s,
            np.ascontiguousarray(shown[:, : ends[0]]).reshape(ticks, feet, 4),
            np.ascontiguousarray(shown[:, ends[0] : ends[1]]).reshape(ticks, points, 3),
            np.ascontiguousarray(shown[:, ends[1] : ends[2]]),
            shown[:, ends[2] :].astype(np.uint8),
        )

    def _nothing(self) -> Float:
        """Return the row of a tick of which nothing is known."""
        feet = len(self._feet)
        points = np.full((len(self._layout.points), 3), np.nan)
        for number, side in enumerate(self._feet):
            points[number] = _apart(np.zeros(3), side)
        return np.concatenate(
            [
                rotation.identity((feet,)).ravel(),
                points.ravel(),
                np.full(len(self._layout.scalars), np.nan),
                np.full(feet, float(OrientationFlag.INVALID)),
            ]
        )

    def _released(self, found: FootChunk) -> Float:
        """Return the rows of what the tracker gave away."""
        feet, heels, count = len(self._feet), self._heels, found.tick_count
        steps = self._steps.update(found, heels)
        q, position = found.q_world_sensor[heels], found.position_m[heels]
        scalar = np.full((count, len(self._layout.scalars)), np.nan)
        each = scalar[:, : feet * len(SCALARS)].reshape(count, feet, len(SCALARS))
        each[:, :, 0] = found.is_stance[heels].T
        each[:, :, 3] = np.sqrt(
            np.einsum("fki,fki->kf", found.velocity_mps[heels], found.velocity_mps[heels])
        )
        each[:, :, 4], each[:, :, 7] = steps.stride_length_m, steps.toe_out_rad
        scalar[:, : feet * len(SCALARS)] = each.reshape(count, -1)
        if self._shoes is None:
            points = [_apart(position[i], side) for i, side in enumerate(self._feet)]
        else:
            points, forces = self._shoes.release(found, steps)
            scalar[:, feet * len(SCALARS) :] = forces
            half = -0.5 * steps.course_rad.T
            still = np.zeros_like(half)
            q = rotation.multiply(np.stack([np.cos(half), still, still, np.sin(half)], axis=-1), q)
        return np.concatenate(
            [
                q.transpose(1, 0, 2).reshape(count, -1),
                *points,
                scalar,
                _flags(found.flags[heels]).T,
            ],
            axis=1,
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
        return frames_of(self._layout, first_tick, step_s, q, position, scalar, flags)

    def calibrate(self, pose: ImuChunk, method: str = "static") -> Calibration:
        """Refuse: where a sensor sits on the foot is found from the walk."""
        raise CalibrationError("walking needs no calibration pose; stand still for a second and walk")

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        own = self._steps.state() | {"waiting": self._waiting.copy()}
        return self._tracker.state() | own | ({} if self._shoes is None else self._shoes.state())

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        self._waiting = np.array(state["waiting"])
        self._steps.restore(state)
        if self._shoes is not None:
            self._shoes.restore(state)
        self._tracker.restore(state)


def frames_of(
    layout: FrameLayout,
    first_tick: int,
    step_s: float,
    q: Float,
    position: Float,
    scalar: Float,
    flags: NDArray[np.uint8],
) -> Frames:
    """Return frames without angles."""
    ticks = len(q)
    return Frames(
        layout=layout,
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


def _live_shoes(setup: SessionSetup, tracker: FootTracker) -> LiveShoes:
    # What the tracker releases is older than its delay less one release.
    behind = tracker.delay_ticks - round(tracker.parameters["release_s"] * setup.rate_hz) - 2
    return LiveShoes(
        1.0 / setup.rate_hz,
        CENTRE_PER_STATURE * setup.body.stature_m,
        is_apart_measured=setup.feet_apart_m is not None,
        ahead_ticks=max(0, min(round(_AHEAD_S * setup.rate_hz), behind)),
    )


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
    frames = frames_of(
        layout_of(tuple(feet)),
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
    known_s = min(foot.whole_until_s for foot in strides.values())
    left, right = strides["left"].footholds.before(known_s), strides["right"].footholds.before(known_s)
    if min(len(left.start_s), len(right.start_s)) < 2:
        return None
    ways = [np.linalg.norm(holds.position_m[-1] - holds.position_m[0]) for holds in (left, right)]
    if min(ways) < _LEAST_COURSE_M:
        return None
    beside = np.array([0.0, -apart_m])
    return measure_steps(left.position_m, left.quietest_s, right.position_m, right.quietest_s, beside)


def _apart(position_m: Float, side: Side) -> Float:
    aside = 0.5 * USUAL_APART_M * (1.0 if side == "left" else -1.0)
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
    scalar[:, 3] = np.linalg.norm(velocity, axis=1)
    return q, _apart(position, side), event_columns(scalar, strides, time_s), flags


def event_columns(scalar: Float, strides: Strides, time_s: Float) -> Float:
    """Return the `SCALARS` of one foot, shape (K, 8), with contacts, toe-offs and the measures of these strides.

    Parameters
    ----------
    scalar : ndarray, shape (K, 8)
        Stance and speed are kept.
    strides : Strides
    time_s : ndarray, shape (K,)
        Of the ticks.
    """
    found = scalar.copy()
    found[:, 1:3], found[:, 4:] = 0.0, np.nan
    for column, events in ((1, strides.contact_s), (2, strides.toe_off_s)):
        found[np.minimum(np.searchsorted(time_s, events), len(time_s) - 1), column] = 1.0
    last = np.searchsorted(strides.contact_s, time_s, side="right") - 1
    known = last >= 0
    measures = (strides.length_m, strides.duration_s, strides.clearance_m, strides.toe_out_rad)
    for column, values in enumerate(measures, 4):
        found[known, column] = values[last[known]]
    return found


__all__ = [
    "SCALARS",
    "WORN",
    "GaitPipeline",
    "Walk",
    "analyse_walk",
    "course_of",
    "event_columns",
    "feet_of",
    "layout_of",
]
