"""Foot-mounted sensors against motion capture and closed loops: recordings made by others."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait import FootFlag, FootParameters, FootTracker, find_strides, smooth, steady
from estimators.recording import Float, Recording, SensorSignals
from estimators.signals import to_common_ticks
from validation.protocol import Data, Figure, Protocol, Values

_PACE = "one parameter set for all people and speeds; the clip level of the gyroscope is all that is known of a device"
_LONG_M, _SHORT_LIMIT_M, _LONG_LIMIT_M = 40.0, 0.040, 0.350
_CHUNK = 20


def parameters_of(recording: Recording) -> FootParameters:
    """Return the parameters with what the recording says of its device."""
    clip = recording.metadata.get("gyroscope_clip_radps")
    return FootParameters() if clip is None else replace(FootParameters(), gyroscope_clip_radps=float(clip))


def live_position(signals: SensorSignals, rate_hz: float, parameters: FootParameters) -> Float:
    """Follow a foot live, on even ticks, and return its position at the samples, shape (N, 3)."""
    return followed(signals, rate_hz, parameters)[0]


def followed(
    signals: SensorSignals, rate_hz: float, parameters: FootParameters
) -> tuple[Float, NDArray[np.bool_]]:
    """Follow a foot live, on even ticks.

    Returns
    -------
    position_m : ndarray, shape (N, 3)
        At the samples.
    is_known : ndarray of bool, shape (N,)
        Whether a stance was found lately, as the flags say; before the first one speed and place are not known.
    """
    chunk = to_common_ticks(Recording({"foot": signals}, rate_hz), rate_hz)
    tracker = FootTracker(1, chunk.time_step_s, parameters)
    ticks = range(0, chunk.tick_count, _CHUNK)
    parts = [tracker.update(chunk.ticks(i, min(i + _CHUNK, chunk.tick_count))) for i in ticks]
    parts.append(tracker.finish())
    released = np.concatenate([part.position_m[0] for part in parts])
    flags = np.concatenate([part.flags[0] for part in parts])
    time_s = signals.time_s[0] + np.arange(len(released)) * chunk.time_step_s
    tick = np.clip(np.searchsorted(time_s, signals.time_s), 0, len(time_s) - 1)
    return _at(signals.time_s, time_s, released), (flags[tick] & int(FootFlag.NO_STANCE)) == 0


def rigid_rmse(found_m: Float, truth_m: Float) -> float:
    """Return the root mean square distance of planar tracks, shape (N, 2), after one rotation and shift."""
    seen = np.isfinite(truth_m).all(axis=1)
    a, b = found_m[seen] - found_m[seen].mean(axis=0), truth_m[seen] - truth_m[seen].mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = a @ np.array([[cosine, sine], [-sine, cosine]])
    return float(np.sqrt(np.mean(np.sum((turned - b) ** 2, axis=1))))


def _at(at_s: Float, time_s: Float, values: Float) -> Float:
    return np.stack([np.interp(at_s, time_s, values[:, i]) for i in range(values.shape[1])], axis=1)


def _walks(seeds: Sequence[int], data: Data) -> Values:
    off_line, live = [], []
    for recording in data.values():
        signals = next(iter(recording.sensors.values()))
        truth, parameters = recording.reference["position_xy_m"], parameters_of(recording)
        off_line.append(rigid_rmse(smooth(signals, parameters).position_m[:, :2], truth))
        found = live_position(signals, recording.nominal_rate_hz, parameters)
        live.append(rigid_rmse(found[:, :2], truth))
    return {
        "planar RMSE of a walk, off-line": np.array(off_line),
        "planar RMSE, off-line, mean of the walks": np.array([np.mean(off_line)]),
        "planar RMSE, off-line, median of the walks": np.array([np.median(off_line)]),
        "planar RMSE, live, mean of the walks": np.array([np.mean(live)]),
    }


FOOT_WALKS = Protocol(
    name="foot_walks",
    title="Walks and runs of a foot-mounted sensor (PyShoe motion capture)",
    source="Wagstaff et al. 2019; recordings of mtahakoroglu/LLIO-aided-iPyShoe",
    what="Each walk given is followed from its foot-mounted sensor; root mean square distance in the plane after one "
    f"rigid fit a walk. Published: the trajectories that the authors store. Here {_PACE}.",
    figures=(
        Figure("planar RMSE of a walk, off-line", "m"),
        Figure("planar RMSE, off-line, mean of the walks", "m", 0.062, 0.089),
        Figure("planar RMSE, off-line, median of the walks", "m", published=0.068),
        Figure("planar RMSE, live, mean of the walks", "m", 0.070),
    ),
    measure=_walks,
    needs_data="pyshoe",
)


def _strides(seeds: Sequence[int], data: Data) -> Values:
    errors: dict[str, list[float]] = {"off-line": [], "live": []}
    for recording in data.values():
        for side in ("left", "right"):
            signals = recording.sensors[f"foot_{side}"]
            events = recording.reference[f"strides_{side}"][:, :2] / recording.nominal_rate_hz
            heel = recording.reference[f"heel_{side}_m"][:, :2]
            mocap_s = recording.reference["motion_capture_time_s"]
            true = _length(_at(events[:, 0], mocap_s, heel), _at(events[:, 1], mocap_s, heel))
            parameters = parameters_of(recording)
            for way, position in (
                ("off-line", smooth(signals, parameters).position_m),
                ("live", live_position(signals, recording.nominal_rate_hz, parameters)),
            ):
                ends = [_at(events[:, i], signals.time_s, position[:, :2]) for i in (0, 1)]
                errors[way].extend((_length(*ends) - true).tolist())
    return {
        "stride length, mean absolute error, off-line": np.array([np.mean(np.abs(errors["off-line"]))]),
        "stride length, median absolute error, off-line": np.array([np.median(np.abs(errors["off-line"]))]),
        "stride length, mean error, off-line": np.array([np.mean(errors["off-line"])]),
        "stride length, mean absolute error, live": np.array([np.mean(np.abs(errors["live"]))]),
        "strides": np.array([float(len(errors["live"]))]),
    }


def _length(one: Float, two: Float) -> Float:
    return np.asarray(np.linalg.norm(two - one, axis=1))


FOOT_STRIDES = Protocol(
    name="foot_strides",
    title="Stride lengths of both feet against motion capture (gaitmap)",
    source="mad-lab-fau/gaitmap, its sample of 57 strides; its default and its RTS filter: 64.7 and 56.3 mm",
    what="Stride length between the instants that the library's stride list names, against the heel marker, which is "
    f"8 cm from the sensor and goes another way in turns. Here {_PACE}.",
    figures=(
        Figure("stride length, mean absolute error, off-line", "m", 0.016, 0.0563),
        Figure("stride length, median absolute error, off-line", "m"),
        Figure("stride length, mean error, off-line", "m"),
        Figure("stride length, mean absolute error, live", "m", 0.018),
        Figure("strides", "1"),
    ),
    measure=_strides,
    needs_data="gaitmap strides",
)


def _loops(seeds: Sequence[int], data: Data) -> Values:
    closures: dict[str, list[float]] = {"off-line": [], "live": []}
    shares = []
    for recording in data.values():
        signals, parameters = next(iter(recording.sensors.values())), parameters_of(recording)
        position = smooth(signals, parameters).position_m
        closures["off-line"].append(float(np.linalg.norm(position[-1] - position[0])))
        # From rest to rest: every tenth of a second is enough to tell how far somebody walked.
        path = position[:: max(1, round(0.1 * recording.nominal_rate_hz)), :2]
        length = float(np.sum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
        limit = _SHORT_LIMIT_M if length < _LONG_M else _LONG_LIMIT_M
        shares.append(closures["off-line"][-1] / limit)
        live = live_position(signals, recording.nominal_rate_hz, parameters)
        closures["live"].append(float(np.linalg.norm(live[-1] - live[0])))
    return {
        "closure in three dimensions, off-line": np.array(closures["off-line"]),
        "closure over what its length allows": np.array(shares),
        "closure in three dimensions, live": np.array(closures["live"]),
    }


FOOT_LOOPS = Protocol(
    name="foot_loops",
    title="Closed loops of a foot-mounted sensor (x-io)",
    source="xioTechnologies/Gait-Tracking: 82 mm (short walk) and 421 mm (long walk)",
    what="Distance between the first and the last sample of a walk that ends where it began. A walk under 40 m may "
    "miss by 40 mm, a longer one by 350 mm.",
    figures=(
        Figure("closure in three dimensions, off-line", "m", published=0.082),
        Figure("closure over what its length allows", "1", 1.0),
        Figure("closure in three dimensions, live", "m"),
    ),
    measure=_loops,
    needs_data="gait_tracking",
)


def _stairs(seeds: Sequence[int], data: Data) -> Values:
    shrunk, rises = [], []
    for recording in data.values():
        for signals in recording.sensors.values():
            parameters = parameters_of(recording)
            height = smooth(signals, parameters).position_m[:, 2]
            free = smooth(signals, replace(parameters, height_gate_m=1e-9)).position_m[:, 2]
            rises.append(float(np.ptp(height)))
            shrunk.append(abs(float(np.ptp(height) / np.ptp(free)) - 1.0))
    return {"flight, change by the height update": np.array(shrunk), "flight": np.array(rises)}


FOOT_STAIRS = Protocol(
    name="foot_stairs",
    title="Stairs are not flattened (gaitmap)",
    source="mad-lab-fau/gaitmap, its stairs; method page on foot tracking, section 8",
    what="Rise of each foot over a flight with the floor's height measured once a stance, against the same filter "
    "without that measurement, whose vertical drift over a flight is below 3 %.",
    figures=(Figure("flight, change by the height update", "1", 0.03), Figure("flight", "m")),
    measure=_stairs,
    needs_data="gaitmap stairs",
)


def _patient(seeds: Sequence[int], data: Data) -> Values:
    rises, longest, flagged = [], [], []
    for recording in data.values():
        (name,) = recording.sensors
        side: Side = "left" if name == "foot_left" else "right"
        strides = find_strides(smooth(recording.sensors[name], parameters_of(recording)), side)
        length = strides.length_m[steady(strides)]
        rises.append(float(strides.rise_m.sum()))
        longest.append(float(length.max() / np.median(length)))
        flagged.append(float(np.count_nonzero(strides.flags)))
    return {
        "longest stride that counts over their median": np.array(longest),
        "strides left out as too long": np.array(flagged),
        "heights of the feet apart at the end": np.array([np.ptp(rises)]),
    }


FOOT_PATIENT = Protocol(
    name="foot_patient",
    title="A patient's walk, foot by foot (gaitmap)",
    source="mad-lab-fau/gaitmap, its walk of a person with multiple sclerosis",
    what="Both feet of one walk at 102.4 Hz, each by itself. Two strides taken for one must not count. Nothing but the "
    "other foot tells the height: both should end alike, and what they miss is shown, not required.",
    figures=(
        Figure("longest stride that counts over their median", "1", 1.6),
        Figure("strides left out as too long", "1"),
        Figure("heights of the feet apart at the end", "m"),
    ),
    measure=_patient,
    needs_data="gaitmap patient",
)
