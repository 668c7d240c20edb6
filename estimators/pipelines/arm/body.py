"""Shared parts of every pipeline over a body network: orientation, calibration, segments in the room."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import calibration, orientation, rotation
from estimators.conventions import GRAVITY_MPS2, Placement
from estimators.errors import CalibrationError, SetupError, ShapeError
from estimators.orientation import OrientationFlag, OrientationResult
from estimators.pipelines._biases import bias_along_gravity, bias_sigma
from estimators.pipelines._contract import Calibration, SessionSetup, calibration_from_dict
from estimators.pipelines.arm.kernel import Worn, compose
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

LYING_BIAS_SIGMA_RADPS = float(np.deg2rad(0.05))
STANDING_BIAS_SIGMA_RADPS = float(np.deg2rad(0.2))
"""Trust in a bias found earlier: by sensors that lay still, or on a person, who sways by half a degree
within the seconds of a pose; both with what gyroscopes change between switch-ons."""
_LEVEL_LIMIT_MPS2 = 0.1 * GRAVITY_MPS2
"""Six degrees of tilt: more is not lying level."""
POSE_ALONE_SCORE = 0.9
"""Full marks need movements that turn the sensors as the body's joints can turn."""
_MEMORY_S = 8.0
_MEMORY_HZ = 5.0
"""Orientation remembered for a calibration pose: a still pose needs no more."""
_NO_VARIANCE = np.empty((0, 3))
_UNCALIBRATED = np.uint8(OrientationFlag.CONVERGING | OrientationFlag.HEADING_NOT_TRUSTED)
_CONTRADICTED = np.uint8(_UNCALIBRATED | OrientationFlag.INVALID)
_CONTRADICTED_RAD = np.pi / np.sqrt(3.0)
"""Sigma of a direction of which nothing is known."""


def _text(calibration: Calibration | None) -> NDArray[np.uint8]:
    """Return a calibration as bytes of JSON."""
    text = json.dumps(None if calibration is None else asdict(calibration))
    return np.frombuffer(text.encode(), dtype=np.uint8)


class BodyNetwork:
    """Runs the orientation filter of a network and turns its result into segments.

    Parameters
    ----------
    setup : SessionSetup
        Checked here: at least one placement, none twice, a rate that sensors have.

    Raises
    ------
    SetupError
        With what to change.
    """

    def __init__(self, setup: SessionSetup) -> None:
        _check(setup)
        self.setup = setup
        self.sensor_count = len(setup.placements)
        self.time_step_s = 1.0 / setup.rate_hz
        self._accelerometer_bias = _force_bias(setup.calibration, setup.placements)
        self._filter = self.new_filter(self._accelerometer_bias)
        self._next_tick = 0
        self._stride = max(1, round(setup.rate_hz / _MEMORY_HZ))
        slots = int(_MEMORY_S * _MEMORY_HZ)
        self._memory_tick = np.full(slots, -1, dtype=np.int64)
        self._memory_q = np.full((slots, self.sensor_count, 4), np.nan)
        self._memory_flags = np.zeros((slots, self.sensor_count), dtype=np.uint8)
        self._written: tuple[Calibration | None, NDArray[np.uint8]] = (None, _text(None))
        self._apply(setup.calibration)
        if setup.calibration is not None:
            lay = setup.calibration.method.startswith(("level", "static", "bias"))
            self._set_bias(setup.calibration, LYING_BIAS_SIGMA_RADPS if lay else STANDING_BIAS_SIGMA_RADPS)

    @property
    def is_calibrated(self) -> bool:
        """Whether segment orientations mean anything yet; not when only biases are known."""
        return self.setup.calibration is not None and bool(self.setup.calibration.q_sensor_segment)

    @property
    def force_bias_mps2(self) -> Float:
        """What the calibration in force takes off the specific force of each sensor, shape (S, 3)."""
        return self._accelerometer_bias.copy()

    @property
    def next_tick(self) -> int:
        """Number of the first tick not seen yet."""
        return self._next_tick

    def new_filter(self, force_bias_mps2: Float) -> orientation.OrientationEstimator:
        """Return a filter of this network that has seen nothing yet.

        It will be given readings from which a bias of the accelerometers, shape (S, 3), is taken off.
        """
        setup = self.setup
        made = orientation.create(
            setup.orientation, self.sensor_count, self.time_step_s, setup.orientation_parameters
        )
        if setup.device_constants:
            known = map(setup.device_constants.get, setup.placements)
            made.set_device_constants(
                [one and one.less_offset(bias) for one, bias in zip(known, force_bias_mps2, strict=True)]
            )
        return made

    @property
    def device_constants(self) -> dict[Placement, orientation.DeviceConstants]:
        """What the filter knows of each sensor by now."""
        told = zip(
            self.setup.placements, self._filter.device_constants, self._accelerometer_bias, strict=False
        )
        return {name: one.less_offset(-bias) for name, one, bias in told}

    def step(self, chunk: ImuChunk) -> tuple[OrientationResult, Float, Float, Float, NDArray[np.uint8]]:
        """Take the next ticks.

        Returns
        -------
        result : OrientationResult
            As the filter gave it.
        q_room_segment : ndarray, shape (K, S, 4)
        omega_room_radps, sigma_room_rad : ndarray, shape (K, S, 3)
            Turning rate of each segment in room axes, and one-sigma of its orientation (NaN where unknown).
        flags : ndarray of uint8, shape (K, S)
        """
        chunk = self.corrected(chunk)
        first, ticks, sensors = chunk.first_tick, chunk.tick_count, self.sensor_count
        if self._has_accelerometer_bias:
            force = chunk.accelerometer_mps2 - self._accelerometer_bias[:, None]
            if type(chunk) is ImuChunk:
                # Not `replace`, which costs as much as the subtraction; a live chunk holds nothing else.
                gyroscope, field = chunk.gyroscope_radps, chunk.magnetometer_t
                chunk = ImuChunk(first, chunk.time_step_s, gyroscope, force, field, chunk.quality)
            else:
                chunk = replace(chunk, accelerometer_mps2=force)
        result = self._filter.update(chunk)
        q_room_segment, omega = np.empty((ticks, sensors, 4)), np.empty((ticks, sensors, 3))
        sigma, flags = np.empty((ticks, sensors, 3)), np.empty((ticks, sensors), dtype=np.uint8)
        known = result.sigma_rad
        if known is not None and self.setup.devices:
            of_devices = [self.setup.devices.get(name) for name in self.setup.placements]
            known = np.sqrt(known**2 + calibration.direction_variance(of_devices)[:, None])
        compose(
            result.q_earth_sensor,
            np.full((sensors, ticks, 3), np.nan) if known is None else known,
            np.ascontiguousarray(chunk.gyroscope_radps, dtype=np.float64),
            result.gyroscope_bias_radps,
            result.flags,
            Worn(self._q_room_earth, self._q_sensor_segment, self._mounting_variance, self._more_flags),
            q_room_segment,
            omega,
            sigma,
            flags,
        )
        self._remember(first, ticks, result)
        self._next_tick = first + ticks
        return result, q_room_segment, omega, sigma, flags

    def in_segments(self, chunk: ImuChunk) -> tuple[Float, Float]:
        """Return what gyroscopes (rad/s) and accelerometers (m/s^2) read in segment axes, shape (S, K, 3) each.

        Corrected for what was calibrated; of the gyroscopes' bias for what was calibrated in the hand alone.

        Parameters
        ----------
        chunk : ImuChunk
            As measured.
        """
        chunk = self.corrected(chunk)
        back = rotation.conjugate(self._q_sensor_segment)[:, None]
        force = chunk.accelerometer_mps2 - self._accelerometer_bias[:, None]
        return rotation.rotate(back, chunk.gyroscope_radps), rotation.rotate(back, force)

    def corrected(self, chunk: ImuChunk) -> ImuChunk:
        """Apply what was calibrated in the hand."""
        if not self.setup.devices:
            return chunk
        return calibration.correct(chunk, [self.setup.devices.get(name) for name in self.setup.placements])

    def calibrate(self, pose: ImuChunk, method: str) -> Calibration:
        """Find the calibration from a pose among the ticks already seen; it holds from the next step.

        Parameters
        ----------
        pose : ImuChunk
            As measured; biases known so far are subtracted here.
        method : str
            `n_pose`: standing with hanging arms; finds mounting, facing and gyroscope bias.
            `level`: every sensor lies level, z up; finds both biases (Marzouk 2009, 3.1.1, A2). Mountings
            already known are retained. A later `n_pose` keeps the accelerometer bias found.
            `t_pose`: as `n_pose`, with the arms out to the sides; needs compasses.
            `static`: every sensor lies still in any position, for single sensors; finds the gyroscope bias.
            `bias`: the same for sensors of a body: mountings already known are retained.

        Raises
        ------
        CalibrationError
            With what to redo.
        SetupError
            For another method.
        """
        if pose.sensor_count != self.sensor_count:
            raise ShapeError(
                f"the pose has {pose.sensor_count} sensors; this session has {self.sensor_count}"
            )
        pose = self.corrected(pose)
        if method == "level":
            found = self._level(pose)
        elif method in ("n_pose", "t_pose"):
            found = self._held_pose(pose, method)
        elif method in ("static", "bias"):
            found = self._rest(pose, keep=method == "bias")
        else:
            raise SetupError(
                f"no calibration method {method!r}; known are n_pose, t_pose, level, static and bias"
            )
        self.setup = replace(self.setup, calibration=found)
        return found

    def _level(self, pose: ImuChunk) -> Calibration:
        rest = calibration.static_bias(
            pose.gyroscope_radps,
            pose.accelerometer_mps2,
            pose.time_step_s,
            q_earth_sensor=rotation.identity((self.sensor_count,)),
        )
        accelerometer_bias = rest.accelerometer_bias_mps2
        if accelerometer_bias is None or np.abs(accelerometer_bias).max() > _LEVEL_LIMIT_MPS2:
            raise CalibrationError(say("calibration.not_level"))
        known = self.setup.calibration or Calibration({}, {}, method="level")
        found = replace(
            known,
            gyroscope_bias_radps=self._by_placement(rest.gyroscope_bias_radps),
            accelerometer_bias_mps2=self._by_placement(accelerometer_bias),
        )
        self._apply(found)
        self._set_bias(found, bias_sigma(rest))
        return found

    def _rest(self, pose: ImuChunk, *, keep: bool) -> Calibration:
        rest = calibration.static_bias(
            pose.gyroscope_radps,
            pose.accelerometer_mps2,
            pose.time_step_s,
            names=self.setup.placements,
        )
        identity = dict.fromkeys(self.setup.placements, (1.0, 0.0, 0.0, 0.0))
        known = Calibration({} if keep else identity, {}, method="bias" if keep else "static")
        if keep and self.setup.calibration is not None:
            known = self.setup.calibration
        called = [name for name, odd in zip(self.setup.placements, rest.unusual, strict=True) if odd]
        if called:
            stated = calibration.unusual_bias(called)
            score = min(known.score, calibration.UNUSUAL_BIAS_SCORE)
            known = replace(known, score=score, reasons=(*known.reasons, stated))
        found = replace(known, gyroscope_bias_radps=self._by_placement(rest.gyroscope_bias_radps))
        self._apply(found)
        self._set_bias(found, bias_sigma(rest))
        return found

    def _held_pose(self, pose: ImuChunk, method: str) -> Calibration:
        was_level = self.setup.calibration is not None and "level" in self.setup.calibration.method
        bias = self._accelerometer_bias if was_level else bias_along_gravity(pose.accelerometer_mps2)
        worn, pose = pose, replace(pose, accelerometer_mps2=pose.accelerometer_mps2 - bias[:, None])
        if was_level and self.setup.calibration is not None:
            # Found lying, without the sway of a standing person.
            known = self.setup.calibration.gyroscope_bias_radps
            gyroscope_bias = np.array([known[name] for name in self.setup.placements])
            sigma_radps = LYING_BIAS_SIGMA_RADPS
        else:
            rest = calibration.static_bias(
                pose.gyroscope_radps, pose.accelerometer_mps2, pose.time_step_s, require_still=False
            )
            gyroscope_bias, sigma_radps = rest.gyroscope_bias_radps, bias_sigma(rest)
        anew = self.begin_anew(worn, gyroscope_bias, sigma_radps, bias)
        q_earth_sensor, flags = self.during(pose, anew)
        found = calibration.n_pose(
            q_earth_sensor,
            pose.gyroscope_radps,
            pose.accelerometer_mps2,
            self.setup.placements,
            flags,
            time_step_s=pose.time_step_s,
            arms="sideways" if method == "t_pose" else "hanging",
            sigma_rad=None if anew is None else anew[1].sigma_rad,
        )
        found = replace(
            found,
            gyroscope_bias_radps=self._by_placement(gyroscope_bias),
            accelerometer_bias_mps2=self._by_placement(bias),
            method=f"level, {method}" if was_level else method,
            # How still somebody stood does not tell whether the pose was the one asked for.
            score=min(found.score, POSE_ALONE_SCORE),
            reasons=(*found.reasons, say("calibration.not_checked")),
        )
        self._apply(found)
        if anew is None:
            self._set_bias(found, sigma_radps)
        else:
            self._filter = anew[0]
        return found

    def adopt(self, found: Calibration, with_filter: orientation.OrientationEstimator | None) -> None:
        """Take over a calibration found elsewhere, with the filter it was found with, from the next step on."""
        self.setup = replace(self.setup, calibration=found)
        self._apply(found)
        if with_filter is not None:
            self._filter = with_filter

    def set_devices(self, devices: Mapping[Placement, calibration.DeviceCalibration]) -> None:
        """Take device calibrations; what was learnt with the readings before is forgotten."""
        together = {**self.setup.devices, **devices}
        constants = {name: k for name, k in self.setup.device_constants.items() if name not in devices}
        self.setup = replace(self.setup, devices=together, device_constants=constants, calibration=None)
        self._apply(None)
        self._filter = self.new_filter(self._accelerometer_bias)

    def _by_placement(self, vectors: Float) -> dict[Placement, tuple[float, float, float]]:
        return {
            name: (float(x), float(y), float(z))
            for name, (x, y, z) in zip(self.setup.placements, vectors, strict=True)
        }

    def begin_anew(
        self, pose: ImuChunk, bias_radps: Float, sigma_radps: float, force_bias_mps2: Float
    ) -> tuple[orientation.OrientationEstimator, OrientationResult] | None:
        """Run a fresh filter over the pose with the biases known; None if ticks have followed the pose.

        Until now the filter did not know the bias: 1 deg/s holds its heading about 7 degrees off, which would
        go into the mounting and fade only over half a minute afterwards.
        """
        if pose.first_tick + pose.tick_count != self._next_tick:
            return None
        fresh = self.new_filter(force_bias_mps2)
        fresh.set_gyroscope_bias(bias_radps, sigma_radps)
        return fresh, fresh.update(
            replace(pose, accelerometer_mps2=pose.accelerometer_mps2 - force_bias_mps2[:, None])
        )

    def during(
        self, pose: ImuChunk, anew: tuple[orientation.OrientationEstimator, OrientationResult] | None
    ) -> tuple[Float, NDArray[np.uint8]]:
        """Return orientations (S, M, 4) and flags (S, M) of the pose, at the remembered ticks.

        Of a filter that began with the pose the second half counts; the flags are those of the running one,
        which has seen more.
        """
        first, stop = pose.first_tick, pose.first_tick + pose.tick_count
        if anew is not None:
            first += pose.tick_count // 2
        inside = np.flatnonzero((self._memory_tick >= first) & (self._memory_tick < stop))
        if not len(inside):
            raise CalibrationError(say("calibration.forgotten", memory_s=_MEMORY_S))
        inside = inside[np.argsort(self._memory_tick[inside])]
        flags = np.ascontiguousarray(self._memory_flags[inside].T)
        if anew is not None:
            seen = anew[1].q_earth_sensor[:, self._memory_tick[inside] - pose.first_tick]
            return np.ascontiguousarray(seen), flags
        return np.ascontiguousarray(self._memory_q[inside].swapaxes(0, 1)), flags

    def _remember(self, first_tick: int, ticks: int, result: OrientationResult) -> None:
        """Keep the orientation at every n-th tick, counted since the start so that chunks do not matter."""
        start = -first_tick % self._stride
        for k in range(start, ticks, self._stride):
            slot = ((first_tick + k) // self._stride) % len(self._memory_tick)
            self._memory_tick[slot] = first_tick + k
            self._memory_q[slot] = result.q_earth_sensor[:, k]
            self._memory_flags[slot] = result.flags[:, k]

    def _apply(self, found: Calibration | None) -> None:
        """Take over a calibration: rotations per sensor, ready for the kernel."""
        self._q_room_earth, self._q_sensor_segment = rotation.identity((2, self.sensor_count))
        self._mounting_variance = np.zeros((self.sensor_count, 3))
        bias = _force_bias(found, self.setup.placements)
        if (bias != self._accelerometer_bias).any():
            self._filter.take_off_force(bias - self._accelerometer_bias)
        self._accelerometer_bias = bias
        self._has_accelerometer_bias = bool(self._accelerometer_bias.any())
        unknown = [found is not None and name in found.unknown_headings for name in self.setup.placements]
        self._more_flags = np.where(unknown, np.uint8(OrientationFlag.HEADING_NOT_TRUSTED), np.uint8(0))
        if found is None or not found.q_sensor_segment:
            self._mounting_variance, self._more_flags[:] = _NO_VARIANCE, _UNCALIBRATED
            return
        for s, name in enumerate(self.setup.placements):
            if name not in found.q_sensor_segment:
                raise SetupError(say("calibration.other_sensors", where=[name]))
            turn_rad = found.heading_offset_rad.get(name, 0.0) - found.facing_rad
            self._q_room_earth[s] = rotation.about_z(turn_rad)
            self._q_sensor_segment[s] = rotation.normalize(found.q_sensor_segment[name])
            self._mounting_variance[s] = np.square(found.mounting_sigma_rad.get(name, (0.0, 0.0, 0.0)))
            if name in found.contradicted:
                self._mounting_variance[s], self._more_flags[s] = _CONTRADICTED_RAD**2, _CONTRADICTED
        if not self._mounting_variance.any():
            self._mounting_variance = _NO_VARIANCE

    def _set_bias(self, found: Calibration, sigma_radps: float) -> None:
        if all(name in found.gyroscope_bias_radps for name in self.setup.placements):
            bias = np.array([found.gyroscope_bias_radps[name] for name in self.setup.placements])
            self._filter.set_gyroscope_bias(bias, sigma_radps)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the filter's state, the calibration in force and the short memory for a pose."""
        found = self.setup.calibration
        if found is not self._written[0]:
            # The state of a live session is asked for again and again; its calibration hardly ever changes.
            self._written = (found, _text(found))
        state = {f"orientation.{name}": values for name, values in self._filter.state().items()}
        state["calibration"] = self._written[1].copy()
        state["next_tick"] = np.array(self._next_tick, dtype=np.int64)
        state["memory_tick"] = self._memory_tick.copy()
        state["memory_q"] = self._memory_q.copy()
        state["memory_flags"] = self._memory_flags.copy()
        return state

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue where the instance that gave `state` stood, its calibration included."""
        missing = {"calibration", "next_tick", "memory_tick", "memory_q", "memory_flags"} - set(state)
        if missing:
            raise ShapeError(f"this state has no {', '.join(sorted(missing))}; it is of another pipeline")
        if state["memory_q"].shape != self._memory_q.shape:
            raise ShapeError(
                f"this state is of {state['memory_q'].shape[1]} sensors; the session has {self.sensor_count}"
            )
        stored = json.loads(state["calibration"].tobytes())
        found = None if stored is None else calibration_from_dict(stored)
        self.setup = replace(self.setup, calibration=found)
        self._apply(self.setup.calibration)
        prefix = "orientation."  # after the calibration, which tells the filter what is taken off
        self._filter.restore({k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)})
        self._next_tick = int(state["next_tick"])
        self._memory_tick = state["memory_tick"].astype(np.int64)
        self._memory_q = state["memory_q"].astype(np.float64)
        self._memory_flags = state["memory_flags"].astype(np.uint8)


def _force_bias(found: Calibration | None, placements: Sequence[Placement]) -> Float:
    """Return what a calibration takes off the specific force of each sensor, shape (S, 3)."""
    biases: Mapping[Placement, tuple[float, float, float]] = (
        {} if found is None else found.accelerometer_bias_mps2
    )
    return np.array([biases.get(name, (0.0, 0.0, 0.0)) for name in placements])


def _check(setup: SessionSetup) -> None:
    if not setup.placements:
        raise SetupError(say("setup.no_placements"))
    if len(set(setup.placements)) != len(setup.placements):
        raise SetupError(say("setup.placement_twice", places=list(setup.placements)))
    if not 10 <= setup.rate_hz <= 1000:
        raise SetupError(say("setup.rate", rate_hz=setup.rate_hz))
