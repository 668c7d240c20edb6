"""A whole walk off-line: both feet smoothed on their own time stamps, their strides, and frames on common ticks."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimators import calibration, rotation
from estimators.calibration import DeviceCalibration
from estimators.conventions import Side
from estimators.gait import (
    FootParameters,
    FootTrajectory,
    GaitSummary,
    Measure,
    Strides,
    carried_foot,
    find_strides,
    foot_parameters,
    measure_steps,
    rolled_s,
    smooth,
    summarise,
    without_carried,
)
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Frames, SessionSetup
from estimators.pipelines.walk.layout import (
    CONTACT,
    SCALARS,
    SPEED,
    STANCE,
    STRIDE_LENGTH,
    TOE_OFF,
    feet_of,
    layout_of,
)
from estimators.pipelines.walk.pipeline import apart, flags_of, frames_of, level_sigma
from estimators.pipelines.walk.turning_steps import turning_steps
from estimators.recording import Float, ImuChunk, Recording, SensorSignals
from estimators.signals import interpolate_rotations

_LEAST_COURSE_M = 3.0


@dataclass(frozen=True)
class Walk:
    """A whole walk off-line.

    Attributes
    ----------
    frames : Frames
        Both feet on common ticks; segments have x to the toes, room has x along the walk's course.
    trajectories : dict of Side to FootTrajectory
        On the sensors' own stamps, each in its own world.
    steps : dict of str to Measure, or None
        Step width and lengths, where somebody or something tells how far the feet are apart.
    """

    frames: Frames
    trajectories: Mapping[Side, FootTrajectory]
    strides: Mapping[Side, Strides]
    summary: GaitSummary
    steps: Mapping[str, Measure] | None = None


def analyse_walk(
    recording: Recording, setup: SessionSetup, recorded_s: tuple[float, float] | None = None
) -> Walk:
    """Follow the feet of a whole recording on their own time stamps, smoothed, and find their strides.

    Parameters
    ----------
    recording : Recording
        Its metadata may give `gyroscope_clip_radps` and `accelerometer_clip_mps2` of the device, used unless the
        setup says otherwise.
    setup : SessionSetup
        `orientation_parameters` are those of `FootParameters`.
    recorded_s : (float, float), optional
        When Record and Stop were pressed, on the recording's clock. The feet are followed all the way; numbers are of
        strides in between, the others are marked `StrideFlag.OUTSIDE`.

    Raises
    ------
    SetupError, ShapeError
        For placements, parameters or samples that cannot be used.
    """
    feet = feet_of(setup)
    given = dict(setup.orientation_parameters)
    for level in ("gyroscope_clip_radps", "accelerometer_clip_mps2"):
        if level in recording.metadata:
            given.setdefault(level, float(recording.metadata[level]))
    parameters: FootParameters = foot_parameters(given)
    names = {side: setup.placements[i] for side, i in feet.items()}
    devices = setup.devices
    sensors = {side: _corrected(recording.sensors[name], devices.get(name)) for side, name in names.items()}
    paths = {side: smooth(sensor, parameters) for side, sensor in sensors.items()}
    strides = {side: find_strides(path, side) for side, path in paths.items()}
    strides = {side: replace(foot, rolled_s=rolled_s(sensors[side], foot)) for side, foot in strides.items()}
    if recorded_s is not None:
        strides = {side: foot.between(*recorded_s) for side, foot in strides.items()}
    strides = without_carried(strides)
    start_s = min(float(path.time_s[0]) for path in paths.values())
    end_s = max(float(path.time_s[-1]) for path in paths.values())
    ticks = int((end_s - start_s) * setup.rate_hz + 1e-6) + 1
    time_s = start_s + np.arange(ticks) / setup.rate_hz
    feet_on_ticks = (_on_ticks(paths[side], strides[side], side, time_s) for side in feet)
    q, position_m, scalar, flags, attitude_sigma, position_sigma = zip(*feet_on_ticks, strict=True)
    of_devices = calibration.direction_variance([devices.get(names[side]) for side in feet])
    frames = frames_of(
        layout_of(tuple(feet)),
        round(start_s * setup.rate_hz),
        1.0 / setup.rate_hz,
        np.stack(q, axis=1),
        np.stack(position_m, axis=1),
        np.concatenate(scalar, axis=1),
        np.stack(flags, axis=1),
        np.sqrt(np.stack(attitude_sigma, axis=1) ** 2 + of_devices),
        np.stack(position_sigma, axis=1),
    )
    summary = summarise(strides)
    return Walk(frames, paths, strides, summary, _steps(strides, summary, setup.feet_apart_m))


def _corrected(sensor: SensorSignals, device: DeviceCalibration | None) -> SensorSignals:
    """Return the readings of one sensor after its device's calibration."""
    if device is None:
        return sensor
    samples = len(sensor.time_s)
    field = None if sensor.magnetometer_t is None else sensor.magnetometer_t[None]
    chunk = ImuChunk(
        0,
        1.0,
        sensor.gyroscope_radps[None],
        sensor.accelerometer_mps2[None],
        field,
        np.zeros((1, samples), dtype=np.uint8),
    )
    found = calibration.correct(chunk, [device])
    return replace(
        sensor,
        gyroscope_radps=found.gyroscope_radps[0],
        accelerometer_mps2=found.accelerometer_mps2[0],
        magnetometer_t=None if found.magnetometer_t is None else found.magnetometer_t[0],
    )


def _steps(
    strides: Mapping[Side, Strides], summary: GaitSummary, apart_m: float | None
) -> Mapping[str, Measure] | None:
    """Return steps between the feet: their worlds can be related from a known distance at the start."""
    if apart_m is None or set(strides) != {"left", "right"}:
        return None
    if carried_foot(strides) is not None:
        return None
    known_s = min(foot.whole_until_s for foot in strides.values())
    left, right = strides["left"].footholds.before(known_s), strides["right"].footholds.before(known_s)
    if min(len(left.start_s), len(right.start_s)) < 2:
        return None
    if summary.turn_count:
        return turning_steps(strides, {"left": left, "right": right}, apart_m)
    ways = [np.linalg.norm(holds.position_m[-1] - holds.position_m[0]) for holds in (left, right)]
    if min(ways) < _LEAST_COURSE_M:
        return None
    beside = np.array([0.0, -apart_m])
    return measure_steps(
        left.position_m, left.quietest_s, right.position_m, right.quietest_s, beside, strides
    )


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
) -> tuple[Float, Float, Float, NDArray[np.uint8], Float, Float]:
    """Return orientation, position, scalars, flags and both sigmas of one foot on common ticks."""
    turn = rotation.exp([0.0, 0.0, -course_of(strides)])
    q = rotation.multiply(turn, interpolate_rotations(path.time_s, path.q_world_sensor, time_s))
    q = rotation.multiply(q, strides.q_sensor_foot)
    position, velocity = (
        np.stack([np.interp(time_s, path.time_s, rotated[:, i]) for i in range(3)], axis=1)
        for rotated in (rotation.rotate(turn, path.position_m - path.position_m[0]), path.velocity_mps)
    )
    nearest = np.clip(np.searchsorted(path.time_s, time_s), 0, len(path.time_s) - 1)
    flags = flags_of(path.flags[nearest])
    outside = (time_s < path.time_s[0]) | (time_s > path.time_s[-1])
    flags[outside] |= np.uint8(OrientationFlag.INVALID)
    scalar = np.full((len(time_s), len(SCALARS)), np.nan)
    scalar[:, STANCE] = path.stance.is_stance[nearest]
    scalar[:, SPEED] = np.linalg.norm(velocity, axis=1)
    sigmas = [level_sigma(sigma)[nearest] for sigma in (path.attitude_sigma_rad, path.position_sigma_m)]
    for sigma in sigmas:
        sigma[outside] = np.nan
    return q, apart(position, side), event_columns(scalar, strides, time_s), flags, sigmas[0], sigmas[1]


def event_columns(scalar: Float, strides: Strides, time_s: Float) -> Float:
    """Return the `SCALARS` of one foot, shape (K, 8), with contacts, toe-offs and the measures of these strides.

    Parameters
    ----------
    scalar : ndarray, shape (K, 8)
        Stance and speed are unchanged.
    time_s : ndarray, shape (K,)
        Of the ticks.
    """
    found = scalar.copy()
    found[:, [CONTACT, TOE_OFF]], found[:, STRIDE_LENGTH:] = 0.0, np.nan
    for column, events in ((CONTACT, strides.contact_s), (TOE_OFF, strides.toe_off_s)):
        found[np.minimum(np.searchsorted(time_s, events), len(time_s) - 1), column] = 1.0
    last = np.searchsorted(strides.contact_s, time_s, side="right") - 1
    known = last >= 0
    measures = (strides.length_m, strides.duration_s, strides.clearance_m, strides.toe_out_rad)
    for column, values in enumerate(measures, STRIDE_LENGTH):
        found[known, column] = values[last[known]]
    return found
