"""A pool of live arm sessions: pipelines whose arrays are views of its rows, and one step for all of them."""

from collections.abc import Callable, Hashable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.arm._kernel import evaluate_kernel
from estimators.balance.mass_centre._worn_kernel import mass_centre
from estimators.kernels.by_address import address_of
from estimators.kernels.slots import into_row
from estimators.leg._kernel import leg_kernel
from estimators.orientation.telemotion import TelemotionEstimator
from estimators.orientation.telemotion._kernel import end_block, fill_gap, run
from estimators.pipelines._contract import Frames, Pipeline
from estimators.pipelines.arm.kernel import compose
from estimators.pipelines.arm.pipeline import ArmPipeline
from estimators.pipelines.arm.pooled_kernel import step_arms
from estimators.pipelines.arm.rows import ArmRows, ArmTables, ArmWork, arm_rows, arm_work
from estimators.pipelines.pooled import Columns, columns
from estimators.recording import Float

CALLED: Final[tuple[Callable[..., Any], ...]] = (run, evaluate_kernel, leg_kernel, mass_centre)
"""Kernels that the step calls by their address: of filter, arm model, legs and centre of mass."""
APART: Final[tuple[Callable[..., Any], ...]] = (end_block, fill_gap, compose)
"""Most of the filter, and how it is put on the segments: another process may compile these while one does the rest."""
STRETCH_TICKS: Final = 64
"""Most ticks of a stretch: those of the longest packet, and one more off the grid."""
_STORED: Final = Columns._fields.index("segment_sigma_rad")
_NONE: Final = np.empty(0, dtype=np.int64)


class ArmPool:
    """Rows of arm sessions with equal sensors, rate and filter settings; implements `Pool`.

    Sessions that are calibrated and use our own filter join, without calibrations made in the hand and without the
    constraint of joint headings: those run through `ArmPipeline.step`.
    """

    def __init__(
        self, like: Pipeline, channels: int, sessions: int, rows: int, carried: Mapping[str, slice]
    ) -> None:
        assert isinstance(like, ArmPipeline)
        network, model, mass = like._network, like._model, like._mass
        assert isinstance(network._filter, TelemotionEstimator)
        assert model is not None
        self.sessions = sessions
        self.layout = like.layout
        self._sensors = network.sensor_count
        self._time_step_s = network.time_step_s
        self._tables = ArmTables(
            channels,
            network._filter._settings,
            model._columns.source,
            model._columns.point,
            model._columns.angle,
            model._columns.scalar,
            _NONE if mass is None else mass._source,
            like._legs._table,
            *map(address_of, CALLED),
        )
        self.rows = arm_rows(sessions, self._sensors, len(network._memory_tick))
        self._work: ArmWork = arm_work(self._sensors, STRETCH_TICKS + 1)
        self.columns = columns(rows, self.layout)
        self.errors: dict[int, tuple[int, Exception]] = {}

    @staticmethod
    def key(pipeline: Pipeline) -> Hashable | None:
        """Return what sessions of a pool have in common; None when the pipeline can be in none as it stands."""
        if not isinstance(pipeline, ArmPipeline):
            return None
        network, setup = pipeline._network, pipeline.setup
        if (
            not isinstance(network._filter, TelemotionEstimator)
            or pipeline._model is None
            or pipeline._headings is not None
            or setup.devices
            or not network.is_calibrated
        ):
            return None
        return setup.placements, setup.rate_hz, network._filter._settings.tobytes(), pipeline.layout

    def join(self, slot: int, pipeline: Pipeline) -> bool:
        """Let a pipeline go on over the rows of a slot; see `Pool.join`."""
        if not isinstance(pipeline, ArmPipeline):
            return False
        network, r = pipeline._network, self.rows
        estimator = network._filter
        if not isinstance(estimator, TelemotionEstimator):
            return False
        a, b = slot * self._sensors, (slot + 1) * self._sensors
        # A pose, a restart or another calibration gives the pipeline new arrays; what is a view already stays.
        estimator._state = into_row(estimator._state, r.state[a:b])
        estimator._covariance = into_row(estimator._covariance, r.covariance[a:b])
        estimator._guard.memory = into_row(estimator._guard.memory, r.screen[a:b])
        network._q_room_earth = into_row(network._q_room_earth, r.q_room_earth[a:b])
        network._q_sensor_segment = into_row(network._q_sensor_segment, r.q_sensor_segment[a:b])
        network._more_flags = into_row(network._more_flags, r.more_flags[a:b])
        network._memory_tick = into_row(network._memory_tick, r.memory_tick[slot])
        network._memory_q = into_row(network._memory_q, r.memory_q[slot])
        network._memory_flags = into_row(network._memory_flags, r.memory_flags[slot])
        pipeline._previous_angle_rad = into_row(pipeline._previous_angle_rad, r.previous_angle[slot])
        has_mounting = len(network._mounting_variance) > 0
        if has_mounting:
            network._mounting_variance = into_row(network._mounting_variance, r.mounting_variance[a:b])
        network._accelerometer_bias = into_row(network._accelerometer_bias, r.force_bias[a:b])
        x: Any = r.session[slot]
        x["has_force_bias"], x["has_mounting"] = network._has_accelerometer_bias, has_mounting
        x["memory_stride"], x["step_s"] = network._stride, network.time_step_s
        if pipeline._model is not None:
            r.lengths[slot] = pipeline._model._columns.lengths_m
        mass = pipeline._mass
        if mass is not None:
            r.mass_settings[slot], r.mass_middle[slot] = mass._standing, mass._middle
            r.lever[slot], r.doubt[slot], r.has_doubt[slot], r.feet[slot] = (
                mass._lever,
                mass._doubt,
                mass._has_doubt,
                mass._feet,
            )
        return True

    def leave(self, slot: int, pipeline: Pipeline) -> None:
        """Give a pipeline arrays of its own again."""
        if not isinstance(pipeline, ArmPipeline):
            return
        network = pipeline._network
        estimator = network._filter
        if isinstance(estimator, TelemotionEstimator):
            estimator._state, estimator._covariance = estimator._state.copy(), estimator._covariance.copy()
            estimator._guard.memory = estimator._guard.memory.copy()
        for name in (
            "_q_room_earth",
            "_q_sensor_segment",
            "_more_flags",
            "_memory_tick",
            "_memory_q",
            "_memory_flags",
            "_mounting_variance",
            "_accelerometer_bias",
        ):
            setattr(network, name, getattr(network, name).copy())
        pipeline._previous_angle_rad = pipeline._previous_angle_rad.copy()

    def step(
        self,
        stretches: NDArray[np.void],
        count: int,
        signals: Float,
        quality: NDArray[np.uint8],
        carried: Float,
    ) -> None:
        """Take the next ticks of some sessions; see `Pool.step`. What comes beside motion tells an arm nothing."""
        step_arms(stretches, count, signals, quality, *self.arrays)

    @property
    def arrays(self) -> tuple[ArmRows, ArmTables, ArmWork, Columns]:
        """What `step_arms` works on."""
        return self.rows, self._tables, self._work, self.columns

    def stepped(self, pipeline: Pipeline, next_tick: int) -> None:
        """Carry on what a pipeline knows beside its rows; see `Pool.stepped`."""
        network = pipeline._network  # type: ignore[attr-defined]
        network._next_tick = network._filter._guard.next_tick = next_tick

    def frames(self, first_tick: int, start: int, stop: int) -> Frames:
        """Return a copy of some rows as frames; see `Pool.frames`."""
        # As stored live: angles carry their own sigma.
        found: Any = [values[start:stop].copy() for values in self.columns[:_STORED]]
        return Frames(self.layout, first_tick, self._time_step_s, *found)
