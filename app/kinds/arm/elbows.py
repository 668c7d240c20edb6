"""Arms without compasses: the elbows of a stored session tell how their sensors were put on."""

from collections.abc import Iterable
from dataclasses import replace

from estimators import pipelines
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk


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
    if pipelines.elbows_to_refine(setup):
        pipeline = pipelines.create(replace(setup, constrain_joint_headings=False))
        parts = [part for piece in pieces if (part := pipelines.elbow_poses(pipeline.step(piece))).tick_count]
        if parts:
            middle_s = 0.5 * (pose_s[0] + pose_s[1])
            setup = pipelines.refine_elbows(pipelines.concatenate(parts), setup, middle_s)
    return setup
