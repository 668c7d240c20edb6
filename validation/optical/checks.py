"""The page on chapter 4 of Roetenberg with its own sensor noise, every update ratio, and the truth that it asks for."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.optical.published import (
    OpticalChunk,
    OpticalInertialFilter,
    OpticalStart,
    fill_by_spline,
    filter_and_smooth,
    smooth_optical,
)
from estimators.orientation import create
from estimators.recording import Float, ImuChunk
from validation.optical.scenes import (
    MARKER_SIGMA_M,
    STEP_S,
    STILL_S,
    Scene,
    free_motion,
    measured,
)
from validation.protocol import Data, Figure, Protocol, Values

FORCE_SIGMA_MPS2, RATE_SIGMA_RADPS = 0.05, 0.01
"""Page 4.2; the defaults of the filter are these, so that it runs with its own parameters here."""
_SCENE_FORCE, _SCENE_RATE = 0.02, 0.005
_GAPS_S = ((9.0, 11.0), (15.0, 17.0), (20.0, 22.0))
_RATIOS = (1, 2, 5, 10, 20, 50, 100)
_STRIKE_S, _STRIKE_MPS2 = 0.02, 40.0


def _one(value: float) -> Float:
    return np.array([value])


def _rms(values: Float) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def noisier(scene: Scene, seed: int) -> Scene:
    """Return the scene with the noise of page 4.2, the gyroscope zeroed over 1.5 s of rest again."""
    rng = np.random.default_rng([seed, 167])
    shape = scene.chunk.gyroscope_radps.shape
    rate = scene.chunk.gyroscope_radps + rng.normal(0.0, np.sqrt(RATE_SIGMA_RADPS**2 - _SCENE_RATE**2), shape)
    rate = rate - rate[scene.time_s < 1.5].mean(axis=0)
    force = scene.chunk.accelerometer_mps2 + rng.normal(
        0.0, np.sqrt(FORCE_SIGMA_MPS2**2 - _SCENE_FORCE**2), shape
    )
    return replace(scene, chunk=replace(scene.chunk, gyroscope_radps=rate, accelerometer_mps2=force))


def _add(values: dict[str, list[float]], name: str, value: float) -> None:
    values.setdefault(name, []).append(value)


def _gaps(seed: int, values: dict[str, list[float]]) -> None:
    """V1: three gaps of two seconds in free and in slow movement."""
    for title, highest in (("", 1.0), ("slow: ", 0.5)):
        scene = noisier(free_motion(seed, highest_hz=highest), seed)
        truth, time = scene.position_m, scene.time_s
        missing = np.zeros(len(time), dtype=np.bool_)
        for start, stop in _GAPS_S:
            missing |= (time >= start) & (time < stop)
        holed = scene.without(missing)
        forward, smoothed = filter_and_smooth(holed)
        found = {
            "forward": forward.position_m,
            "smoothed": smoothed.position_m,
            "spline": fill_by_spline(holed.marker_m, STEP_S),
        }
        z = {name: 1e3 * float(np.abs((p - truth)[missing, 2]).max()) for name, p in found.items()}
        _add(values, f"{title}forward, largest z error", z["forward"])
        _add(values, f"{title}smoothed, largest z error", z["smoothed"])
        _add(values, f"{title}spline over smoothed", z["spline"] / z["smoothed"])
        ends = np.flatnonzero(np.diff(missing.astype(int)) == -1)
        error = smoothed.position_m - truth
        step = np.linalg.norm(error[ends + 1] - error[ends], axis=1)
        _add(values, f"{title}smoothed, step at the end of a gap", 1e3 * float(step.max()))


def _rates(seed: int, values: dict[str, list[float]]) -> None:
    """V3: a marker at every r-th sample."""
    scene = noisier(free_motion(seed), seed)
    on = scene.time_s >= 5.0
    for ratio in _RATIOS:
        seen = np.arange(len(scene.time_s)) % ratio == 0
        both = filter_and_smooth(scene.without(~seen & (scene.time_s >= STILL_S)))
        for name, result in zip(("forward", "smoothed"), both, strict=True):
            error = np.linalg.norm((result.position_m - scene.position_m)[on], axis=1)
            _add(values, f"ratio {ratio}, {name}", 1e3 * _rms(error))
            if ratio <= 10 and name == "smoothed":
                _add(values, f"ratio {ratio}, smoothed, largest", 1e3 * float(error.max()))
    sharp = free_motion(seed, marker=0.00003)
    followed = OpticalInertialFilter(STEP_S, {"marker_sigma_m": 0.0001}).update(noisier(sharp, seed).chunk)
    apart = np.linalg.norm((followed.position_m - sharp.chunk.marker_m)[on], axis=1)
    _add(values, "ratio 1, from markers of 0.03 mm noise", 1e3 * _rms(apart))


def _heel_strike(seed: int) -> Scene:
    """Return a foot that comes down hard once a second: a bump of 20 ms and 40 m/s^2."""
    rng = np.random.default_rng([seed, 173])
    grid = np.arange(0.0, 14.2, 0.005)
    strikes = np.arange(STILL_S + 1.0, 13.5, 1.1)
    u = (grid[:, None] - strikes) / _STRIKE_S
    path = np.zeros((len(grid), 3))
    path[:, 2] = -(_STRIKE_MPS2 * _STRIKE_S**2 * np.exp(-0.5 * u * u)).sum(axis=1)
    path[:, 0] = 0.2 * np.sin(2 * np.pi * 0.45 * np.maximum(grid - STILL_S, 0.0)) ** 3
    return noisier(measured(rng, grid, path, np.zeros_like(path), 14.0, MARKER_SIGMA_M), seed)


def _acceleration(seed: int, values: dict[str, list[float]]) -> None:
    """V6: acceleration of the module and of the markers, in noise and at heel strike."""
    rng = np.random.default_rng([seed, 179])
    law = MARKER_SIGMA_M * np.sqrt(6.0) / STEP_S**2
    raw = np.diff(rng.normal(0.0, MARKER_SIGMA_M, (4000, 3)), 2, axis=0) / STEP_S**2
    _add(values, "twice differentiated, off its law", 100.0 * abs(_rms(raw) / law - 1.0))
    low = butter(2, 25.0, fs=1.0 / STEP_S, output="sos")
    filtered = _rms(sosfiltfilt(low, raw, axis=0)[50:-50])
    _add(values, "twice differentiated, below 25 Hz", filtered)
    scene = _heel_strike(seed)
    found = smooth_optical(scene.chunk).acceleration_mps2
    marker = np.zeros_like(found)
    marker[1:-1] = np.diff(scene.chunk.marker_m, 2, axis=0) / STEP_S**2
    optical = sosfiltfilt(low, marker, axis=0)
    on = scene.time_s >= STILL_S
    _add(values, "acceleration, inertial", _rms((found - scene.acceleration_mps2)[on]))
    peaks = []
    for strike in np.arange(STILL_S + 1.0, 13.0, 1.1):
        part = (scene.time_s > strike - 0.05) & (scene.time_s < strike + 0.05)
        peaks.append([float(a[part, 2].max()) for a in (scene.acceleration_mps2, found, optical)])
    truth, inertial, camera = np.mean(peaks, axis=0)
    _add(values, "heel strike, peak of the module, off", 100.0 * abs(inertial / truth - 1.0))
    _add(values, "heel strike, peak of markers below 25 Hz, off", 100.0 * abs(camera / truth - 1.0))


def _cyclic(seed: int) -> Scene:
    rng = np.random.default_rng([seed, 193])
    grid = np.arange(0.0, 30.2, 0.02)
    x = np.clip((grid - STILL_S) / 2.0, 0.0, 1.0)
    begin = (x**3 * (10 - 15 * x + 6 * x * x))[:, None]
    phases = rng.uniform(0.0, 2 * np.pi, (2, 3))
    wave = np.sin(2 * np.pi * 0.3 * grid[:, None] + phases[0]) * [0.25, 0.25, 0.1]
    turn = np.sin(2 * np.pi * 0.3 * grid[:, None] + phases[1]) * [0.3, 0.3, 0.3]
    return noisier(measured(rng, grid, wave * begin, turn * begin, 30.0, MARKER_SIGMA_M), seed)


def _attitudes(scene: Scene, seed: int) -> dict[str, Float]:
    """Return attitudes of others: tilted by a tenth of the acceleration, and of the filter of chapter 2 itself."""
    a = scene.acceleration_mps2
    tilt = 0.1 / GRAVITY_MPS2 * np.column_stack([-a[:, 1], a[:, 0], np.zeros(len(a))])
    rng = np.random.default_rng([seed, 197])
    earth = np.array([0.0, 1.9e-5, -4.5e-5])
    field = rotation.rotate(rotation.conjugate(scene.q_room_sensor), earth)
    field = field + rng.normal(0.0, 5e-8, field.shape)
    estimator = create("roetenberg_disturbance", 1, STEP_S)
    estimator.set_gyroscope_bias(np.zeros((1, 3)), RATE_SIGMA_RADPS / np.sqrt(150.0))
    found = estimator.update(
        ImuChunk(
            0,
            STEP_S,
            scene.chunk.gyroscope_radps[None],
            scene.chunk.accelerometer_mps2[None],
            field[None],
            np.zeros((1, len(a)), dtype=np.uint8),
        )
    )
    return {
        "tilted by 0.1 a/g": rotation.multiply(rotation.exp(tilt), scene.q_room_sensor),
        "filter of chapter 2": found.q_earth_sensor[0],
    }


def _from_outside(seed: int, values: dict[str, list[float]]) -> None:
    """V4: attitude from outside, its error taken as white noise of the force, of whatever size serves it best."""
    scene = _cyclic(seed)
    seen = (np.arange(len(scene.time_s)) % 50 == 0) | (scene.time_s < STILL_S)
    thinned, on = scene.without(~seen), scene.time_s >= 6.0
    live = OpticalInertialFilter(STEP_S).update(thinned).position_m
    own = 1e3 * _rms(np.linalg.norm((live - scene.position_m)[on], axis=1))
    _add(values, "cyclic, ratio 50: own attitude", own)
    for name, attitude in _attitudes(scene, seed).items():
        level = OpticalChunk(
            0,
            STEP_S,
            np.zeros_like(scene.position_m),
            rotation.rotate(attitude, thinned.accelerometer_mps2),
            thinned.marker_m,
        )
        best = min(
            _without_attitude(level, scene, sigma, on) for sigma in (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
        )
        _add(values, f"cyclic, ratio 50: attitude {name}", best)
        _add(values, f"cyclic: {name} over own", best / own)


def _without_attitude(level: OpticalChunk, scene: Scene, sigma: float, on: NDArray[np.bool_]) -> float:
    """Return the error (mm rms) of a filter without attitude and gyroscope, with this noise of the force."""
    other = OpticalInertialFilter(
        STEP_S,
        {
            "force_sigma_mps2": sigma,
            "rate_sigma_radps": 1e-12,
            "rate_walk": 0.0,
            "rate_bias_sigma_radps": 0.0,
        },
    )
    other.begin(
        OpticalStart(
            scene.position_m[0],
            np.zeros(3),
            rotation.identity(),
            np.zeros(3),
            tilt_sigma_rad=0.0,
            heading_sigma_rad=0.0,
        )
    )
    error = (other.update(level).position_m - scene.position_m)[on]
    return 1e3 * _rms(np.linalg.norm(error, axis=1))


def _checks(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        _gaps(seed, values)
        _rates(seed, values)
        _acceleration(seed, values)
        _from_outside(seed, values)
    found = {name: np.array(rows) for name, rows in values.items()}
    for title in ("", "slow: "):
        name = f"{title}smoothed, largest z error"
        found[f"{name}, mean"] = _one(float(found[name].mean()))
    for name in ("forward", "smoothed"):
        # As on the page, the mean over the trials.
        found[f"ratio 100, {name}, mean"] = _one(float(found[f"ratio 100, {name}"].mean()))
        means = np.array([found[f"ratio {ratio}, {name}"].mean() for ratio in _RATIOS])
        found[f"{name}, least growth from ratio to ratio"] = _one(float((means[1:] / means[:-1]).min()))
    return found


def _figures() -> tuple[Figure, ...]:
    figures = []
    for title in ("", "slow: "):
        figures += [
            Figure(f"{title}forward, largest z error", "mm", None, 11.6),
            # With this noise a trial in twenty is above; with that of the page's strict pass none is (optical_gaps).
            Figure(f"{title}smoothed, largest z error", "mm", None, 3.8),
            Figure(f"{title}smoothed, largest z error, mean", "mm", 3.8, 3.8),
            Figure(f"{title}spline over smoothed", "1", 5.0, at_most=False),
            Figure(f"{title}smoothed, step at the end of a gap", "mm", 1.0),
        ]
    for ratio in _RATIOS:
        figures += [Figure(f"ratio {ratio}, {name}", "mm") for name in ("forward", "smoothed")]
        if ratio <= 10:
            # 1 mm above the noise of the markers.
            figures.append(Figure(f"ratio {ratio}, smoothed, largest", "mm", 1.3, 1.0, judged_by="median"))
    figures += [
        Figure(f"{name}, least growth from ratio to ratio", "1", 1.0, at_most=False)
        for name in ("forward", "smoothed")
    ]
    return (
        *figures,
        Figure("ratio 100, forward, mean", "mm", 15.0, 15.0),
        Figure("ratio 100, smoothed, mean", "mm", 2.5, 2.5),
        Figure("ratio 1, from markers of 0.03 mm noise", "mm", 0.1, 0.1),
        Figure("twice differentiated, off its law", "%", 3.0),
        Figure("twice differentiated, below 25 Hz", "m/s^2"),
        Figure("acceleration, inertial", "m/s^2", 0.1),
        Figure("heel strike, peak of the module, off", "%", 5.0),
        Figure("heel strike, peak of markers below 25 Hz, off", "%"),
        Figure("cyclic, ratio 50: own attitude", "mm"),
        Figure("cyclic, ratio 50: attitude tilted by 0.1 a/g", "mm"),
        Figure("cyclic, ratio 50: attitude filter of chapter 2", "mm"),
        Figure("cyclic: tilted by 0.1 a/g over own", "1", 2.0, 2.0, at_most=False),
        Figure("cyclic: filter of chapter 2 over own", "1", None, 2.0),
    )


OPTICAL_NOISE_CHECKS = Protocol(
    name="optical_noise_checks",
    title="Optical aid with the sensors of the thesis",
    source="Roetenberg 2006, 4.4, 4.5, app. 4.A, fig. 4.6 to 4.10; method page V1, V3, V4, V6 with the noise of 4.2",
    what="Accelerometer 0.05 m/s^2 and gyroscope 0.01 rad/s a sample, the filter with its default parameters: gaps of "
    "2 s, every update ratio, heel strike, and the attitude of others instead of its own, where the filter that takes "
    "it has the noise of the force that serves it best.",
    figures=_figures(),
    measure=_checks,
)
