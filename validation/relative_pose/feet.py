"""Foot to foot: step width and both feet in one frame, from two shoes and a source (Schepers 2009, F-35)."""

from collections.abc import Sequence

import numpy as np

from estimators import rotation
from estimators.gait import FootParameters, find_stance, find_strides, smooth
from estimators.magnetic.published import SHOE_PARAMETERS, shoe_source
from estimators.recording import Float, SensorSignals
from validation.protocol import Data, Figure, Protocol, Values
from validation.relative_pose.runs import Run, mean_nees, rms, session

_WALK_S = 600.0
_FROM_S = 6.0
_WIDTH_M = 0.18
"""Between the feet of the simulated walk, which goes straight."""


def _placements(run: Run) -> tuple[Float, Float, Float]:
    """Return footholds of both feet in the frame of the left one, (n, 3) and (m, 3), and the steps' widths, (m,).

    The left foot by its own sensor (stances hold it); the right foot where the left sees it. The world is that of
    the left trajectory: heading is its own, so that nothing here depends on a compass or on how the walk began.
    """
    scene = run.scene
    left = smooth(SensorSignals(scene.time_s, scene.source_gyroscope_radps, scene.source_accelerometer_mps2))
    holds = find_strides(left, "left").footholds
    stance = find_stance(
        scene.gyroscope_radps, scene.accelerometer_mps2, 1.0 / scene.time_step_s, FootParameters()
    ).is_stance
    edges = np.flatnonzero(np.diff(np.concatenate([[0], stance.astype(int), [0]])))
    starts, stops = edges[::2], edges[1::2]
    within = (scene.time_s[starts] > _FROM_S) & (scene.time_s[stops - 1] < _WALK_S - 2.0)
    starts, stops = starts[within], stops[within]
    quiet = (starts + stops) // 2
    seen = left.position_m + rotation.rotate(left.q_world_sensor, run.result.position_m)
    # The foot stands: every sample of the stance tells the same place.
    right = np.stack([seen[start:stop].mean(axis=0) for start, stop in zip(starts, stops, strict=True)])
    # The line of progression runs through the left footholds before and after the step.
    after = np.clip(np.searchsorted(holds.quietest_s, scene.time_s[quiet]), 1, len(holds.quietest_s) - 1)
    line = holds.position_m[after, :2] - holds.position_m[after - 1, :2]
    line /= np.linalg.norm(line, axis=1)[:, None]
    from_left = right[:, :2] - holds.position_m[after - 1, :2]
    width = line[:, 1] * from_left[:, 0] - line[:, 0] * from_left[:, 1]
    return holds.position_m, right, width


def _feet(seeds: Sequence[int], data: Data) -> Values:
    rows: dict[str, list[float]] = {}
    for seed in seeds:
        run = session("feet", seed, _WALK_S, dict(SHOE_PARAMETERS), source=shoe_source())
        on = run.scene.time_s >= _FROM_S
        errors = np.concatenate([run.position_error_m, run.attitude_error_rad], axis=1)[on]
        minutes = np.array_split(errors[:, :3], 10)
        _, right, width = _placements(run)
        steps = np.linalg.norm(np.diff(right[:, :2], axis=0), axis=1)
        for name, value in (
            ("position", rms(errors[:, :3])),
            ("orientation", float(np.degrees(rms(errors[:, 3:])))),
            ("largest position error", float(np.linalg.norm(errors[:, :3], axis=1).max())),
            ("last minute over first minute", rms(minutes[-1]) / rms(minutes[0])),
            ("step width", float(np.sqrt(np.mean((width - _WIDTH_M) ** 2)))),
            ("mean step width, off", abs(float(np.mean(width)) - _WIDTH_M)),
            ("stride of the right foot in the left one's frame", float(np.sqrt(np.mean((steps - 1.2) ** 2)))),
            ("steps found", float(len(width))),
            ("NEES per state", mean_nees(errors, run.result.covariance[on])),
            (
                "interval",
                float(np.sum(on)) * run.scene.time_step_s / max(1, int(np.sum(run.result.fire_coil[on] > 0))),
            ),
        ):
            rows.setdefault(name, []).append(value)
    nees = np.array([float(np.mean(rows.pop("NEES per state")))])
    return {name: np.array(values) for name, values in rows.items()} | {
        "NEES per state, at most": nees,
        "NEES per state, at least": nees,
    }


RELATIVE_POSE_FEET = Protocol(
    name="relative_pose_feet",
    title="Foot to foot, ten minutes of walking",
    source="Schepers 2009, 6.4, 7.2 (F-35); method page 7.4; issue: step width",
    what="Source on the left shoe (coils of 7.5 cm, 1.36 A), sensor on the right; the live filter starts by itself "
    "from standing. The left foot is followed by its own sensor, the right foot's placements are put into its frame; "
    "step width is across the line through the left footholds.",
    figures=(
        Figure("position", "m", 0.030),
        Figure("orientation", "deg", 2.5),
        Figure("largest position error", "m", 0.12),
        Figure("last minute over first minute", "1", 1.2),
        Figure("step width", "m", 0.010),
        Figure("mean step width, off", "m", 0.010),
        Figure("stride of the right foot in the left one's frame", "m", 0.030),
        Figure("steps found", "1", 500.0, at_most=False),
        Figure("interval", "s"),
        Figure("NEES per state, at most", "1", 1.4),
        Figure("NEES per state, at least", "1", 0.6, at_most=False),
    ),
    measure=_feet,
)
