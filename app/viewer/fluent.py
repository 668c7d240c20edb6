"""Pictures between stored frames, for drawing only: a session stored at 25 Hz must not be seen to jerk."""

from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.pipelines import Frames

_LEAST_HZ: Final = 50.0


def fluent(frames: Frames) -> Frames:
    """Return frames with at least 50 ticks a second, those between two on the straight way from one to the other.

    Parameters
    ----------
    frames : Frames
        Of any rate; those that are fast enough come back as they are.

    Returns
    -------
    Frames
        Of the same moments and those between. A flag holds until the next frame; a number next to an unknown one is
        unknown.
    """
    parts = max(1, round(frames.time_step_s * _LEAST_HZ))
    if parts == 1 or frames.tick_count < 2:
        return frames
    quaternions = frames.q_room_segment.copy()
    # q and -q are one orientation; the way between must be the short one.
    turned = np.sum(quaternions[1:] * quaternions[:-1], axis=2) < 0.0
    quaternions[1:][np.cumsum(turned, axis=0) % 2 == 1] *= -1.0
    found: dict[str, Any] = {
        name: _between(value, parts)
        for name, value in vars(frames).items()
        if isinstance(value, np.ndarray) and name != "q_room_segment"
    }
    quaternions = _between(quaternions, parts)
    return replace(
        frames,
        first_tick=frames.first_tick * parts,
        time_step_s=frames.time_step_s / parts,
        q_room_segment=quaternions / np.linalg.norm(quaternions, axis=2, keepdims=True),
        **found,
    )


def _between(values: NDArray[Any], parts: int) -> NDArray[Any]:
    """Return values, shape (K, ...), with those between, shape ((K - 1) parts + 1, ...)."""
    if values.dtype.kind != "f":
        return np.repeat(values, parts, axis=0)[: (len(values) - 1) * parts + 1]
    between = np.empty(((len(values) - 1) * parts + 1, *values.shape[1:]), values.dtype)
    for part in range(parts):
        share = part / parts
        between[part:-1:parts] = values[:-1] if not part else (1 - share) * values[:-1] + share * values[1:]
    between[-1] = values[-1]
    return between
