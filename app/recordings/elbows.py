"""Arms without compasses: the elbows of a stored session tell how their sensors were put on."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from estimators import pipelines
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import ImuChunk

_RATE_HZ: Final = 10.0
"""What the elbow tells takes so many poses a second; an hour of them is small."""


def with_elbows(setup: SessionSetup, pose_s: tuple[float, float], pieces: Iterable[ImuChunk]) -> SessionSetup:
    """Return the setup with mountings and headings corrected by the elbows of the whole session.

    Parameters
    ----------
    setup : SessionSetup
        Calibrated by a standing pose.
    pose_s : (float, float)
        Half-open session time of that pose.
    pieces : iterable of ImuChunk
        The whole session, as its result will be estimated.

    Returns
    -------
    SessionSetup
        The same where there is nothing to tell; see `estimators.pipelines.refine_elbows`.
    """
    if setup.pipeline != "arm" or not pipelines.elbows_to_refine(setup):
        return setup
    pipeline = pipelines.create(replace(setup, constrain_joint_headings=False))
    stride = max(1, round(setup.rate_hz / _RATE_HZ))
    parts = [part for piece in pieces if (part := _every(pipeline.step(piece), stride)).tick_count]
    if not parts:
        return setup
    return pipelines.refine_elbows(pipelines.concatenate(parts), setup, 0.5 * (pose_s[0] + pose_s[1]))


def _every(frames: Frames, stride: int) -> Frames:
    """Return the ticks that are whole multiples of the stride, so that pieces continue each other."""
    ticks = np.arange(-frames.first_tick % stride, frames.tick_count, stride)
    arrays = (
        "q_room_segment", "point_room_m", "angle_rad", "angle_sigma_rad", "scalar", "segment_flags", "angle_flags",
    )  # fmt: skip
    return replace(
        frames,
        first_tick=-(-frames.first_tick // stride),
        time_step_s=frames.time_step_s * stride,
        segment_sigma_rad=None,
        point_sigma_m=None,
        **{name: getattr(frames, name)[ticks] for name in arrays},
    )


__all__ = ["with_elbows"]
