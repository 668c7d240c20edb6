"""How well the places of an arm are known: from the orientation of each segment, its mounting within."""

import itertools
from typing import Final

import numpy as np

from estimators.conventions import SIDES
from estimators.pipelines._contract import Frames
from estimators.recording import Float

ARM_POINTS: Final = ("elbow", "wrist", "hand")
"""From the shoulder on; each is carried by the segment above it."""
_CARRIERS: Final = ("upper_arm", "forearm", "hand")


def place_sigma(frames: Frames, segment_sigma_rad: Float) -> Float:
    """Return one standard deviation of each point's place relative to the shoulder of its side.

    Parameters
    ----------
    segment_sigma_rad : ndarray, shape (K, G, 3)
        Of each segment's orientation about the room axes, with what its mounting leaves open.

    Returns
    -------
    ndarray, shape (K, 3 P)
        Along the room axes, m, in the order of the layout's points; NaN for other points than elbow, wrist and hand.

    Notes
    -----
    First order, as in `estimators.arm`: a small turn d of a segment that carries r moves what hangs from it by d x r;
    the segments are taken as independent. A hand without a sensor goes with its forearm.
    """
    layout = frames.layout
    sigma_m = np.full(frames.point_room_m.shape, np.nan)
    for side in SIDES:
        names = [f"{point}_{side}" for point in ("shoulder", *ARM_POINTS)]
        last = next((i for i, name in enumerate(names) if name not in layout.points), len(names))
        places = [frames.point_room_m[:, layout.points.index(name)] for name in names[:last]]
        carried: dict[int, Float] = {}
        for k, (start, end) in enumerate(itertools.pairwise(places)):
            carrier = _carrier(layout.segments, k, side)
            if carrier is None:
                break
            carried[carrier] = carried.get(carrier, np.zeros(3)) + (end - start)
            variance = sum(_turned(r, segment_sigma_rad[:, segment]) for segment, r in carried.items())
            sigma_m[:, layout.points.index(names[k + 1])] = np.sqrt(variance)
    return sigma_m.reshape(len(sigma_m), -1)


def _carrier(segments: tuple[str, ...], link: int, side: str) -> int | None:
    choices = [f"{_CARRIERS[link]}_{side}", *([f"forearm_{side}"] if _CARRIERS[link] == "hand" else [])]
    return next((segments.index(name) for name in choices if name in segments), None)


def _turned(r: Float, sigma_rad: Float) -> Float:
    """Return the variance along each axis of d x r, for d of these standard deviations about the axes, shape (K, 3)."""
    x, y, z = np.moveaxis(r**2, -1, 0)
    about_x, about_y, about_z = np.moveaxis(sigma_rad**2, -1, 0)
    return np.stack(
        [about_y * z + about_z * y, about_z * x + about_x * z, about_x * y + about_y * x], axis=-1
    )
