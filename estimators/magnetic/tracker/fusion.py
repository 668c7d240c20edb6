"""The three-coil tracker fused with inertial sensing: the published complementary filter (Roetenberg 2006, ch. 6).

A filter of errors beside a strapdown of the difference between two modules. It takes whole fixes of the tracker and
orientations of the filters of chapter 2, where `RelativePoseFilter` takes single pulses and neither: keep this for
sources that fire by themselves and for comparison.

Frames: world with z up (that of `q_world_source`), source, sensor. Errors are truth minus estimate, turns in the world
(eq. 6.9): position, velocity, orientation, offsets of accelerometer and gyroscope, error of the fix in position and in
orientation. The last two are white; they carry the noise of the fix, which is therefore nowhere else (erratum E3). The
22nd to 24th (eq. 6.19) are what the sensor's orientation filter is off, the 25th to 27th the offset of the source's
accelerometer (erratum E6).

What is uncertain, and where it is:

- The world is the one that the source's orientation filter says. In it the source's attitude has no error, gravity
  cancels in the difference of the modules as it does in the true one, and a constant error of that filter does nothing
  at all to the pose against the source (it is the metamorphic check 2 of the page). Only its wandering does: it turns
  this world by w a step, whose variance for an error of sigma s and time constant T is s^2 (1 - exp(-2 dt / T)). The
  page's acceleration of 0.3 m/s^2 that "both attitudes leak" is thereby nought; what the sensor's attitude leaks is in
  the dynamics already.
- Against this world the sensor's filter is off by both filters' errors, variance 2 s^2, and for as long as T: states,
  not noise of a row. Rows with a white 3 degrees each 0.6 s, as the page inflates them, claim too much after an hour
  and too little at once.
- Both accelerometers have offsets, each with its own axes.
- A fix has the covariance of its burst (`locate_moving`), position and orientation in one: they are correlated by 0.95,
  and the orientation filter, which is better than a fix in orientation, therefore also takes most of the error of a
  fix across the line of sight.
- What moves during a burst is carried by the inertial signals; what it depends on the velocity is a row of the
  measurement. A fix without that, solved as if nothing moved, has `burst_motion_s` instead.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError, ShapeError
from estimators.kernels.array_filter import ArrayFilter, with_overrides
from estimators.magnetic.tracker import fusion_layout as at
from estimators.magnetic.tracker.fusion_run import run
from estimators.recording import Float
from estimators.samples import Samples

_INVALID, _GATED = at.INVALID, at.GATED


@dataclass(frozen=True)
class TrackerFusionParameters:
    """Figures of the method page (2.2); noise is per sample.

    `fix_position_sigma_m` is that of a fix without a covariance, up to `fix_distance_m`, growing with the fourth power
    beyond; `fix_attitude_sigma_deg` its orientation. A fix with one may have `floor_position_m` and
    `floor_attitude_deg` on top, for what its covariance leaves out. A fix that was solved as if nothing moved in its
    burst counts for less by the relative rate over `burst_motion_s`, as turn and as way at its distance.
    `use_fix_attitude` and `use_filter_attitude` choose the variants of 6.2.5: the tracker's orientation, that of the
    orientation filter, or both, weighed by their covariances (erratum E4). Both modules' orientation filters wander
    with `filter_attitude_sigma_deg` an axis and `filter_attitude_time_s` (page 4.2). `force_bias_sigma_mps2` is of
    each accelerometer; `rate_bias_sigma_radps` holds where nobody stood still first. `gate` and `fix_gate` are the
    chi-squares of three and six degrees of freedom above which rows are left out; three fixes in a row start again.
    """

    force_sigma_mps2: float = 0.05
    rate_sigma_radps: float = 0.01
    force_bias_sigma_mps2: float = 0.02
    rate_bias_sigma_radps: float = 0.003
    force_bias_walk_mps2: float = 1e-3
    rate_bias_walk_radps: float = 1e-5
    fix_position_sigma_m: float = 0.008
    fix_distance_m: float = 0.45
    fix_attitude_sigma_deg: float = 4.0
    floor_position_m: float = 0.0
    floor_attitude_deg: float = 0.0
    burst_motion_s: float = 0.1
    filter_attitude_sigma_deg: float = 1.2
    filter_attitude_time_s: float = 10.0
    use_fix_attitude: bool = True
    use_filter_attitude: bool = True
    attitude_interval_s: float = 0.6
    gate: float = 16.27
    fix_gate: float = 22.46
    still_rate_radps: float = 0.15


_MAY_BE_ZERO = {"force_bias_walk_mps2", "rate_bias_walk_radps", "floor_position_m"}
_MAY_BE_ZERO |= {"floor_attitude_deg", "burst_motion_s"}


@dataclass(frozen=True)
class TrackerFusionChunk(Samples):
    """Consecutive ticks of both modules, with the tracker's fixes at the ticks that they are of.

    Attributes
    ----------
    gyroscope_radps, accelerometer_mps2, source_accelerometer_mps2 : ndarray, shape (K, 3)
        NaN where missing.
    q_world_source : ndarray, shape (K, 4)
        Of the source's orientation filter, which must not have seen pulses.
    q_world_sensor : ndarray, shape (K, 4)
        Of the sensor's orientation filter; NaN for none.
    fix_position_m : ndarray, shape (K, 3)
        Of the sensor in the source frame, at the middle of the burst; NaN for none.
    fix_q_source_sensor : ndarray, shape (K, 4)
    fix_covariance : ndarray, shape (K, 6, 6)
        As `Fix.covariance`; NaN for the law of the parameters.
    fix_velocity_mps, fix_velocity_effect : ndarray, shape (K, 3), (K, 6, 3), optional
        As those of `CarriedFix`; NaN or None for a fix that was solved as if nothing moved.
    """

    first_tick: int
    time_step_s: float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    source_accelerometer_mps2: Float
    q_world_source: Float
    q_world_sensor: Float
    fix_position_m: Float
    fix_q_source_sensor: Float
    fix_covariance: Float
    fix_velocity_mps: Float | None = None
    fix_velocity_effect: Float | None = None

    def table(self) -> Float:
        """Return the samples as the compiled loop takes them, shape (K, 81)."""
        count = self.tick_count
        table, nothing = np.empty((count, at.SAMPLE)), np.full((count, 18), np.nan)
        for column, width, values in (
            (at.GYROSCOPE, 3, self.gyroscope_radps),
            (at.FORCE, 3, self.accelerometer_mps2),
            (at.SOURCE_FORCE, 3, self.source_accelerometer_mps2),
            (at.SOURCE_ATTITUDE, 4, self.q_world_source),
            (at.FILTER_ATTITUDE, 4, self.q_world_sensor),
            (at.FIX_POSITION, 3, self.fix_position_m),
            (at.FIX_ATTITUDE, 4, self.fix_q_source_sensor),
            (at.FIX_COVARIANCE, 36, self.fix_covariance.reshape(count, -1)),
            (at.FIX_VELOCITY, 3, nothing[:, :3] if self.fix_velocity_mps is None else self.fix_velocity_mps),
            (
                at.FIX_EFFECT,
                18,
                nothing if self.fix_velocity_effect is None else self.fix_velocity_effect.reshape(count, -1),
            ),
        ):
            if values.shape != (count, width):
                raise ShapeError(
                    f"signals of {count} ticks need shape ({count}, {width}), not {values.shape}"
                )
            table[:, column : column + width] = values
        return table


@dataclass(frozen=True)
class TrackerFusionResult:
    """Pose over K ticks.

    Attributes
    ----------
    position_m, q_source_sensor : ndarray, shape (K, 3), (K, 4)
        Of the sensor in the source frame.
    world_position_m, world_velocity_mps : ndarray, shape (K, 3)
        From source to sensor, in world axes.
    q_world_sensor : ndarray, shape (K, 4)
    covariance : ndarray, shape (K, 6, 6)
        Position in source axes, orientation error in sensor axes.
    nis : ndarray, shape (K,)
        Of a fix, six rows (three without its orientation); NaN without one.
    valid : ndarray of bool, shape (K,)
        From the first fix on.
    gated : ndarray of bool, shape (K,)
        Part of a fix was left out.
    """

    position_m: Float
    q_source_sensor: Float
    world_position_m: Float
    world_velocity_mps: Float
    q_world_sensor: Float
    covariance: Float
    nis: Float
    valid: NDArray[np.bool_]
    gated: NDArray[np.bool_]

    @classmethod
    def of_table(cls, out: Float) -> "TrackerFusionResult":
        """Read the output of the compiled loop."""
        status = out[:, at.O_STATUS].astype(np.int64)
        return cls(
            out[:, at.O_POSITION : at.O_POSITION + 3],
            out[:, at.O_ATTITUDE : at.O_ATTITUDE + 4],
            out[:, at.O_WORLD_POSITION : at.O_WORLD_POSITION + 3],
            out[:, at.O_WORLD_VELOCITY : at.O_WORLD_VELOCITY + 3],
            out[:, at.O_WORLD_ATTITUDE : at.O_WORLD_ATTITUDE + 4],
            out[:, at.O_COVARIANCE : at.O_COVARIANCE + 36].reshape(-1, 6, 6),
            out[:, at.O_NIS],
            np.asarray((status & _INVALID) == 0),
            np.asarray((status & _GATED) > 0),
        )


class TrackerFusion(ArrayFilter):
    """Complementary filter of fixes and inertial sensing, forward.

    The same samples give the same result, bit for bit, one by one, in uneven chunks, in one batch, or across `state`
    and `restore`. A fix belongs to the middle of its burst, so that a live user holds samples back until it is solved.
    """

    name: ClassVar[str] = "tracker_fusion"
    version: ClassVar[str] = "2"
    _ARRAYS: ClassVar[tuple[str, ...]] = ("nominal", "covariance", "memory", "counters")

    def __init__(self, time_step_s: float, parameters: Mapping[str, Any] | None = None) -> None:
        if not 1e-4 < time_step_s < 0.1:
            raise SetupError(f"time_step_s must be between 0.1 ms and 100 ms, not {time_step_s}")
        self._time_step_s = time_step_s
        self._parameters = _read(parameters)
        self._settings = _settings(self._parameters, time_step_s)
        self._nominal = np.zeros(at.NOMINAL)
        self._nominal[at.ATTITUDE] = 1.0
        self._covariance = np.zeros((at.ERRORS, at.ERRORS))
        self._memory = np.zeros(at.MEMORY)
        self._counters = np.zeros(at.COUNTERS, dtype=np.int64)

    def update(self, chunk: TrackerFusionChunk) -> TrackerFusionResult:
        """Take the next ticks; `chunk.first_tick` must continue the last one.

        Raises
        ------
        ShapeError
            For arrays of other shapes, another time step, or ticks that do not follow.
        """
        if chunk.first_tick != int(self._counters[at.TICK]):
            raise ShapeError(f"tick {chunk.first_tick} does not follow {int(self._counters[at.TICK]) - 1}")
        if abs(chunk.time_step_s - self._time_step_s) > 1e-9:
            raise ShapeError(f"the filter was built for {self._time_step_s} s, not {chunk.time_step_s} s")
        out = np.empty((chunk.tick_count, at.OUTPUT))
        run(chunk.table(), *self.arrays(), out)
        return TrackerFusionResult.of_table(out)

    def arrays(self) -> tuple[Float, Float, Float, Float, NDArray[np.int64]]:
        """Return the arguments of the compiled loop between samples and output."""
        return self._settings, self._nominal, self._covariance, self._memory, self._counters


def _read(parameters: Mapping[str, Any] | None) -> TrackerFusionParameters:
    result = with_overrides(TrackerFusionParameters(), parameters)
    for name, value in asdict(result).items():
        if not isinstance(value, bool) and (
            not math.isfinite(value) or value < 0.0 or (value == 0.0 and name not in _MAY_BE_ZERO)
        ):
            raise SetupError(f"{name} must be finite and above zero, not {value}")
    return result


def _settings(p: TrackerFusionParameters, time_step_s: float) -> Float:
    settings = np.zeros(at.SETTINGS)
    for position, value in (
        (at.TIME_STEP, time_step_s),
        (at.FORCE_SIGMA, p.force_sigma_mps2),
        (at.RATE_SIGMA, p.rate_sigma_radps),
        (at.FORCE_START, p.force_bias_sigma_mps2),
        (at.RATE_START, p.rate_bias_sigma_radps),
        (at.FORCE_WALK, p.force_bias_walk_mps2),
        (at.RATE_WALK, p.rate_bias_walk_radps),
        (at.FIX_POSITION_SIGMA, p.fix_position_sigma_m),
        (at.FIX_DISTANCE, p.fix_distance_m),
        (at.FIX_ATTITUDE_SIGMA, math.radians(p.fix_attitude_sigma_deg)),
        (at.FILTER_SIGMA, math.radians(p.filter_attitude_sigma_deg)),
        (at.FILTER_TIME, p.filter_attitude_time_s),
        (at.FLOOR_POSITION, p.floor_position_m),
        (at.FLOOR_ATTITUDE, math.radians(p.floor_attitude_deg)),
        (at.BURST_MOTION, p.burst_motion_s),
        (at.USE_FIX_ATTITUDE, float(p.use_fix_attitude)),
        (at.USE_FILTER_ATTITUDE, float(p.use_filter_attitude)),
        (at.ATTITUDE_TICKS, float(max(1, round(p.attitude_interval_s / time_step_s)))),
        (at.GATE, p.gate),
        (at.FIX_GATE, p.fix_gate),
        (at.STILL_RATE, p.still_rate_radps),
    ):
        settings[position] = value
    return settings
