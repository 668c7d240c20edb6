"""When heel and forefoot touch the ground, from their forces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.recording import Float

Bool = NDArray[np.bool_]


@dataclass(frozen=True)
class ContactParameters:
    """Thresholds of contact; the source gives none, these are the house's.

    Attributes
    ----------
    on_n, off_n : float
        Vertical force at which contact begins, and below which it ends.
    debounce_s : float
        Shorter states are taken for the one around them.
    flat_s : float
        Heel and forefoot together for at least so long are a foot that lies flat.
    core_share : float
        Middle part of a flat stretch that counts as at rest.
    """

    on_n: float = 20.0
    off_n: float = 10.0
    debounce_s: float = 0.04
    flat_s: float = 0.12
    core_share: float = 0.5


@dataclass(frozen=True)
class ShoeContact:
    """Contact of one shoe over N samples.

    Attributes
    ----------
    heel, forefoot, any : ndarray of bool, shape (N,)
    heel_down, heel_off : ndarray of int
        Samples at which heel contact begins and ends (HD and HO).
    land, lift : ndarray of int
        Samples at which any contact begins and ends.
    flat, core : ndarray of int, shape (M, 2)
        Half-open stretches in which the foot lies flat, and their middles in which it is at rest.
    """

    heel: Bool
    forefoot: Bool
    any: Bool
    heel_down: NDArray[np.int64]
    heel_off: NDArray[np.int64]
    land: NDArray[np.int64]
    lift: NDArray[np.int64]
    flat: NDArray[np.int64]
    core: NDArray[np.int64]


def shoe_contact(
    heel_force_n: Float, forefoot_force_n: Float, rate_hz: float, parameters: ContactParameters | None = None
) -> ShoeContact:
    """Find the contact of one shoe from the vertical forces of heel and forefoot.

    Parameters
    ----------
    heel_force_n, forefoot_force_n : ndarray, shape (N,)
        Tared, upward positive.
    """
    chosen = parameters or ContactParameters()
    least = max(1, round(chosen.debounce_s * rate_hz))
    heel = _with_hysteresis(heel_force_n, chosen, least)
    forefoot = _with_hysteresis(forefoot_force_n, chosen, least)
    touching = heel | forefoot
    heel_down, heel_off = _edges(heel)
    land, lift = _edges(touching)
    both = stretches(heel & forefoot)
    flat = both[(both[:, 1] - both[:, 0]) >= max(2, round(chosen.flat_s * rate_hz))]
    length = flat[:, 1] - flat[:, 0]
    half = np.maximum(1, np.round(0.5 * chosen.core_share * length)).astype(np.int64)
    middle = (flat[:, 0] + flat[:, 1]) // 2
    core = np.column_stack((middle - half, middle + half))
    return ShoeContact(heel, forefoot, touching, heel_down, heel_off, land, lift, flat, core)


def stretches(mask: Bool) -> NDArray[np.int64]:
    """Return the half-open stretches in which a mask, shape (N,), holds; shape (M, 2)."""
    return np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0])))).reshape(-1, 2)


def _with_hysteresis(force_n: Float, parameters: ContactParameters, least: int) -> Bool:
    # The last sample that was decided tells the state of one between the two thresholds.
    decided = np.where(force_n > parameters.on_n, 1, np.where(force_n < parameters.off_n, 0, -1))
    index = np.where(decided >= 0, np.arange(force_n.size), -1)
    held = np.maximum.accumulate(index)
    state = np.where(held >= 0, decided[np.maximum(held, 0)], force_n[:1] > 0.5 * parameters.on_n)
    result = state.astype(np.bool_)
    for value in (False, True):
        for start, end in stretches(result == value):
            if end - start < least and start > 0 and end < force_n.size:
                result[start:end] = not value
    return result


def _edges(mask: Bool) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return where a mask begins and ends within the record; its first and last sample are no events."""
    change = np.diff(mask.astype(np.int8))
    return np.flatnonzero(change > 0) + 1, np.flatnonzero(change < 0) + 1
