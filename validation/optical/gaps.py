"""Optical and inertial sensing together (Roetenberg 2006, chapter 4): gaps, lower rates, ghosts, acceleration."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from estimators.optical import Provenance
from estimators.optical.published import (
    OpticalChunk,
    OpticalInertialFilter,
    fill_by_spline,
    filter_and_smooth,
    smooth_optical,
)
from estimators.recording import Float
from validation.optical.scenes import (
    PARAMETERS,
    STEP_S,
    STILL_S,
    Scene,
    free_motion,
    walking_foot,
)
from validation.protocol import Data, Figure, Protocol, Values

_GAPS_S = ((9.0, 11.0), (15.0, 17.0), (20.0, 22.0))
_GAIT_TICKS = (5, 10, 25, 50)
_GAIT_PAIRS = ((50, 5), (25, 10))
"""Lengths of gaps that take turns in one walk."""


def _gaps(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        scene = free_motion(seed)
        truth, t = scene.position_m, scene.time_s
        missing = np.zeros(len(t), dtype=np.bool_)
        for start, stop in _GAPS_S:
            missing |= (t >= start) & (t < stop)
        holed = scene.without(missing)
        live, smoothed = filter_and_smooth(holed, PARAMETERS)
        spline = fill_by_spline(holed.marker_m, STEP_S)
        z = {
            "forward, largest z error": live.position_m,
            "smoothed, largest z error": smoothed.position_m,
            "spline, largest z error": spline,
        }
        for name, position in z.items():
            values.setdefault(name, []).append(1e3 * float(np.abs((position - truth)[missing, 2]).max()))
        ends = np.flatnonzero(np.diff(missing.astype(int)) == -1)
        error = (smoothed.position_m - truth)[:, 2]
        values.setdefault("smoothed, step at the end of a gap", []).append(
            1e3 * float(np.abs(error[ends + 1] - error[ends]).max())
        )
        sigma = smoothed.position_sigma_m[missing]
        ratio = (smoothed.position_m - truth)[missing] / sigma
        values.setdefault("smoothed, errors within three sigma", []).append(
            100.0 * float(np.mean(np.abs(ratio) < 3.0))
        )
        slow = free_motion(seed, highest_hz=0.5)
        holed = slow.without(missing)
        for name, position in (
            ("slow: smoothed, largest z error", smooth_optical(holed, PARAMETERS).position_m),
            ("slow: spline, largest z error", fill_by_spline(holed.marker_m, STEP_S)),
        ):
            off = (position - slow.position_m)[missing, 2]
            values.setdefault(name, []).append(1e3 * float(np.abs(off).max()))
        values.setdefault("spline over smoothed", []).append(
            values["spline, largest z error"][-1] / values["smoothed, largest z error"][-1]
        )
        short = np.zeros(len(t), dtype=np.bool_)
        for start in np.arange(6.0, 23.0, 1.0):
            short |= (t >= start) & (t < start + 0.1)
        found = smooth_optical(scene.without(short), PARAMETERS).position_m
        values.setdefault("gaps of 0.1 s, largest error", []).append(
            1e3 * float(np.linalg.norm((found - truth)[short], axis=1).max())
        )
        half = np.zeros(len(t), dtype=np.bool_)
        for start in np.arange(6.0, 23.0, 2.0):
            half |= (t >= start) & (t < start + 0.5)
        found = smooth_optical(scene.without(half), PARAMETERS).position_m
        values.setdefault("gaps of 0.5 s, largest error", []).append(
            1e3 * float(np.linalg.norm((found - truth)[half], axis=1).max())
        )
    return {name: np.array(rows) for name, rows in values.items()}


def _gait(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        scene, phase = walking_foot(seed)
        found: dict[tuple[int, str], list[float]] = {}
        for tenth in range(10):
            for pair in _GAIT_PAIRS:
                _gait_gaps(scene, phase, tenth, pair, found)
        for length in _GAIT_TICKS:
            for name in ("forward", "smoothed"):
                values.setdefault(f"{length} ticks, {name}, worst phase", []).append(max(found[length, name]))
            if length >= 25:
                swing, spline = (np.mean(found[length, name]) for name in ("swing", "swing spline"))
                values.setdefault(f"{length} ticks in swing, spline", []).append(float(spline))
                values.setdefault(f"{length} ticks in swing, spline over smoothed", []).append(
                    float(spline / swing)
                )
    return {name: np.array(rows) for name, rows in values.items()}


def _gait_gaps(
    scene: Scene,
    phase: Float,
    tenth: int,
    lengths: tuple[int, int],
    found: dict[tuple[int, str], list[float]],
) -> None:
    """Hide the marker at a tenth of the cycle, for the one length in every other cycle, for the other in between."""
    first_s = STILL_S + 1.1 * (2 + 0.1 * tenth)
    rows = {
        length: [
            np.arange(length) + round(start / STEP_S)
            for start in np.arange(first_s + 1.1 * number, scene.time_s[-1] - 1.5, 2.2)
        ]
        for number, length in enumerate(lengths)
    }
    hidden = np.zeros(len(phase), dtype=np.bool_)
    for gaps in rows.values():
        hidden[np.concatenate(gaps)] = True
    holed = scene.without(hidden)
    forward, smoothed = filter_and_smooth(holed, PARAMETERS)
    spline = fill_by_spline(holed.marker_m, STEP_S)
    for length, gaps in rows.items():

        def largest(position: Float, gaps: list[Any] = gaps) -> float:
            error = [np.linalg.norm(position[r] - scene.position_m[r], axis=1).max() for r in gaps]
            return 1e3 * float(np.mean(error))

        found.setdefault((length, "forward"), []).append(largest(forward.position_m))
        found.setdefault((length, "smoothed"), []).append(largest(smoothed.position_m))
        if 0.6 <= phase[gaps[0][length // 2]] <= 0.9:
            found.setdefault((length, "swing"), []).append(found[length, "smoothed"][-1])
            found.setdefault((length, "swing spline"), []).append(largest(spline))


def _rates(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        scene = free_motion(seed)
        chunk, truth, acceleration, t = scene.chunk, scene.position_m, scene.acceleration_mps2, scene.time_s
        on = t >= 5.0
        for ratio in (1, 10, 50, 100):
            seen = np.arange(len(t)) % ratio == 0
            thinned = scene.without(~seen & (t >= STILL_S))
            both = zip(("forward", "smoothed"), filter_and_smooth(thinned, PARAMETERS), strict=True)
            for name, result in both:
                position = result.position_m
                error = np.linalg.norm((position - truth)[on], axis=1)
                values.setdefault(f"ratio {ratio}, {name}", []).append(
                    1e3 * float(np.sqrt(np.mean(error**2)))
                )
                if ratio == 10 and name == "smoothed":
                    values.setdefault("ratio 10, smoothed, largest", []).append(1e3 * float(error.max()))
        full = smooth_optical(chunk, PARAMETERS)
        error = (full.acceleration_mps2 - acceleration)[on]
        values.setdefault("acceleration, inertial", []).append(float(np.sqrt(np.mean(error**2))))
        raw = (chunk.marker_m[2:] - 2 * chunk.marker_m[1:-1] + chunk.marker_m[:-2]) / STEP_S**2
        values.setdefault("acceleration, twice differentiated", []).append(
            float(np.sqrt(np.mean((raw - acceleration[1:-1])[on[1:-1]] ** 2)))
        )
        rng = np.random.default_rng([seed, 127])
        ghost = (rng.random(len(t)) < 0.01) & (t > STILL_S)
        off = rng.normal(size=(len(t), 3))
        off *= rng.uniform(0.05, 0.5, (len(t), 1)) / np.linalg.norm(off, axis=1, keepdims=True)
        marker = chunk.marker_m + np.where(ghost[:, None], off, 0.0)
        seen_chunk = OpticalChunk(0, STEP_S, chunk.gyroscope_radps, chunk.accelerometer_mps2, marker)
        filtered = OpticalInertialFilter(STEP_S, PARAMETERS).update(seen_chunk)
        rejected = filtered.provenance == Provenance.REJECTED
        values.setdefault("ghosts rejected", []).append(100.0 * float(np.mean(rejected[ghost])))
        values.setdefault("sound markers rejected", []).append(100.0 * float(np.mean(rejected[~ghost & on])))
        clean = OpticalInertialFilter(STEP_S, PARAMETERS).update(chunk)
        sizes = [np.sqrt(np.mean((r.position_m - truth)[on] ** 2)) for r in (filtered, clean)]
        values.setdefault("error with ghosts over without", []).append(float(sizes[0] / sizes[1]))
    return {name: np.array(rows) for name, rows in values.items()}


OPTICAL_GAPS = Protocol(
    name="optical_gaps",
    title="Gaps of markers: inertial against spline",
    source="Roetenberg 2006, 4.4, fig. 4.7, 4.8; method page V1",
    what="Free hand motion (0.1 to 1 Hz) with three gaps of 2 s; largest error along z (page: forward in the mean, "
    "smoothed in every seed). Then gaps of 0.1 and 0.5 s, in space.",
    figures=(
        Figure("forward, largest z error", "mm", 11.6, 11.6, judged_by="median"),
        Figure("smoothed, largest z error", "mm", 3.8, 3.8),
        Figure("spline, largest z error", "mm", None, 121.0),
        Figure("slow: smoothed, largest z error", "mm", 3.8, 3.8),
        Figure("slow: spline, largest z error", "mm", None, 121.0),
        Figure("spline over smoothed", "1", 5.0, at_most=False),
        Figure("smoothed, step at the end of a gap", "mm", 1.0),
        Figure("smoothed, errors within three sigma", "%", 95.0, at_most=False, judged_by="median"),
        Figure("gaps of 0.1 s, largest error", "mm", 3.0),
        Figure("gaps of 0.5 s, largest error", "mm", 5.0),
    ),
    measure=_gaps,
)
OPTICAL_RATES = Protocol(
    name="optical_rates",
    title="Fewer frames, ghosts, acceleration",
    source="Roetenberg 2006, 4.4, 4.5, fig. 4.6, 4.9; method page V3, V6, V7",
    what="A marker only at every r-th sample; noise of acceleration; 1 % ghost markers of 5 to 50 cm.",
    figures=(
        Figure("ratio 1, forward", "mm"),
        Figure("ratio 1, smoothed", "mm"),
        Figure("ratio 10, forward", "mm"),
        Figure("ratio 10, smoothed", "mm"),
        Figure("ratio 10, smoothed, largest", "mm", 1.9, 1.0),
        Figure("ratio 50, forward", "mm"),
        Figure("ratio 50, smoothed", "mm"),
        Figure("ratio 100, forward", "mm", 15.0, 15.0),
        Figure("ratio 100, smoothed", "mm", 2.5, 2.5),
        Figure("acceleration, inertial", "m/s^2", 0.1),
        Figure("acceleration, twice differentiated", "m/s^2", None, 7.3),
        Figure("ghosts rejected", "%", 99.0, at_most=False, judged_by="median"),
        Figure("sound markers rejected", "%", 0.1, judged_by="median"),
        Figure("error with ghosts over without", "1", 1.05, judged_by="median"),
    ),
    measure=_rates,
)
OPTICAL_GAIT = Protocol(
    name="optical_gait",
    title="Gaps in a walk, by phase of the cycle",
    source="Roetenberg 2006, 4.4, fig. 4.8; method page V2",
    what="Marker and module on a walking foot; gaps of 50, 100, 250 and 500 ms that begin at every tenth of the cycle. "
    "Largest error in space of each gap, mean over gaps, of the worst phase.",
    figures=(
        *(Figure(f"{n} ticks, forward, worst phase", "mm") for n in _GAIT_TICKS),
        *(Figure(f"{n} ticks, smoothed, worst phase", "mm", 3.0 if n <= 10 else 5.0) for n in _GAIT_TICKS),
        Figure("25 ticks in swing, spline", "mm"),
        Figure("50 ticks in swing, spline", "mm"),
        Figure("25 ticks in swing, spline over smoothed", "1", 5.0, at_most=False),
        Figure("50 ticks in swing, spline over smoothed", "1", 5.0, at_most=False),
    ),
    measure=_gait,
)
