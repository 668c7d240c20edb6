"""Pipelines by name, frames put together, and whole recordings off-line."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.errors import CalibrationError, SetupError, ShapeError
from estimators.pipelines._balance import BalancePipeline
from estimators.pipelines._contract import Frames, Pipeline, SessionSetup
from estimators.pipelines._offline import smoothed_chunk
from estimators.pipelines._orientation import OrientationPipeline
from estimators.pipelines.arm.elbows import elbow_poses, refine_elbows
from estimators.pipelines.arm.pipeline import ArmPipeline
from estimators.pipelines.arm.slips import find_slips, with_slips
from estimators.pipelines.arm.worn import judge_worn
from estimators.pipelines.relative.pipeline import RelativePosePipeline
from estimators.pipelines.walk.pipeline import GaitPipeline
from estimators.pipelines.walk.walk import analyse_walk
from estimators.recording import Float, ImuChunk, Recording
from estimators.sentences import say

_REGISTRY: dict[str, type[Pipeline]] = {
    kind.name: kind
    for kind in (ArmPipeline, OrientationPipeline, GaitPipeline, RelativePosePipeline, BalancePipeline)
}
_POSE_S = 3.0
_SHORTEST_POSE_S = 1.5
_BLOCK = 6000
"""Ticks stepped at once off-line; any number gives the same frames."""


def available() -> dict[str, type[Pipeline]]:
    """Return the pipelines by name."""
    return dict(_REGISTRY)


def kind(name: str) -> type[Pipeline]:
    """Return a pipeline by its name, not yet built: what it needs and uses.

    Raises
    ------
    SetupError
        There is none of that name.
    """
    if name not in _REGISTRY:
        raise SetupError(say("setup.unknown_pipeline", name=name, known=list(_REGISTRY)))
    return _REGISTRY[name]


def create(setup: SessionSetup) -> Pipeline:
    """Build the pipeline that a setup asks for, having seen no samples.

    Raises
    ------
    SetupError
        For an unknown pipeline, estimator or parameter, or placements that cannot work together.
    """
    return kind(setup.pipeline)(setup)


def concatenate(parts: Sequence[Frames]) -> Frames:
    """Put consecutive frames together.

    Parameters
    ----------
    parts : sequence of Frames
        In order, of one layout, each starting where the one before ended.

    Raises
    ------
    ShapeError
        If there is none, or ticks are missing, repeated, or of another layout or rate.
    """
    if not parts:
        raise ShapeError("no frames to put together")
    first = parts[0]
    expected = first.first_tick
    for part in parts:
        if part.layout != first.layout or part.time_step_s != first.time_step_s:
            raise ShapeError("frames of different layouts or rates cannot be put together")
        if part.first_tick != expected:
            raise ShapeError(f"frames start at tick {part.first_tick}; tick {expected} is next")
        expected += part.tick_count
    if len(parts) == 1:
        return first
    return replace(
        first,
        segment_sigma_rad=_together(
            [part.segment_sigma_rad for part in parts], parts, len(first.layout.segments)
        ),
        point_sigma_m=_together([part.point_sigma_m for part in parts], parts, len(first.layout.points)),
        q_room_segment=np.concatenate([part.q_room_segment for part in parts]),
        point_room_m=np.concatenate([part.point_room_m for part in parts]),
        angle_rad=np.concatenate([part.angle_rad for part in parts]),
        angle_sigma_rad=np.concatenate([part.angle_sigma_rad for part in parts]),
        scalar=np.concatenate([part.scalar for part in parts]),
        segment_flags=np.concatenate([part.segment_flags for part in parts]),
        angle_flags=np.concatenate([part.angle_flags for part in parts]),
        slipped=_slipped_together(parts),
    )


def _slipped_together(parts: Sequence[Frames]) -> NDArray[np.bool_] | None:
    if all(part.slipped is None for part in parts):
        return None
    return np.concatenate([np.concatenate(part.slipped_parts, axis=1) for part in parts])


def _together(sigmas: Sequence[Float | None], parts: Sequence[Frames], columns: int) -> Float | None:
    """Put sigmas together; parts that have none (not calibrated yet) give NaN."""
    if all(sigma is None for sigma in sigmas):
        return None
    return np.concatenate(
        [
            np.full((part.tick_count, columns, 3), np.nan) if sigma is None else sigma
            for sigma, part in zip(sigmas, parts, strict=True)
        ]
    )


def run(
    recording: Recording,
    setup: SessionSetup,
    pose_s: tuple[float, float] | None = None,
    *,
    elbows_from_movement: bool = False,
) -> tuple[Frames, SessionSetup]:
    """Estimate a whole recording off-line.

    Parameters
    ----------
    recording : Recording
        Must hold every placement of the setup; further sensors are left out.
    pose_s : (float, float), optional
        Half-open stretch of the recording in which the patient held the calibration pose. Without it the
        first 3 s in which all sensors are still are taken for the pose, as people begin with it.
    elbows_from_movement : bool
        After a pose found here: let the elbows of the whole recording tell how sensors without a compass face,
        and bound their drift; see `refine_elbows`.

    Returns
    -------
    frames : Frames
        From the first tick to the last.
    setup : SessionSetup
        With the calibration used, to be stored.

    Raises
    ------
    SetupError
        If a placement is not in the recording.
    CalibrationError
        If the setup has no calibration and no usable pose is found.

    Notes
    -----
    The calibration found is applied to the whole recording from its start, also to what came before the
    pose: a second pass, as off-line nothing is in a hurry. Where the setup names an off-line smoother
    (`orientation.smoothers()`), the orientation of every sensor is found from the whole recording first.

    Where joints then bend as no joint can, another direction of the patient is taken, or what the sensors in doubt
    give is flagged; see `judge_worn`.

    Where a sensor of an arm or the trunk turned in its strap, what depends on it is flagged and its sigma holds the
    turn from there on; `SlipSearch` says which and when.
    """
    missing = [name for name in setup.placements if name not in recording.sensors]
    if missing:
        raise SetupError(say("setup.missing_sensors", missing=missing, worn=list(recording.sensors)))
    if setup.pipeline == GaitPipeline.name:
        return analyse_walk(recording, setup).frames, setup
    worn = replace(recording, sensors={name: recording.sensors[name] for name in setup.placements})
    chunk = smoothed_chunk(signals.to_common_ticks(worn, setup.rate_hz), setup)
    is_mounted = setup.calibration is not None and bool(setup.calibration.q_sensor_segment)
    needs_no_pose = setup.pipeline == OrientationPipeline.name and pose_s is None
    if is_mounted or needs_no_pose or setup.pipeline == RelativePosePipeline.name:
        return _watched(step_through(create(setup), chunk), chunk, setup), setup
    first, stop = find_pose(chunk) if pose_s is None else _ticks_of(chunk, pose_s)
    setup = _calibrated(chunk, setup, first, stop)
    frames = step_through(create(setup), chunk)
    if elbows_from_movement:
        middle_s = (chunk.first_tick + 0.5 * (first + stop)) * chunk.time_step_s
        refined = refine_elbows(elbow_poses(frames), setup, middle_s)
        if refined is not setup:
            frames = step_through(create(refined), chunk)
        setup = refined
    from_s = (chunk.first_tick + stop) * chunk.time_step_s
    if setup.pipeline == ArmPipeline.name:
        judged = judge_worn(elbow_poses(frames), setup, from_s)
        if judged is not setup:
            setup, frames = judged, step_through(create(judged), chunk)
    return _watched(frames, chunk, setup, from_s), setup


def _watched(frames: Frames, chunk: ImuChunk, setup: SessionSetup, from_s: float = 0.0) -> Frames:
    """Return frames that say where a sensor of an arm has turned in its strap."""
    if setup.pipeline != ArmPipeline.name:
        return frames
    return with_slips(frames, setup, find_slips([frames], [chunk], setup, from_s))


def step_through(pipeline: Pipeline, chunk: ImuChunk) -> Frames:
    """Run a pipeline over a long chunk in blocks."""
    ticks = range(0, max(chunk.tick_count, 1), _BLOCK)
    return concatenate([pipeline.step(chunk.ticks(i, min(i + _BLOCK, chunk.tick_count))) for i in ticks])


def _calibrated(chunk: ImuChunk, setup: SessionSetup, first: int, stop: int) -> SessionSetup:
    """Run up to the end of the pose and calibrate there."""
    pipeline = create(setup)
    step_through(pipeline, chunk.ticks(0, stop))
    method = "static" if setup.pipeline == OrientationPipeline.name else "n_pose"
    pipeline.calibrate(chunk.ticks(first, stop), method)
    return pipeline.setup


def _ticks_of(chunk: ImuChunk, pose_s: tuple[float, float]) -> tuple[int, int]:
    first, stop = (round(bound / chunk.time_step_s) - chunk.first_tick for bound in pose_s)
    first, stop = max(first, 0), min(stop, chunk.tick_count)
    if (stop - first) * chunk.time_step_s < 0.5:
        raise CalibrationError(say("calibration.pose_outside", start_s=pose_s[0], stop_s=pose_s[1]))
    return first, stop


def find_pose(chunk: ImuChunk) -> tuple[int, int]:
    """Return the first ticks `[start, stop)` in which every sensor is still, at most 3 s, within the chunk.

    Raises
    ------
    CalibrationError
        If there is no still stretch of 1.5 s.
    """
    still = signals.stillness(chunk.gyroscope_radps, chunk.accelerometer_mps2, 1.0 / chunk.time_step_s)
    together = np.concatenate([[False], still.all(axis=0), [False]])
    edges = np.flatnonzero(np.diff(together.astype(np.int8)))
    needed = {length: round(length / chunk.time_step_s) for length in (_POSE_S, _SHORTEST_POSE_S)}
    for length in needed.values():
        for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if stop - start >= length:
                return start, min(stop, start + needed[_POSE_S])
    raise CalibrationError(say("calibration.no_rest_found"))
