"""VQF (Laidig and Seel, 2023) by its own package, one filter a sensor."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from vqf import VQF

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.orientation._contract import OrientationEstimator, OrientationResult
from estimators.orientation._parameters import read_parameters
from estimators.orientation._streaming import ChunkGuard, bias_array, copied, usable_samples
from estimators.orientation._vqf_quality import COUNTERS, annotate
from estimators.recording import Float, ImuChunk

_MICROTESLA_PER_TESLA = 1e6


@dataclass(frozen=True)
class VqfParameters:
    """The parameters of the package under names with units, at its defaults, and five of ours.

    `restart_*_weight_s`: after a gap the inclination and heading held through it count as much as that
    many seconds of new measurements. `magnetometer_latency_s`: the magnetometer's delay against the
    gyroscope, undone to first order by the measured rate.
    """

    accelerometer_time_constant_s: float = 3.0
    magnetometer_time_constant_s: float = 9.0
    motion_bias_estimation: bool = True
    rest_bias_estimation: bool = True
    magnetic_disturbance_rejection: bool = True
    bias_sigma_initial_degps: float = 0.5
    bias_forgetting_time_s: float = 100.0
    bias_clip_degps: float = 2.0
    bias_sigma_motion_degps: float = 0.1
    bias_vertical_forgetting_factor: float = 0.0001
    bias_sigma_rest_degps: float = 0.03
    rest_minimum_s: float = 1.5
    rest_time_constant_s: float = 0.5
    rest_gyroscope_threshold_degps: float = 2.0
    rest_accelerometer_threshold_mps2: float = 0.5
    magnetic_current_time_constant_s: float = 0.05
    magnetic_reference_time_constant_s: float = 20.0
    magnetic_norm_tolerance: float = 0.1
    magnetic_dip_tolerance_deg: float = 10.0
    magnetic_new_field_s: float = 20.0
    magnetic_first_field_s: float = 5.0
    magnetic_new_field_minimum_degps: float = 20.0
    magnetic_minimum_undisturbed_s: float = 0.5
    magnetic_maximum_rejection_s: float = 60.0
    magnetic_rejection_factor: float = 2.0
    magnetometer_latency_s: float = 0.0
    restart_inclination_weight_s: float = 0.1
    restart_heading_weight_s: float = 0.25
    convergence_s: float = 3.0
    acceleration_tolerance_mps2: float = 2.0


_PACKAGE_NAMES = {
    "accelerometer_time_constant_s": "tauAcc",
    "magnetometer_time_constant_s": "tauMag",
    "motion_bias_estimation": "motionBiasEstEnabled",
    "rest_bias_estimation": "restBiasEstEnabled",
    "magnetic_disturbance_rejection": "magDistRejectionEnabled",
    "bias_sigma_initial_degps": "biasSigmaInit",
    "bias_forgetting_time_s": "biasForgettingTime",
    "bias_clip_degps": "biasClip",
    "bias_sigma_motion_degps": "biasSigmaMotion",
    "bias_vertical_forgetting_factor": "biasVerticalForgettingFactor",
    "bias_sigma_rest_degps": "biasSigmaRest",
    "rest_minimum_s": "restMinT",
    "rest_time_constant_s": "restFilterTau",
    "rest_gyroscope_threshold_degps": "restThGyr",
    "rest_accelerometer_threshold_mps2": "restThAcc",
    "magnetic_current_time_constant_s": "magCurrentTau",
    "magnetic_reference_time_constant_s": "magRefTau",
    "magnetic_norm_tolerance": "magNormTh",
    "magnetic_dip_tolerance_deg": "magDipTh",
    "magnetic_new_field_s": "magNewTime",
    "magnetic_first_field_s": "magNewFirstTime",
    "magnetic_new_field_minimum_degps": "magNewMinGyr",
    "magnetic_minimum_undisturbed_s": "magMinUndisturbedTime",
    "magnetic_maximum_rejection_s": "magMaxRejectionTime",
    "magnetic_rejection_factor": "magRejectionFactor",
}
_STALE_AVERAGES = (
    "restGyrLpState",
    "restAccLpState",
    "motionBiasEstRLpState",
    "motionBiasEstBiasLpState",
    "magNormDipLpState",
)
_OWN_STATE = ("q_earth_sensor", "bias_radps", "counters", "started", "in_gap")


class VqfEstimator(OrientationEstimator):
    """VQF for a network, with gaps, flags and an error budget (see `_vqf_quality.annotate`).

    Without MISSING samples the estimate is that of `vqf.VQF.updateBatch`, sensor by sensor, with the
    magnetometer where it is finite. A MISSING sample holds the last orientation; the first usable one
    after it restarts the averaging of inclination and heading around the held values and keeps the
    gyroscope bias and the reference field.
    """

    name: ClassVar[str] = "vqf"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "VQF"
    description: ClassVar[str] = (
        "Learns the sensor's drift while still and moving and ignores passing magnetic disturbances; "
        "the best choice for most sessions."
    )

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._guard = ChunkGuard(sensor_count, time_step_s)
        self._parameters = read_parameters(VqfParameters, parameters)
        values = asdict(self._parameters)
        for name in ("accelerometer_time_constant_s", "rest_time_constant_s", "bias_forgetting_time_s"):
            if values[name] <= 0.0:
                raise SetupError(f"{name} must be above zero, not {values[name]}")
        package = {_PACKAGE_NAMES[name]: value for name, value in values.items() if name in _PACKAGE_NAMES}
        self._filters = [VQF(self._guard.time_step_s, **package) for _ in range(sensor_count)]
        self._q_earth_sensor = rotation.identity((sensor_count,))
        self._bias_radps = np.zeros((sensor_count, 3))
        self._counters = np.full((sensor_count, COUNTERS), -1, dtype=np.int64)
        self._counters[:, 1:] = 0
        self._started = np.zeros(sensor_count, dtype=np.bool_)
        self._in_gap = np.zeros(sensor_count, dtype=np.bool_)

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; see the contract."""
        self._guard.accept(chunk)
        sensors, ticks = chunk.sensor_count, chunk.tick_count
        gyroscope = np.ascontiguousarray(chunk.gyroscope_radps, dtype=np.float64)
        accelerometer = np.ascontiguousarray(chunk.accelerometer_mps2, dtype=np.float64)
        usable = usable_samples(chunk)
        magnetometer_ut, field_measured = self._field(chunk, gyroscope)
        q = np.empty((sensors, ticks, 4))
        bias = np.empty((sensors, ticks, 3))
        bias_sigma = np.zeros((sensors, ticks))
        rejected = np.zeros((sensors, ticks), dtype=np.bool_)
        whole: NDArray[np.bool_] = np.all(usable, axis=1)
        for s in range(sensors):
            runs = [(0, ticks)] if whole[s] else _runs(usable[s])
            begun = bool(self._started[s])
            held = runs[0][0] if runs else ticks
            q[s, :held], bias[s, :held] = self._q_earth_sensor[s], self._bias_radps[s]
            for start, stop in runs:
                if begun and (start > 0 or self._in_gap[s]):
                    self._restart(s)
                begun = True
                span = slice(start, stop)
                field = None if magnetometer_ut is None else magnetometer_ut[s, span]
                batch = self._filters[s].updateBatch(gyroscope[s, span], accelerometer[s, span], field)
                q[s, span] = batch["quat6D" if field is None else "quat9D"]
                bias[s, span] = batch["bias"]
                bias_sigma[s, span] = batch["biasSigma"]
                if field is not None:
                    rejected[s, span] = batch["magDistDetected"]
                if stop < ticks:
                    q[s, stop:], bias[s, stop:] = q[s, stop - 1], bias[s, stop - 1]
        if ticks:
            self._q_earth_sensor[:], self._bias_radps[:] = q[:, -1], bias[:, -1]
            self._started |= usable.any(axis=1)
            self._in_gap = self._started & ~usable[:, -1]
        flags = np.empty((sensors, ticks), dtype=np.uint8)
        sigma = np.empty((sensors, ticks, 3))
        annotate(
            accelerometer,
            np.ascontiguousarray(chunk.quality),
            usable,
            field_measured,
            rejected,
            bias_sigma,
            self._counters,
            self._guard.time_step_s,
            self._parameters.convergence_s,
            self._parameters.acceleration_tolerance_mps2,
            self._parameters.accelerometer_time_constant_s,
            flags,
            sigma,
        )
        return OrientationResult(q, bias, sigma, flags)

    def _field(self, chunk: ImuChunk, gyroscope: Float) -> tuple[Float | None, NDArray[np.bool_]]:
        """Return the field in the unit of the package, zero (which it skips) where there is none."""
        if chunk.magnetometer_t is None:
            return None, np.zeros(chunk.quality.shape, dtype=np.bool_)
        field = chunk.magnetometer_t * _MICROTESLA_PER_TESLA
        latency = self._parameters.magnetometer_latency_s
        if latency:
            field = field - latency * np.cross(gyroscope, field)
        with np.errstate(over="ignore", invalid="ignore"):
            measured = np.isfinite(field.sum(axis=-1))
        if not measured.all():
            field[~measured] = 0.0
        return np.ascontiguousarray(field), measured

    def _restart(self, s: int) -> None:
        """Forget what a gap made stale, keep what it left valid; see the class."""
        vqf = self._filters[s]
        state = vqf.state
        for name in _STALE_AVERAGES:
            state[name] = [np.nan] * len(state[name])
        state["restT"], state["restDetected"] = 0.0, False
        step_s, parameters = self._guard.time_step_s, self._parameters
        # The package averages its first samples as [NaN, count, sum x, sum y, sum z, NaN]: the held
        # inclination enters as so many samples of gravity in the gyroscope's frame.
        count = parameters.restart_inclination_weight_s / step_s
        up = rotation.rotate(rotation.conjugate(state["accQuat"]), [0.0, 0.0, GRAVITY_MPS2])
        averaging = [np.nan, count, *(count * up).tolist(), np.nan]
        state["accLpState"] = averaging if count > 0.0 else [np.nan] * 6
        if not (state["magDistDetected"] and state["magRefNorm"] > 0.0):
            gain = 1.0 / (1.0 + parameters.restart_heading_weight_s / step_s)
            state["kMagInit"] = max(state["kMagInit"], gain)
        vqf.state = state

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the state of every filter, field by field with the sensors leading, and the counts."""
        each = [vqf.state for vqf in self._filters]
        stored = {
            f"vqf_{name}": np.array([state[name] for state in each], dtype=np.float64) for name in each[0]
        }
        return stored | {
            "next_tick": np.array(self._guard.next_tick, dtype=np.int64),
            **{name: getattr(self, f"_{name}").copy() for name in _OWN_STATE},
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state` of an estimator built alike."""
        for s, vqf in enumerate(self._filters):
            fields = vqf.state
            for name, current in fields.items():
                stored = state.get(f"vqf_{name}")
                if stored is None or stored.shape != (self._guard.sensor_count, *np.shape(current)):
                    raise ShapeError(f"stored vqf_{name} does not fit {self._guard.sensor_count} sensors")
                fields[name] = bool(stored[s]) if isinstance(current, bool) else stored[s].tolist()
            vqf.state = fields
        for name in _OWN_STATE:
            setattr(self, f"_{name}", copied(state, name, getattr(self, f"_{name}")))
        self._guard.next_tick = int(state["next_tick"])

    def set_gyroscope_bias(self, bias_radps: Float, sigma_radps: float) -> None:
        """Take a static calibration, shape (S, 3), with its standard error."""
        bias = bias_array(bias_radps, sigma_radps, self._guard.sensor_count)
        for vqf, one in zip(self._filters, bias, strict=True):
            vqf.setBiasEstimate(one, sigma_radps)

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value."""
        return asdict(self._parameters)


def _runs(usable: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the half-open stretches of usable samples."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], usable, [False])).astype(np.int8)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


__all__ = ["VqfEstimator", "VqfParameters"]
