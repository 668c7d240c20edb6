"""The gait pipeline: sensors on the feet to the movement of both feet, their events and strides."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators import calibration, rotation
from estimators.conventions import Placement, Side
from estimators.errors import CalibrationError
from estimators.gait import (
    USUAL_APART_M,
    FootFlag,
    FootTracker,
    LiveStepTracker,
)
from estimators.gait.foot.live.rows import PIECE_TICKS
from estimators.kinetics import ShoeGeometry
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, Pipeline, SessionSetup
from estimators.pipelines.walk.layout import (
    CENTRE_PER_STATURE,
    cells_of,
    feet_of,
    layout_of,
)
from estimators.pipelines.walk.live_shoes import LiveShoes
from estimators.pipelines.walk.released_kernel import Feet, write_feet, write_shoes
from estimators.pipelines.walk.rows import Queue, queue_room
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

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
    version: ClassVar[str] = "3"
    title: ClassVar[str] = "Walking"
    axes: ClassVar[str] = (
        "room: z up, x along the course of the walk; live, each foot's own world: z up, heading of its first sample"
    )
    filter: ClassVar[str] = "foot"

    @classmethod
    def used(cls, placements: Sequence[Placement], *, with_legs: bool = False) -> tuple[Placement, ...]:
        """Return the feet among the sensors worn."""
        return tuple(name for name in placements if name in ("foot_left", "foot_right"))

    def __init__(self, setup: SessionSetup) -> None:
        self._setup = setup
        self._feet = feet_of(setup)
        cells = cells_of(setup)
        self._rows = list(self._feet.values()) if cells is None else [row for pair in cells for row in pair]
        self._heels = np.array(range(len(self._rows)) if cells is None else [0, 2], dtype=np.int64)
        self._offset_m = np.stack([apart(np.zeros(3), side) for side in self._feet])
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
        feet, points = len(self._feet), len(self._layout.points)
        ends = np.cumsum([0, 4 * feet, 3 * points, len(self._layout.scalars), feet, 3 * feet, 3 * points])
        self._columns = [slice(*pair) for pair in pairwise(ends.tolist())]
        """Of a waiting row: orientations, points, scalars, flags, sigmas of both."""
        delay_ticks, width = self._tracker.delay_ticks, int(ends[-1])
        self._waiting = Queue(np.zeros(queue_room(1, delay_ticks, width)), np.zeros(2, dtype=np.int64))
        """Released and not yet shown; before the first released tick there is nothing to show."""
        self._waiting.append(delay_ticks)[...] = self._nothing()

    @property
    def layout(self) -> FrameLayout:
        """Column names of every `Frames` this pipeline gives."""
        return self._layout

    @property
    def width(self) -> int:
        """Numbers of a row that waits."""
        return int(self._columns[-1].stop)

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
        if chunk.tick_count > PIECE_TICKS:
            starts = range(0, chunk.tick_count, PIECE_TICKS)
            return Frames.join(
                [self.step(chunk.ticks(a, min(a + PIECE_TICKS, chunk.tick_count))) for a in starts]
            )
        rows, ticks = self._worn_rows(chunk), chunk.tick_count
        if self._setup.devices:
            chunk = calibration.correct(
                chunk, [self._setup.devices.get(name) for name in self._setup.placements]
            )
        field, force, moment = chunk.magnetometer_t, chunk.force_n, chunk.moment_nm
        worn = ImuChunk(
            chunk.first_tick,
            chunk.time_step_s,
            chunk.gyroscope_radps[rows],
            chunk.accelerometer_mps2[rows],
            None if field is None else field[rows],
            chunk.quality[rows],
        )
        values, flags = self._tracker.released(worn)
        if self._shoes is not None:
            if force is None or moment is None:
                self._shoes.take(None, None, ticks)
            else:
                self._shoes.take(force[rows], moment[rows], ticks)
        if flags.shape[1]:
            self._write(values, flags)
        shown = self._waiting.values[0, :ticks].copy()
        self._waiting.drop(ticks)
        q, points, scalars, flag, sigmas, point_sigmas = self._columns
        feet, places = len(self._feet), len(self._layout.points)
        return frames_of(
            self._layout,
            chunk.first_tick,
            chunk.time_step_s,
            shown[:, q].reshape(ticks, feet, 4),
            shown[:, points].reshape(ticks, places, 3),
            shown[:, scalars].copy(),
            shown[:, flag].astype(np.uint8),
            shown[:, sigmas].reshape(ticks, feet, 3),
            shown[:, point_sigmas].reshape(ticks, places, 3),
        )

    def _worn_rows(self, chunk: ImuChunk) -> list[int] | slice:
        """Return which sensors are followed; all of them nearly always, and a list of them would copy."""
        return slice(None) if self._rows == list(range(chunk.sensor_count)) else self._rows

    def _nothing(self) -> Float:
        """Return the row of a tick of which nothing is known."""
        feet = len(self._feet)
        points = np.full((len(self._layout.points), 3), np.nan)
        for number, side in enumerate(self._feet):
            points[number] = apart(np.zeros(3), side)
        return np.concatenate(
            [
                rotation.identity((feet,)).ravel(),
                points.ravel(),
                np.full(len(self._layout.scalars), np.nan),
                np.full(feet, float(OrientationFlag.INVALID)),
                np.full(3 * (feet + len(points)), np.nan),
            ]
        )

    def _write(self, values: Float, flags: NDArray[np.uint8]) -> None:
        """Let the rows of what the tracker gave away wait."""
        rows = self._waiting.append(flags.shape[1])[0]
        feet = Feet(self._heels, self._steps.right, self._steps.settings, self._steps.memory, self._offset_m)
        if self._shoes is None:
            write_feet(values, flags, feet, rows)
        else:
            write_shoes(values, flags, feet, self._shoes.loads, self._shoes.shoes, rows)
            self._shoes.released(len(rows))

    def calibrate(self, pose: ImuChunk, method: str = "static") -> Calibration:
        """Refuse: where a sensor sits on the foot is found from the walk."""
        raise CalibrationError(say("calibration.walk_needs_none"))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        own = self._steps.state() | {"waiting": self._waiting.values[0].copy()}
        return self._tracker.state() | own | ({} if self._shoes is None else self._shoes.state())

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        self._waiting.refill(state["waiting"][None])
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
    attitude_sigma_rad: Float,
    position_sigma_m: Float,
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
        segment_sigma_rad=attitude_sigma_rad,
        point_sigma_m=position_sigma_m,
    )


def level_sigma(sigma: Float) -> Float:
    """Return sigmas along or about the axes of a foot's own world in those of the room, shape (K, 3).

    The room is turned about the vertical. How the errors along both level axes hang together is not stated, so each
    gets the root mean square of both; NaN where the filter has nothing to say.
    """
    level = np.sqrt(0.5 * (sigma[:, 0] ** 2 + sigma[:, 1] ** 2))
    found = np.stack([level, level, sigma[:, 2]], axis=1)
    return np.where(np.isfinite(found), found, np.nan)


def _live_shoes(setup: SessionSetup, tracker: FootTracker) -> LiveShoes:
    # What the tracker releases is older than its delay less one release.
    behind = tracker.delay_ticks - round(tracker.parameters["release_s"] * setup.rate_hz) - 2
    return LiveShoes(
        1.0 / setup.rate_hz,
        CENTRE_PER_STATURE * setup.body.stature_m,
        is_apart_measured=setup.feet_apart_m is not None,
        ahead_ticks=max(0, min(round(_AHEAD_S * setup.rate_hz), behind)),
        delay_ticks=tracker.delay_ticks,
    )


def apart(position_m: Float, side: Side) -> Float:
    """Return a position (m, world) moved to the foot's side by half the usual distance between feet."""
    aside = 0.5 * USUAL_APART_M * (1.0 if side == "left" else -1.0)
    return np.asarray(position_m + np.array([0.0, aside, 0.0]))


def flags_of(flags: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Say in the words of frames what is known of a foot; HEADING_NOT_TRUSTED: nor its place, after a long gap."""
    invalid = (flags & (FootFlag.INVALID | FootFlag.NO_STANCE)) != 0
    bits = (
        invalid * OrientationFlag.INVALID
        + ((flags & FootFlag.BRIDGED) != 0) * OrientationFlag.BRIDGED
        + ((flags & FootFlag.PLACE_LOST) != 0) * OrientationFlag.HEADING_NOT_TRUSTED
        + ((flags & FootFlag.SATURATED) != 0) * OrientationFlag.SATURATED
    )
    return np.asarray(bits, dtype=np.uint8)
