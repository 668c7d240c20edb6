"""BROAD begun anywhere: each trial cut at random moments inside its movement."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators import orientation
from estimators.orientation import OrientationResult, orientation_errors
from estimators.recording import Float, Recording
from estimators.signals import to_common_ticks
from validation.orientation.broad import DEGREES_PER_RADIAN, package, sensor_name
from validation.orientation.broad_conditions import share_of_result_inside, started_at
from validation.orientation.broad_offline import package_offline
from validation.protocol import Data, Figure, Protocol, Values

_CUTS = 12
_FOUND_AGAIN_S, _SCORED_S = 20.0, 20.0
"""From when after the cut a run is scored, and for how long at least."""
_LOST_DEG, _SOUND_DEG = 10.0, 5.0
_SHARE, _BEYOND_DEG = 1.5, 0.5
_KINDS = {"online": "VQF", "off-line": "VQF off-line"}


@dataclass(frozen=True)
class CutRun:
    """One trial begun at one moment.

    Attributes
    ----------
    ours_deg, other_deg : float
        Total error from 20 s after the cut on, ours and that of the `vqf` package started the same way.
    inside : float
        Share of the scored samples whose error lies in the region that ours states for 95 %.
    """

    ours_deg: float
    other_deg: float
    inside: float


def cut_moments(recording: Recording, seed: int) -> NDArray[np.int64]:
    """Return the samples where a trial is cut: inside the movement, with 40 s of it left."""
    moving = np.flatnonzero(recording.reference["is_movement"])
    left = round((_FOUND_AGAIN_S + _SCORED_S) * recording.nominal_rate_hz)
    rng = np.random.default_rng([seed, recording.reference["is_movement"].size])
    return rng.integers(moving[0], moving[-1] - left, _CUTS)


def scored(recording: Recording) -> Recording:
    """Leave the first 20 s of a cut trial out of its score."""
    late = recording.sensors[sensor_name(recording)].time_s >= _FOUND_AGAIN_S
    recording.reference["is_movement"] = recording.reference["is_movement"].astype(bool) & late
    return recording


def _total_deg(recording: Recording, q_earth_sensor: Float) -> float:
    truth = recording.reference
    errors = orientation_errors(q_earth_sensor, truth["q_earth_sensor"], truth["is_movement"])
    return float(DEGREES_PER_RADIAN * errors.total_rad)


def _run(recording: Recording, found: OrientationResult, other: Float) -> CutRun:
    ticks = len(recording.reference["q_earth_sensor"])
    return CutRun(
        _total_deg(recording, found.q_earth_sensor[0, :ticks]),
        _total_deg(recording, other),
        share_of_result_inside(recording, found),
    )


def cut_runs(recording: Recording, seed: int) -> dict[str, list[CutRun]]:
    """Return the runs of one trial, online and off-line."""
    runs: dict[str, list[CutRun]] = {kind: [] for kind in _KINDS}
    for moment in cut_moments(recording, seed):
        cut = scored(started_at(recording, int(moment)))
        chunk = to_common_ticks(cut, cut.nominal_rate_hz)
        live = orientation.create("telemotion", 1, chunk.time_step_s).update(chunk)
        smoothed = orientation.smooth("telemotion_smoother", chunk).orientation
        runs["online"].append(_run(cut, live, package(cut)))
        runs["off-line"].append(_run(cut, smoothed, package_offline(cut)))
    return runs


def _cuts(seeds: Sequence[int], data: Data) -> Values:
    trials = [cut_runs(trial, seeds[0]) for trial in data.values()]
    values: Values = {}
    for kind, other in _KINDS.items():
        runs = [run for trial in trials for run in trial[kind]]
        ours_deg, other_deg = (
            np.array([getattr(run, name) for run in runs]) for name in ("ours_deg", "other_deg")
        )
        may_deg = _SHARE * other_deg + _BEYOND_DEG
        lost = (ours_deg > _LOST_DEG) & (other_deg < _SOUND_DEG)
        inside = np.array([np.mean([run.inside for run in runs])])
        values[f"Telemotion, {kind}"] = np.array([ours_deg.mean()])
        values[other] = np.array([other_deg.mean()])
        values[f"Telemotion over {other}"] = np.array([ours_deg.mean() / other_deg.mean()])
        values[f"lost, {kind}"] = np.array([float(lost.sum())])
        values[f"beyond what a run may have, {kind}"] = np.array([float((ours_deg > may_deg).sum())])
        values[f"share of what a run may have, {kind}"] = ours_deg / may_deg
        values[f"inside the 95 % region at least, {kind}"] = inside
        values[f"inside the 95 % region at most, {kind}"] = inside
    return values


def _figures() -> tuple[Figure, ...]:
    figures = []
    for kind, other in _KINDS.items():
        figures += [
            Figure(f"Telemotion, {kind}", "deg"),
            Figure(other, "deg"),
            Figure(f"Telemotion over {other}", "1", 1.0),
            Figure(f"lost, {kind}", "runs", 0.0),
            Figure(f"beyond what a run may have, {kind}", "runs", 0.0),
            Figure(f"share of what a run may have, {kind}", "1"),
            Figure(f"inside the 95 % region at least, {kind}", "1", 0.90, at_most=False),
            Figure(f"inside the 95 % region at most, {kind}", "1", 0.99),
        ]
    return tuple(figures)


BROAD_CUTS = Protocol(
    name="orientation_cuts",
    title="A sensor started in the middle of movement (BROAD)",
    source="Laidig et al. 2021, Data 6(7):72; conditions ours",
    what="Each trial is cut at 12 moments inside its movement, drawn by the first seed, and begins there for ours and "
    "for the vqf package alike. Total error from 20 s after the cut on. Lost is a run above 10 degrees that VQF has "
    "below 5; no run may exceed 1.5 times VQF's error plus half a degree. The error must lie inside the region "
    "that ours states for 95 % with 90 to 99 % of all samples.",
    figures=_figures(),
    measure=_cuts,
    needs_data="broad",
)
