"""Whether our filter and smoother are as sure as they may be: average NEES against its chi-square band."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import chi2

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk
from estimators.signals import to_common_ticks
from estimators.simulation import EXERCISES, ArmScenario, Magnet, simulate_arm
from validation.protocol import Data, Figure, Protocol, Values

_METHODS = {"our filter": "telemotion", "our smoother": "telemotion_smoother"}
_STEP_S = 0.01
_STATED, _QUIET = "errors as stated", "errors as stated, a tenth of the noise"
_MAGNET = "nominal sensors, magnet in passing"
_JUDGED = (_STATED, "nominal sensors", _MAGNET)
_SENSORS = {
    "nominal sensors": "nominal",
    _MAGNET: "nominal",
    "sensors of the thesis, calibrated": "marzouk_2009_calibrated",
    "sensors of the thesis as bought": "marzouk_2009",
}
_AXES = 3
_SETTLED_S, _APART_S = 10.0, 5.0
"""What is scored: a sample every five seconds, once each method has met rest and movement."""
_REGION = float(chi2.ppf(0.95, _AXES))
_LEAST, _MOST, _SHARE = 1.5, 4.5, 90.0
"""Of the average NEES: sigma is too large by two fifths, too small by a fifth; percent inside the region."""
_NOISE_SD = np.array([0.01, 0.2, 1.0])
"""White noise of a sample: rad/s, m/s^2, microtesla."""
_EARTH_FIELD_UT = np.array([0.0, 18.0, -45.0])
_GAIN_SD, _BIAS_SD_DEGPS, _DELAY_SD_S = 0.005, 1.0, 0.02
_OFFSET_SD_MPS2, _GRAVITY_SD_MPS2 = 0.2, 0.1


def _stated_parameters(noise_sd: Float) -> dict[str, Any]:
    """Return the parameters that state the noise of `_stated_scene`, and no error that no sensor shows."""
    rate_noise, speed_noise, field_noise_ut = (float(sd) for sd in noise_sd * np.sqrt(_STEP_S))
    rate_noise_deg = float(np.degrees(rate_noise))
    return {
        "tilt_sigma_scale": 1.0,
        "heading_sigma_scale": 1.0,
        "tilt_sigma_floor_deg": 1e-4,
        "tilt_sigma_per_offset": 0.0,
        "heading_sigma_floor_deg": 1e-4,
        "field_noise_moving_ut_sqrt_s": field_noise_ut,
        "field_noise_rest_ut_sqrt_s": field_noise_ut,
        "field_noise_start_ut_sqrt_s": field_noise_ut,
        "quiet_least": 1.0,
        "start_narrow_ut": 0.001,
        "region_ut": 0.001,
        "region_share": 0.0,
        "wander_share": 0.0,
        "gain_sigma": _GAIN_SD,
        "gain_narrow": _GAIN_SD,
        "force_offset_sigma_mps2": _OFFSET_SD_MPS2,
        "gravity_sigma_mps2": _GRAVITY_SD_MPS2,
        "bias_start_sigma_degps": _BIAS_SD_DEGPS,
        "delay_sigma_s": _DELAY_SD_S,
        "rate_noise_deg_per_sqrt_s": rate_noise_deg,
        "rate_noise_per_rate_sqrt_s": 0.0,
        "rest_bias_sigma_degps_sqrt_s": rate_noise_deg,
        "rest_sway_s": 0.0,
        "bias_drift_degps_per_sqrt_s": 1e-5,
        "speed_noise_mps_per_sqrt_s": speed_noise,
        "position_noise_m_per_sqrt_s": 1e-6,
        "position_prior_m_sqrt_s": 5e-4,
    }


def _stated_scene(seeds: Sequence[int], noise_sd: Float) -> tuple[ImuChunk, Float]:
    """One sensor a seed that turns at one place, its errors drawn as `_stated_parameters` says: 30 s, 2 at rest."""
    ticks = round(30.0 / _STEP_S)
    time_s = _STEP_S * np.arange(ticks)
    parts = []
    for seed in seeds:
        generator = np.random.default_rng([seed, 27])
        phase = generator.uniform(0.0, 2.0 * np.pi, 3)
        size = np.where(time_s[:, None] > 2.0, [1.5, 2.0, 1.2], 0.0)
        rate = size * np.sin(2.0 * np.pi * np.array([0.31, 0.43, 0.23]) * time_s[:, None] + phase)
        steps = rotation.exp(_STEP_S * rate)
        q = np.empty((ticks, 4))
        q[0] = rotation.normalize(generator.normal(size=4))
        for k in range(1, ticks):
            q[k] = rotation.normalize(rotation.multiply(q[k - 1], steps[k]))
        gain = _GAIN_SD * generator.normal(size=(_AXES, _AXES))
        bias = np.radians(_BIAS_SD_DEGPS) * generator.normal(size=_AXES)
        iron = 0.3 * generator.normal(size=_AXES)
        offset = _OFFSET_SD_MPS2 * generator.normal(size=_AXES)
        gravity = GRAVITY_MPS2 + _GRAVITY_SD_MPS2 * generator.normal()
        # A sample is the mean over its interval: force as it was half a step earlier; the field comes late.
        half = rotation.multiply(q, rotation.exp(-0.5 * _STEP_S * rate))
        late = rotation.multiply(q, rotation.exp(-_DELAY_SD_S * generator.normal() * rate))
        force = rotation.rotate(rotation.conjugate(half), np.array([0.0, 0.0, gravity])) + offset
        field = rotation.rotate(rotation.conjugate(late), _EARTH_FIELD_UT) + iron
        noise = noise_sd[:, None, None] * generator.normal(size=(_AXES, ticks, _AXES))
        parts.append(
            (
                np.linalg.solve(np.eye(_AXES) + gain, (rate + bias).T).T + noise[0],
                force + noise[1],
                1e-6 * (field + noise[2]),
                q,
            )
        )
    gyroscope, accelerometer, magnetometer, truth = (np.stack(part) for part in zip(*parts, strict=True))
    quality = np.zeros((len(seeds), ticks), dtype=np.uint8)
    return ImuChunk(0, _STEP_S, gyroscope, accelerometer, magnetometer, quality), truth


def _arm_scene(seed: int, place: str) -> tuple[ImuChunk, Float]:
    """Seven sensors of an arm session; with the magnet, a strong one passes the table between 12 and 20 s."""
    magnets: tuple[Magnet, ...] = ()
    if place == _MAGNET:
        magnets = (Magnet((0.0, 0.0, 3.0), (0.45, 0.0, 1.0), arrive_s=12.0, leave_s=20.0),)
    exercises = sorted(EXERCISES)
    made = simulate_arm(
        ArmScenario(
            exercise=exercises[seed % len(exercises)],
            errors=_SENSORS[place],
            magnets=magnets,
            seed=seed,
        )
    )
    chunk = to_common_ticks(made.recording, 1.0 / _STEP_S)
    ticks = min(chunk.tick_count, made.truth.q_earth_sensor.shape[1])
    return chunk.ticks(0, ticks), made.truth.q_earth_sensor[:, :ticks]


def _squares(name: str, chunk: ImuChunk, truth: Float, parameters: dict[str, Any]) -> Float:
    """Return the squared error over its reported variance, summed over the axes, of the scored samples."""
    if name in orientation.smoothers():
        found = orientation.smooth(name, chunk, parameters).orientation
    else:
        found = orientation.create(name, chunk.sensor_count, chunk.time_step_s, parameters).update(chunk)
    if found.sigma_rad is None:
        return np.full((chunk.sensor_count, 1), np.nan)
    scored = slice(round(_SETTLED_S / _STEP_S), None, round(_APART_S / _STEP_S))
    q, sigma = found.q_earth_sensor[:, scored], found.sigma_rad[:, scored]
    error = rotation.log(rotation.multiply(q, rotation.conjugate(truth[:, scored])))
    return np.asarray(((error / sigma) ** 2).sum(axis=-1))


def _covariance(seeds: Sequence[int], data: Data) -> Values:
    values: Values = {}
    stated = {_STATED: _NOISE_SD, _QUIET: 0.1 * _NOISE_SD}
    turning = {place: _stated_scene(seeds, noise_sd) for place, noise_sd in stated.items()}
    scenes = {place: [_arm_scene(seed, place) for seed in seeds] for place in _SENSORS}
    for title, name in _METHODS.items():
        found = {
            place: list(_squares(name, *scene, _stated_parameters(stated[place])))
            for place, scene in turning.items()
        } | {place: [_squares(name, *scene, {}) for scene in made] for place, made in scenes.items()}
        for place, runs in found.items():
            each = np.array([run.mean() for run in runs])
            key = f"{place}, {title}"
            values[f"{key}, NEES of a run"] = each
            if place in _JUDGED:
                values[f"{key}, NEES of a run, at least"] = each
            inside = np.mean([np.mean(run < _REGION) for run in runs])
            values[f"{key}, inside the 95 % region"] = np.array([100.0 * inside])
    return values


def _figures() -> tuple[Figure, ...]:
    figures = []
    for place in (_STATED, _QUIET, *_SENSORS):
        for title in _METHODS:
            key = f"{place}, {title}"
            most, share = (_MOST, _SHARE) if place in _JUDGED else (None, None)
            nees = Figure(f"{key}, NEES of a run", "1", most, float(_AXES), judged_by="mean")
            figures.append(nees)
            if place in _JUDGED:
                figures.append(replace(nees, name=f"{nees.name}, at least", required=_LEAST, at_most=False))
            figures.append(Figure(f"{key}, inside the 95 % region", "%", share, at_most=False))
    return tuple(figures)


COVARIANCE = Protocol(
    name="orientation_covariance",
    title="Errors of our filter and smoother against what they state",
    source="Bar-Shalom et al. 2001, 5.4.2 (average NEES); scenes ours",
    what="Squared error over reported variance, three axes, every 5 s from 10 s on, averaged over samples and "
    "sensors of a run, then over the runs; 3 when honest. Errors of a run last as long as it does, so a run counts "
    "as one draw. First a sensor whose noise and constants are drawn as "
    "stated to the methods, without floors; then arm sessions with default parameters, in a clean field and with "
    "a magnet passing. Shown, not judged, is what the stated sigma does not promise. A tenth of the noise: what a "
    "filter takes as linear in its first seconds then counts, and only the smoother goes over them again. The "
    "sensors of the thesis: calibrated, they have nothing beside noise, while floors stand for the offsets and axis "
    "errors of common devices; as bought, their accelerometers lean by a degree, three times the floor.",
    figures=_figures(),
    measure=_covariance,
)
