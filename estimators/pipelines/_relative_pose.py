"""The relative-pose pipeline: one worn magnetic source and the sensors around it, and what the source is to do next."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from estimators import orientation, rotation
from estimators.errors import CalibrationError, ShapeError
from estimators.magnetic import (
    RelativeChunk,
    RelativeFlag,
    RelativePoseFilter,
    RelativePoseParameters,
    RelativeResult,
    read_coil_state,
)
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, Pipeline, SessionSetup
from estimators.pipelines._relative_columns import (
    angle_flags,
    angles_of,
    frame_flags,
    layout_of,
    room_sigma,
    sensor_scalars,
)
from estimators.pipelines._relative_source import (
    ROUND_TRIP_S,
    SourceSettings,
    direction_between,
    settings_of,
    way_between,
)
from estimators.pipelines._worn_filter import WornPoseFilter
from estimators.recording import Float, ImuChunk, SampleQuality

_AT_SCALE: Final = 0.99
"""What clips at full scale comes a little lower as float32 or as counts."""
_HEIGHT_M: Final = 1.0
_SHOE_HEIGHT_M: Final = 0.08


@dataclass(frozen=True)
class ModulesChunk(ImuChunk):
    """Ticks whose poses are known from the whole session.

    Attributes
    ----------
    modules : tuple of RelativeResult
        Of these ticks, one a sensor; the source has none.
    """

    modules: tuple[RelativeResult, ...]


class RelativePosePipeline(Pipeline):
    """A worn source and sensors to the pose of each sensor against the source, with its full covariance.

    Segments are the modules themselves, source first; the room is levelled by gravity, its heading that of the
    source's gyroscope. The source is drawn at a fixed place: where the person walks is not measured. The setup's
    `orientation_parameters` are `SourceSettings` and `RelativePoseParameters`. Every sensor has a filter of its own;
    of several requests the source is asked for the longest, the others use that pulse too. Nothing is to be
    calibrated by hand: the filters take the first two seconds of standing still.
    """

    name: ClassVar[str] = "relative_pose"
    version: ClassVar[str] = "2"
    title: ClassVar[str] = "Relative pose by magnetic source"

    def __init__(self, setup: SessionSetup) -> None:
        self._setup = setup
        self._settings, overrides = settings_of(setup)
        self._source_row = setup.placements.index(self._settings.source)
        self._rows = [row for row in range(len(setup.placements)) if row != self._source_row]
        self._sensors = tuple(setup.placements[row] for row in self._rows)
        self._step_s = 1.0 / setup.rate_hz
        self._coils = self._settings.coils
        self._filters: list[RelativePoseFilter] = [
            WornPoseFilter(
                self._coils,
                self._step_s,
                {
                    "mounting_direction": direction_between(self._settings.source, name),
                    "response_s": ROUND_TRIP_S,
                    "current_a": min(1.3, self._settings.current_limit_a),
                    **overrides,
                    "full_scale_t": _AT_SCALE
                    * overrides.get("full_scale_t", RelativePoseParameters().full_scale_t),
                },
                way_between(self._settings.source, name),
            )
            for name in self._sensors
        ]
        self._level = orientation.create("vqf", 1, self._step_s)
        self._layout = layout_of(self._settings.source, self._sensors)
        angles = len(self._layout.angles)
        self._next_tick = 0
        self._last_angle = np.zeros(angles)
        self._turns = np.zeros(angles, dtype=np.int64)
        self._on_ticks = 0
        self._account = np.zeros(2)

    @property
    def layout(self) -> FrameLayout:
        """Column names of every `Frames` this pipeline gives."""
        return self._layout

    @property
    def setup(self) -> SessionSetup:
        """The setup, as it was given."""
        return self._setup

    @property
    def source(self) -> SourceSettings:
        """Where the source is worn, and its coils."""
        return self._settings

    @property
    def filters(self) -> dict[str, RelativePoseFilter]:
        """The filter of each sensor."""
        return dict(zip(self._sensors, self._filters, strict=True))

    def step(self, chunk: ImuChunk) -> Frames:
        """Take the next ticks of all sensors, in the order of `setup.placements`."""
        if chunk.first_tick != self._next_tick:
            raise ShapeError(f"the chunk starts at tick {chunk.first_tick}; tick {self._next_tick} is next")
        if chunk.sensor_count != len(self._setup.placements):
            raise ShapeError(f"{chunk.sensor_count} sensors; this session has {len(self._setup.placements)}")
        row = slice(self._source_row, self._source_row + 1)
        levelled = self._level.update(
            replace(
                chunk,
                gyroscope_radps=chunk.gyroscope_radps[row],
                accelerometer_mps2=chunk.accelerometer_mps2[row],
                # The field of its own coils is all that a magnetometer beside them sees.
                magnetometer_t=None,
                quality=chunk.quality[row],
                coil_state=None,
            )
        )
        coil, current, wrong = self._state_of(chunk)
        ticks = chunk.tick_count
        if isinstance(chunk, ModulesChunk):
            found = list(chunk.modules)
        else:
            found = [self._update(i, chunk, coil, current) for i in range(len(self._rows))]
        self._next_tick = chunk.first_tick + ticks
        q_source = np.ascontiguousarray(levelled.q_earth_sensor[0])
        segments = len(self._sensors) + 1
        q, point = np.empty((ticks, segments, 4)), np.empty((ticks, segments, 3))
        flags = np.empty((ticks, segments), dtype=np.uint8)
        sigma = np.full((ticks, segments, 3), np.nan)
        # Its heading is that of the room, so that it cannot be wrong.
        q[:, 0], flags[:, 0] = q_source, levelled.flags[0] & _NOT_HEADING
        point[:, 0] = [0.0, 0.0, _SHOE_HEIGHT_M if "foot" in self._settings.source else _HEIGHT_M]
        scalars, angles, spreads = [], [], []
        for i, result in enumerate(found):
            told = result.flags | np.where(wrong, _FAULT, np.uint16(0))
            known = (told & _INVALID) == 0
            q[:, i + 1] = rotation.multiply(q_source, result.q_source_sensor)
            away = rotation.rotate(q_source, result.position_m)
            point[:, i + 1] = np.where(known[:, None], point[:, 0] + away, np.nan)
            flags[:, i + 1] = frame_flags(told)
            scalars.append(sensor_scalars(result, told, known))
            turned, spread = angles_of(result, known)
            angles.append(turned)
            spreads.append(spread)
            sigma[:, i + 1] = room_sigma(q[:, i + 1], result.covariance, known)
        angle = np.concatenate(angles, axis=1)
        spread = np.concatenate(spreads, axis=1)
        return Frames(
            layout=self._layout,
            first_tick=chunk.first_tick,
            time_step_s=chunk.time_step_s,
            q_room_segment=q,
            point_room_m=point,
            angle_rad=self._unwrapped(angle),
            angle_sigma_rad=spread,
            scalar=np.concatenate([*scalars, self._source_scalars(coil, current, found)], axis=1),
            segment_flags=flags,
            angle_flags=angle_flags(flags, angle),
            segment_sigma_rad=sigma,
        )

    def _state_of(self, chunk: ImuChunk) -> tuple[NDArray[np.int64], Float, NDArray[np.bool_]]:
        """Return what the source did at each tick; nothing where that is not known."""
        if chunk.coil_state is None:
            nothing = np.zeros(chunk.tick_count)
            return nothing.astype(np.int64), nothing, nothing > 0.0
        coil, current, wrong = read_coil_state(np.nan_to_num(chunk.coil_state[self._source_row]))
        # A coil that fires where no source is said to be: the modules are exchanged.
        elsewhere = (np.nan_to_num(chunk.coil_state[self._rows]) != 0.0).any(axis=0)
        return coil, current, wrong | elsewhere | (coil > len(self._coils.coils))

    def _update(self, i: int, chunk: ImuChunk, coil: NDArray[np.int64], current: Float) -> RelativeResult:
        return self._filters[i].update(self._samples(i, chunk, coil, current))

    def table(self, sensor: str, chunk: ImuChunk) -> Float:
        """Return what the filter of a sensor takes, shape (K, 17): for those who run it themselves."""
        coil, current, _ = self._state_of(chunk)
        return self._samples(self._sensors.index(sensor), chunk, coil, current).table()

    def _samples(self, i: int, chunk: ImuChunk, coil: NDArray[np.int64], current: Float) -> RelativeChunk:
        """Return the samples of one filter; what was bridged is no sample, least of all of a pulse."""
        row, source = self._rows[i], self._source_row
        lost = ((chunk.quality[row] | chunk.quality[source]) & _NOT_MEASURED) != 0
        field = chunk.magnetometer_t
        unseen = np.full((chunk.tick_count, 3), np.nan)
        own, force, seen, worn, worn_force = (
            np.where(lost[:, None], np.nan, values) if lost.any() else values
            for values in (
                chunk.gyroscope_radps[row],
                chunk.accelerometer_mps2[row],
                unseen if field is None else field[row],
                chunk.gyroscope_radps[source],
                chunk.accelerometer_mps2[source],
            )
        )
        return RelativeChunk(
            chunk.first_tick, chunk.time_step_s, own, force, seen, worn, worn_force, coil, current
        )

    def _source_scalars(self, coil: NDArray[np.int64], current: Float, found: list[RelativeResult]) -> Float:
        """Return what the source does, is to do, and has used."""
        ticks = len(coil)
        asked = np.zeros((ticks, 3))
        for result in found:
            # A start needs longer pulses than tracking: who asks for the longest goes first.
            first = result.fire_ticks > asked[:, 2]
            for column, values in enumerate((result.fire_coil, result.fire_current_a, result.fire_ticks)):
                asked[first, column] = values[first]
        on = self._on_ticks + np.cumsum(coil > 0)
        used = np.abs(current) * self._step_s, current * current * self._step_s
        charge, squared = (
            np.cumsum(np.concatenate([self._account[k : k + 1], used[k]]))[1:] for k in range(2)
        )
        if ticks:
            self._on_ticks = int(on[-1])
            self._account = np.array([charge[-1], squared[-1]])
        return np.column_stack([coil, current, asked, on * self._step_s, charge, squared])

    def _unwrapped(self, angle: Float) -> Float:
        """Let angles go on beyond half a turn; unknown ones neither turn nor are remembered."""
        known = np.isfinite(angle)
        rows = np.arange(len(angle))[:, None]
        # Row of the last known angle at or before each; -1 for the one remembered.
        last = np.maximum.accumulate(np.where(known, rows, -1), axis=0)
        held = np.concatenate([self._last_angle[None], angle])
        filled = np.take_along_axis(held, np.concatenate([np.zeros_like(last[:1]), last + 1]), axis=0)
        turned = np.rint(np.diff(filled, axis=0) / (2.0 * np.pi)).astype(np.int64)
        turns = self._turns - np.cumsum(turned, axis=0)
        if len(angle):
            self._last_angle, self._turns = filled[-1].copy(), turns[-1].copy()
        return np.asarray(angle + 2.0 * np.pi * turns)

    def calibrate(self, pose: ImuChunk, method: str = "static") -> Calibration:
        """Refuse: the filters calibrate themselves while the person stands still at the start."""
        raise CalibrationError("a magnetic session needs no calibration pose; stand still for three seconds")

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        state = {f"level.{name}": values for name, values in self._level.state().items()}
        for name, one in self.filters.items():
            state |= {f"{name}.{key}": values for key, values in one.state().items()}
        state["next_tick"] = np.array(self._next_tick, dtype=np.int64)
        state["on_ticks"] = np.array(self._on_ticks, dtype=np.int64)
        state["last_angle"], state["turns"] = self._last_angle.copy(), self._turns.copy()
        state["account"] = self._account.copy()
        return state

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        if missing := {"next_tick", "on_ticks", "last_angle", "turns", "account"} - set(state):
            raise ShapeError(f"this state has no {', '.join(sorted(missing))}; it is of another pipeline")
        self._level.restore(_part(state, "level"))
        for name, one in self.filters.items():
            one.restore(_part(state, name))
        self._next_tick, self._on_ticks = int(state["next_tick"]), int(state["on_ticks"])
        self._last_angle = np.array(state["last_angle"], dtype=np.float64)
        self._turns = np.array(state["turns"], dtype=np.int64)
        self._account = np.array(state["account"], dtype=np.float64)


_FAULT, _INVALID = np.uint16(int(RelativeFlag.FAULT)), np.uint16(int(RelativeFlag.INVALID))
_NOT_HEADING: Final = np.uint8(255 - int(OrientationFlag.HEADING_NOT_TRUSTED))
_NOT_MEASURED: Final = int(SampleQuality.MISSING | SampleQuality.BRIDGED)


def _part(state: Mapping[str, NDArray[Any]], name: str) -> dict[str, NDArray[Any]]:
    prefix = f"{name}."
    return {key.removeprefix(prefix): values for key, values in state.items() if key.startswith(prefix)}


__all__ = ["ModulesChunk", "RelativePosePipeline"]
