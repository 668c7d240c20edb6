"""The relative-pose pipeline: one worn magnetic source and the sensors around it, and what the source is to do next."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from estimators import orientation
from estimators.errors import CalibrationError, ShapeError
from estimators.magnetic import RelativePoseFilter, RelativePoseParameters, RelativeResult
from estimators.magnetic.relative import layout as at
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, Pipeline, SessionSetup
from estimators.pipelines._worn_filter import WornPoseFilter
from estimators.pipelines.relative import kernel
from estimators.pipelines.relative.columns import layout_of, table_of
from estimators.pipelines.relative.source import (
    ROUND_TRIP_S,
    SourceSettings,
    direction_between,
    settings_of,
    way_between,
)
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

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
    axes: ClassVar[str] = ""
    filter: ClassVar[str] = "relative_pose"
    begins_anywhere: ClassVar[bool] = False
    is_uploaded: ClassVar[bool] = False

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
        self._height_m = _SHOE_HEIGHT_M if "foot" in self._settings.source else _HEIGHT_M
        angles = len(self._layout.angles)
        self._next_tick = 0
        self._last_angle = np.zeros(angles)
        self._turns = np.zeros(angles, dtype=np.int64)
        self._account = np.zeros(kernel.ACCOUNT)

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
        samples, wrong = self._samples(chunk)
        row = slice(self._source_row, self._source_row + 1)
        levelled = self._level.update(
            # The field of its own coils is all that a magnetometer beside them sees.
            ImuChunk(
                chunk.first_tick,
                chunk.time_step_s,
                chunk.gyroscope_radps[row],
                chunk.accelerometer_mps2[row],
                None,
                chunk.quality[row],
            )
        )
        if isinstance(chunk, ModulesChunk):
            outs = np.stack([table_of(result) for result in chunk.modules])
        else:
            outs = np.stack([one.run(part) for one, part in zip(self._filters, samples, strict=True)])
        ticks, segments, angles = chunk.tick_count, len(self._sensors) + 1, len(self._layout.angles)
        self._next_tick = chunk.first_tick + ticks
        written = kernel.Written(
            np.empty((ticks, segments, 4)),
            np.empty((ticks, segments, 3)),
            np.empty((ticks, segments, 3)),
            np.empty((ticks, segments), np.uint8),
            np.empty((ticks, angles)),
            np.empty((ticks, angles)),
            np.empty((ticks, angles), np.uint8),
            np.empty((ticks, len(self._layout.scalars))),
        )
        kernel.write_frames(
            levelled.q_earth_sensor[0],
            levelled.flags[0],
            samples,
            outs,
            wrong,
            self._height_m,
            self._step_s,
            kernel.Running(self._account, self._last_angle, self._turns),
            written,
        )
        return Frames(
            self._layout,
            chunk.first_tick,
            chunk.time_step_s,
            written.q,
            written.point_m,
            written.angle_rad,
            written.angle_sigma_rad,
            written.scalar,
            written.flags,
            written.angle_flags,
            written.sigma_rad,
        )

    def table(self, sensor: str, chunk: ImuChunk) -> Float:
        """Return what the filter of a sensor takes, shape (K, 17): for those who run it themselves."""
        samples, _ = self._samples(chunk)
        return np.asarray(samples[self._sensors.index(sensor)])

    def _samples(self, chunk: ImuChunk) -> tuple[Float, NDArray[np.bool_]]:
        """Return what the filters take, shape (N, K, 17), and where the coil states cannot be."""
        field, state = chunk.magnetometer_t, chunk.coil_state
        sensors, ticks = len(self._setup.placements), chunk.tick_count
        if chunk.sensor_count != sensors:
            raise ShapeError(f"{chunk.sensor_count} sensors; this session has {sensors}")
        each, whole = (sensors, ticks), (sensors, ticks, 3)
        if (
            (chunk.gyroscope_radps.shape, chunk.accelerometer_mps2.shape) != (whole, whole)
            or chunk.quality.shape != each
            or (field is not None and field.shape != whole)
            or (state is not None and state.shape != each)
        ):
            raise ShapeError(
                f"signals of {sensors} sensors at {ticks} ticks are of other shapes than {whole}"
            )
        samples = np.empty((len(self._rows), ticks, at.SAMPLE))
        wrong = np.empty(ticks, dtype=np.bool_)
        kernel.take(
            np.asarray(chunk.gyroscope_radps, dtype=np.float64),
            np.asarray(chunk.accelerometer_mps2, dtype=np.float64),
            _NO_FIELD if field is None else np.asarray(field, dtype=np.float64),
            np.asarray(chunk.quality, dtype=np.uint8),
            _NO_STATE if state is None else np.asarray(state, dtype=np.float64),
            self._source_row,
            len(self._coils.coils),
            samples,
            wrong,
        )
        return samples, wrong

    def calibrate(self, pose: ImuChunk, method: str = "static") -> Calibration:
        """Refuse: the filters calibrate themselves while the person stands still at the start."""
        raise CalibrationError(say("calibration.magnetic_needs_none"))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        state = {f"level.{name}": values for name, values in self._level.state().items()}
        for name, one in self.filters.items():
            state |= {f"{name}.{key}": values for key, values in one.state().items()}
        state["next_tick"] = np.array(self._next_tick, dtype=np.int64)
        state["on_ticks"] = np.array(self._account[kernel.ON_TICKS], dtype=np.int64)
        state["last_angle"], state["turns"] = self._last_angle.copy(), self._turns.copy()
        state["account"] = self._account[kernel.CHARGE :].copy()
        return state

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        if missing := {"next_tick", "on_ticks", "last_angle", "turns", "account"} - set(state):
            raise ShapeError(f"this state has no {', '.join(sorted(missing))}; it is of another pipeline")
        self._level.restore(_part(state, "level"))
        for name, one in self.filters.items():
            one.restore(_part(state, name))
        self._next_tick = int(state["next_tick"])
        self._last_angle = np.array(state["last_angle"], dtype=np.float64)
        self._turns = np.array(state["turns"], dtype=np.int64)
        self._account = np.array([state["on_ticks"], *state["account"]], dtype=np.float64)


_NO_FIELD, _NO_STATE = np.empty((0, 0, 3)), np.empty((0, 0))


def _part(state: Mapping[str, NDArray[Any]], name: str) -> dict[str, NDArray[Any]]:
    prefix = f"{name}."
    return {key.removeprefix(prefix): values for key, values in state.items() if key.startswith(prefix)}
