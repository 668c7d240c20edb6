"""A stored recording of a source that fires bursts of three coils: tracker alone, filter and smoother, off line."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators import orientation, rotation
from estimators.conventions import Placement
from estimators.errors import SetupError, ShapeError
from estimators.magnetic import (
    BurstNoise,
    FollowedBurst,
    ModuleSignals,
    Pulse,
    RelativePoseParameters,
    TrackerFusionChunk,
    TrackerFusionParameters,
    TrackerFusionResult,
    TrackerLimits,
    bursts,
    extract_pulses,
    follow_bursts,
    integrate_gyroscope,
    read_coil_state,
    smooth_tracker_fusion,
)
from estimators.pipelines._contract import SessionSetup
from estimators.pipelines._offline import smooth_network
from estimators.pipelines.relative.source import direction_between, settings_of
from estimators.recording import Float, ImuChunk, SampleQuality
from estimators.sentences import say

BURSTS: Final = "magnetic_bursts"
"""The pipeline's name, for those who choose one."""
BURST_ORIENTATION: Final = "telemotion_smoother"
"""For whoever names none."""
_LONGEST_S: Final = 0.5
"""Three coils that take longer are no burst but pulses that were asked for one by one."""
_BASELINE_S: Final = 0.075
_REACH_S: Final = 0.5
_STILL_S: Final = 2.0
_LEAST_STILL: Final = 20
_AT_SCALE: Final = 0.99
"""What clips at full scale comes a little lower as float32 or as counts."""
_SETTINGS: Final = {field.name for field in fields(TrackerFusionParameters)}
_DEFAULTS: Final[dict[str, Any]] = {"filter_attitude_time_s": 60.0}
"""What a smoother is off wanders more slowly than what a filter is."""
_NOT_MEASURED: Final = int(SampleQuality.MISSING | SampleQuality.BRIDGED)


@dataclass(frozen=True)
class BurstAnalysis:
    """Pose of one sensor against the source over K ticks, three times.

    Attributes
    ----------
    time_s : ndarray, shape (K,)
    bursts : tuple of FollowedBurst
        With the tracker's own fix of each.
    coil_covariance : ndarray, shape (K, 6, 6)
        What the coils' description may be wrong by makes of the pose; on top of the covariances of both results, for
        it lasts. Of the bursts that were used, by line between them.
    """

    source: str
    sensor: str
    time_s: Float
    bursts: tuple[FollowedBurst, ...]
    filtered: TrackerFusionResult
    smoothed: TrackerFusionResult
    coil_covariance: Float


def analyse_bursts(chunk: ImuChunk, setup: SessionSetup) -> tuple[BurstAnalysis, ...]:
    """Find the pose of every sensor against the source from bursts that the source fired by itself.

    Parameters
    ----------
    chunk : ImuChunk
        Of the whole recording, with coil states; magnetometers are needed in all modules. It should begin with two
        seconds of standing still, which give the offsets of the gyroscopes.
    setup : SessionSetup
        `orientation` names the smoother of both modules' orientations, which sees no pulses; its parameters are the
        settings of the source as in the pipeline `relative_pose`, and `TrackerFusionParameters`.

    Returns
    -------
    tuple of BurstAnalysis
        One a sensor.

    Raises
    ------
    SetupError
        For parameters that do not exist, or a recording without coil states, magnetometers or bursts.
    """
    given: Mapping[str, Any] = setup.orientation_parameters
    overrides = _DEFAULTS | {name: value for name, value in given.items() if name in _SETTINGS}
    others = {name: value for name, value in given.items() if name not in _SETTINGS}
    settings, magnetic = settings_of(
        SessionSetup("relative_pose", setup.placements, setup.rate_hz, orientation_parameters=others)
    )
    if chunk.sensor_count != len(setup.placements):
        raise ShapeError(f"{chunk.sensor_count} sensors; the setup has {len(setup.placements)}")
    if chunk.coil_state is None or chunk.magnetometer_t is None:
        raise SetupError(say("setup.bursts_need"))
    if setup.orientation not in orientation.smoothers():
        raise SetupError(
            say("setup.bursts_smoother", known=list(orientation.smoothers()), name=setup.orientation)
        )
    row = setup.placements.index(settings.source)
    coil, current, _ = read_coil_state(np.nan_to_num(chunk.coil_state[row]))
    away = _beside(coil > 0)
    offsets = np.stack([_offset(rate, round(_STILL_S / chunk.time_step_s)) for rate in chunk.gyroscope_radps])
    q_world = _orientations(chunk, setup, away)
    noise = BurstNoise(
        float(magnetic.get("magnetometer_sigma_t", BurstNoise().magnetometer_sigma_t)),
        float(overrides.get("rate_sigma_radps", BurstNoise().rate_sigma_radps)),
    )
    full_scale_t = _AT_SCALE * float(magnetic.get("full_scale_t", RelativePoseParameters().full_scale_t))
    limits = TrackerLimits(gain_sigma=float(magnetic["gain_sigma"]))

    def analysis_of(index: int, name: Placement) -> BurstAnalysis:
        signals = ModuleSignals(
            chunk.time_step_s,
            chunk.gyroscope_radps[index] - offsets[index],
            chunk.accelerometer_mps2[index],
            chunk.gyroscope_radps[row] - offsets[row],
            chunk.accelerometer_mps2[row],
        )
        gathered = _bursts_of(
            chunk, index, name, coil, current, signals, noise.magnetometer_sigma_t, full_scale_t
        )
        way = np.array(direction_between(settings.source, name))
        direction = way if way.any() else None
        to_fill = _without_fixes(signals, q_world[row], q_world[index])
        filled, followed = follow_bursts(
            settings.coils, gathered, signals, to_fill, overrides, direction, noise, limits
        )
        smoothed, filtered = smooth_tracker_fusion(filled, overrides)
        time_s = np.asarray(np.arange(chunk.tick_count) * chunk.time_step_s)
        between = _between(followed, chunk.tick_count)
        return BurstAnalysis(settings.source, name, time_s, tuple(followed), filtered, smoothed, between)

    return tuple(analysis_of(index, name) for index, name in enumerate(setup.placements) if index != row)


def _without_fixes(
    signals: ModuleSignals, q_world_source: Float, q_world_sensor: Float
) -> TrackerFusionChunk:
    """Return what the fusion takes, with room for the fixes of bursts."""
    ticks = len(signals.gyroscope_radps)
    return TrackerFusionChunk(
        0,
        signals.time_step_s,
        signals.gyroscope_radps,
        signals.accelerometer_mps2,
        signals.source_accelerometer_mps2,
        q_world_source,
        q_world_sensor,
        *(np.full((ticks, *shape), np.nan) for shape in ((3,), (4,), (6, 6))),
    )


def _bursts_of(
    chunk: ImuChunk,
    index: int,
    name: Placement,
    coil: NDArray[np.int64],
    current: Float,
    signals: ModuleSignals,
    sigma_t: float,
    full_scale_t: float,
) -> list[list[Pulse]]:
    """Return the bursts that the magnetometer of a module felt.

    Raises
    ------
    SetupError
        If it felt none.
    """
    assert chunk.magnetometer_t is not None
    measured = (chunk.quality[index] & _NOT_MEASURED) == 0
    beside = max(4, round(_BASELINE_S / chunk.time_step_s))
    pulses = extract_pulses(
        np.where(measured[:, None], chunk.magnetometer_t[index], np.nan),
        coil,
        current,
        integrate_gyroscope(np.nan_to_num(signals.gyroscope_radps), chunk.time_step_s),
        before=beside,
        after=max(4, round(_BASELINE_S / chunk.time_step_s) - 1),
        magnetometer_sigma_t=sigma_t,
        full_scale_t=full_scale_t,
        reach=round(_REACH_S / chunk.time_step_s),
    )
    gathered = bursts(pulses, longest=round(_LONGEST_S / chunk.time_step_s))
    if not gathered:
        raise SetupError(say("setup.no_burst", where=[name], longest_s=_LONGEST_S, pulses=len(pulses)))
    return gathered


def _beside(on: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where a coil is on, or a sample away: fields rise and fall within one."""
    wide = on.copy()
    wide[1:] |= on[:-1]
    wide[:-1] |= on[1:]
    return wide


def _offset(rate_radps: Float, most: int) -> Float:
    """Return the mean of a gyroscope while it is still at the beginning, of `most` samples; zero if it is not."""
    limit = TrackerFusionParameters().still_rate_radps
    still = np.linalg.norm(rate_radps[:most], axis=1) < limit
    count = len(still) if still.all() else int(np.argmin(still))
    return np.asarray(rate_radps[:count].mean(axis=0)) if count >= _LEAST_STILL else np.zeros(3)


def _orientations(chunk: ImuChunk, setup: SessionSetup, away: NDArray[np.bool_]) -> Float:
    """Return what an orientation filter that sees no pulses says of every module, shape (S, K, 4).

    Off-line: a filter that first has to find its heading turns the world while it does.
    """
    assert chunk.magnetometer_t is not None
    clean = np.where(away[None, :, None], np.nan, chunk.magnetometer_t)
    quiet = replace(chunk, first_tick=0, magnetometer_t=clean, coil_state=None)
    plain = replace(setup, orientation_parameters={})
    return np.ascontiguousarray(smooth_network([quiet], plain)[0].q_earth_sensor)


def _between(followed: list[FollowedBurst], count: int) -> Float:
    """Return the coils' part of the covariance at every tick, by line between the bursts that were used."""
    known = [(b.tick, b.carried.coil_covariance) for b in followed if b.used and b.carried is not None]
    if not known:
        return np.full((count, 6, 6), np.nan)
    ticks = np.array([tick for tick, _ in known], dtype=np.float64)
    values = np.stack([one.ravel() for _, one in known])
    grid = np.arange(count)
    return np.stack([np.interp(grid, ticks, column) for column in values.T], axis=1).reshape(count, 6, 6)


def angles_with_sigma(q_source_sensor: Float, covariance: Float) -> tuple[Float, Float]:
    """Return the z-y-x angles of a sensor against the source and their sigmas by first order, rad, shape (K, 3).

    `rotation` about z, `flexion` about y, `lateral` about x, as the columns of the pipeline `relative_pose`;
    `covariance` (K, 3, 3) is of the orientation in sensor axes.
    """
    step = 1e-6
    angle = _zyx(q_source_sensor)
    rows = np.empty((*angle.shape, 3))
    for axis in range(3):
        turned = rotation.multiply(q_source_sensor, rotation.exp(step * np.eye(3)[axis]))
        change = _zyx(turned) - angle
        rows[..., axis] = (np.mod(change + np.pi, 2.0 * np.pi) - np.pi) / step
    variance = np.einsum("kai,kij,kaj->ka", rows, covariance, rows)
    return angle, np.sqrt(np.maximum(variance, 0.0))


def _zyx(q: Float) -> Float:
    matrix = rotation.to_matrix(q)
    return np.stack(
        [
            np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0]),
            np.arcsin(np.clip(-matrix[..., 2, 0], -1.0, 1.0)),
            np.arctan2(matrix[..., 2, 1], matrix[..., 2, 2]),
        ],
        axis=-1,
    )
