"""When a foot touches the ground, from the force beneath it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.errors import ShapeError
from estimators.gait._stance import runs
from estimators.recording import Float

Bool = NDArray[np.bool_]

THRESHOLD_N, HYSTERESIS_N, DEBOUNCE_S = 20.0, 10.0, 0.04
FLAT_S, CORE_SHARE = 0.12, 0.5


@dataclass(frozen=True)
class ForceEvents:
    """Contacts of one foot.

    Attributes
    ----------
    heel_down_s, heel_off_s : ndarray, shape (n,)
        Start and end of each contact of the heel.
    contact_s, toe_off_s : ndarray, shape (m,)
        Start and end of each contact of the foot, whatever part of it.
    flat_core_s : ndarray, shape (c, 2)
        Central half of each stretch of at least 0.12 s with heel and forefoot on the ground.
    is_heel, is_forefoot : ndarray of bool, shape (K,)
    """

    heel_down_s: Float
    heel_off_s: Float
    contact_s: Float
    toe_off_s: Float
    flat_core_s: Float
    is_heel: Bool
    is_forefoot: Bool


def force_events(
    heel_force_n: Float,
    forefoot_force_n: Float | None,
    rate_hz: float,
    *,
    threshold_n: float = THRESHOLD_N,
    hysteresis_n: float = HYSTERESIS_N,
    debounce_s: float = DEBOUNCE_S,
) -> ForceEvents:
    """Find heel and forefoot contacts in vertical forces.

    Parameters
    ----------
    heel_force_n, forefoot_force_n : ndarray, shape (K,), or None
        Vertical force of the ground on heel and forefoot; a single sensor below the whole foot is both.
    threshold_n, hysteresis_n : float
        Contact begins above the threshold and ends below threshold less hysteresis.
    debounce_s : float
        Shorter contacts, and shorter losses of contact, are not counted.

    Raises
    ------
    ShapeError
        If the forces are not finite or differ in length.

    Notes
    -----
    Section 2.1 of the page on foot placement; the source gives no numbers, these are that page's.
    """
    fore = heel_force_n if forefoot_force_n is None else forefoot_force_n
    if heel_force_n.ndim != 1 or heel_force_n.shape != fore.shape:
        raise ShapeError(f"forces have shapes {heel_force_n.shape} and {fore.shape}; both must be (K,)")
    if not (np.isfinite(heel_force_n).all() and np.isfinite(fore).all()):
        raise ShapeError("forces must be finite; fill short gaps or cut the recording")
    shortest = max(1, round(debounce_s * rate_hz))
    heel, forefoot = (
        _debounced(_with_hysteresis(force, threshold_n, threshold_n - hysteresis_n), shortest)
        for force in (heel_force_n, fore)
    )
    heel_down, heel_off = _edges(heel, rate_hz)
    contact, toe_off = _edges(np.asarray(heel | forefoot), rate_hz)
    cores = []
    for start, stop in runs(np.asarray(heel & forefoot)):
        if stop - start >= FLAT_S * rate_hz:
            cut = 0.5 * (1.0 - CORE_SHARE) * (stop - start)
            cores.append(((start + cut) / rate_hz, (stop - cut) / rate_hz))
    return ForceEvents(heel_down, heel_off, contact, toe_off, np.array(cores).reshape(-1, 2), heel, forefoot)


def _with_hysteresis(force: Float, on: float, off: float) -> Bool:
    """Return the state of a switch that turns on above one level and off below another."""
    decided = np.where(force > on, 1, np.where(force < off, 0, -1))
    last = np.maximum.accumulate(np.where(decided >= 0, np.arange(len(force)), -1))
    return np.asarray(np.where(last >= 0, decided[np.maximum(last, 0)], 0) == 1)


def _debounced(mask: Bool, shortest: int) -> Bool:
    result = mask.copy()
    for keep in (False, True):
        for start, stop in runs(np.asarray(result == keep)):
            if stop - start < shortest and start > 0 and stop < len(mask):
                result[start:stop] = not keep
    return result


def _edges(mask: Bool, rate_hz: float) -> tuple[Float, Float]:
    """Return starts and ends in s, leaving out those at the ends of the record."""
    change = np.diff(mask.astype(np.int8))
    return (np.flatnonzero(change == 1) + 1) / rate_hz, (np.flatnonzero(change == -1) + 1) / rate_hz
