"""Whether a foot trembles while it stands, as in clonus."""

import numpy as np
import scipy

from estimators.gait.foot.trajectory import FootTrajectory
from estimators.recording import Float

_SLOW_S = 0.1
"""What is slower than about 2 Hz, as rolling over the foot, is taken out."""
_LEAST_RADPS, _HALF_CYCLE_S = 0.15, (1.0 / 20.0, 1.0 / 6.5)
_IN_A_ROW, _SHARE = 2, 0.6
_AFTER_S, _BEFORE_S, _STANDING_S = 0.05, 0.2, 1.2
_LEAST_SAMPLES = 10


def trembles(trajectory: FootTrajectory, rate_radps: Float, toe_off_s: Float, contact_s: Float) -> bool:
    """Say whether a foot trembles in most of its stances.

    Parameters
    ----------
    rate_radps : ndarray, shape (N, 3)
        Angular rate in the world.
    toe_off_s, contact_s : ndarray, shape (n,)
        Of the strides.

    Notes
    -----
    Own. A stance trembles where its turning goes to and fro in two half cycles of 3 to 10 Hz one after the other, each
    beyond 0.15 rad/s. Clonus of the ankle beats at 5 to 8 Hz (Hidler, Rymer. A simulation study of reflex instability
    in spasticity. IEEE Trans Rehabil Eng 7 (1999) 327-340). Of the walks and runs at hand at most 39 % of the stances
    of a foot do so, also of a patient with multiple sclerosis; of simulated clonus of 3 degrees all.
    """
    if not len(toe_off_s):
        return False
    time = trajectory.time_s
    width = _SLOW_S / float(np.median(np.diff(time)))
    quick = rate_radps - scipy.ndimage.gaussian_filter1d(rate_radps, width, axis=0)
    spans = [
        (toe_off_s[0] - _STANDING_S - _BEFORE_S, toe_off_s[0] - _BEFORE_S),
        *zip(contact_s[:-1] + _AFTER_S, toe_off_s[1:] - _BEFORE_S, strict=True),
        (contact_s[-1] + _BEFORE_S, contact_s[-1] + _STANDING_S + _BEFORE_S),
    ]
    found = []
    for start_s, stop_s in spans:
        first, stop = np.searchsorted(time, (start_s, min(stop_s, start_s + _STANDING_S)))
        if stop - first >= _LEAST_SAMPLES:
            found.append(_half_cycles(time[first:stop], quick[first:stop]) >= _IN_A_ROW)
    return bool(found) and float(np.mean(found)) >= _SHARE


def _half_cycles(time_s: Float, rate_radps: Float) -> int:
    """Return how many half cycles of trembling follow each other, about the axis that turns most."""
    centred = rate_radps - rate_radps.mean(axis=0)
    turning = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    edges = np.flatnonzero(np.diff(np.sign(turning))) + 1
    most = row = 0
    for first, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        lasted_s = float(time_s[stop] - time_s[first])
        is_beat = _HALF_CYCLE_S[0] < lasted_s < _HALF_CYCLE_S[1]
        is_beat = is_beat and float(np.abs(turning[first:stop]).max()) > _LEAST_RADPS
        row = row + 1 if is_beat else 0
        most = max(most, row)
    return most
