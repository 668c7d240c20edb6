"""Balance of each whole stride: where the centre of mass goes beside the feet, and what carrying it costs."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from estimators import rotation
from estimators.balance._both_feet import BothFeet
from estimators.balance._walking_work import walking_work
from estimators.balance.mass_centre._published import MassCentre
from estimators.conventions import SIDES, Side
from estimators.kinetics import ShoeContact, ShoeGeometry
from estimators.recording import Float


@dataclass(frozen=True)
class StrideBalance:
    """Of S strides, from landing to landing of the left foot; strides in which the person stands are left out.

    Attributes
    ----------
    parts : tuple of slice, length S
        Samples of each stride.
    aside_m : ndarray, shape (S,)
        Mean of the centre of mass left of the middle between the soles where they stood.
    sway_m : ndarray, shape (S,)
        From its farthest left to its farthest right, about the straight line of the stride.
    work_j_per_kg_m, recovery : ndarray, shape (S,)
        External work of a kilogram and metre, and the part that the pendulum gives back; see `walking_work`.
    """

    parts: tuple[slice, ...]
    aside_m: Float
    sway_m: Float
    work_j_per_kg_m: Float
    recovery: Float


def sole_middle(feet: BothFeet, side: Side) -> Float:
    """Return the middle of a sole, room frame, shape (N, 3)."""
    geometry, pose = ShoeGeometry(), feet.pose[side]
    ahead = 0.5 * (geometry.rear_edge_m + geometry.hinge_m + geometry.toe_edge_m)
    return np.asarray(pose.heel_m + rotation.rotate(pose.q_room_heel, np.array([ahead, 0.0, 0.0])))


def stride_balance(
    feet: BothFeet, contact: Mapping[Side, ShoeContact], centre: MassCentre, mass_kg: float
) -> StrideBalance:
    """Return the balance of every whole stride.

    Parameters
    ----------
    centre : MassCentre
        On the same N samples.
    """
    parts = tuple(
        slice(int(a), int(b))
        for a, b in pairwise(contact["left"].land)
        if not feet.is_standing[int(a) : int(b)].any()
    )
    across = feet.aside(centre.position_m)
    soles = {side: feet.aside(sole_middle(feet, side)) for side in SIDES}
    rests = {side: contact[side].core.mean(axis=1).astype(int) for side in SIDES}
    found = np.zeros((4, len(parts)))
    for number, part in enumerate(parts):
        path = across[part]
        straight = path - np.linspace(path[0], path[-1], len(path))
        stood = [soles[side][_within(rests[side], part)].mean() for side in SIDES]
        work = walking_work(centre.position_m[part], centre.velocity_mps[part], mass_kg)
        found[:, number] = (
            path.mean() - np.mean(stood),
            np.ptp(straight),
            work.external_j_per_m / mass_kg,
            work.recovery,
        )
    return StrideBalance(parts, *found)


def _within(rests: Float, part: slice) -> Float:
    """Return the rests of a foot during a stride; where it has none, the nearest."""
    inside = rests[(rests >= part.start) & (rests < part.stop)]
    return inside if len(inside) else rests[[int(np.argmin(np.abs(rests - part.start)))]]
