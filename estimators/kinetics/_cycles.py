"""Curves over the gait cycle, their peaks, and how far two of them are apart."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.errors import ShapeError
from estimators.recording import Float
from estimators.sentences import say


@dataclass(frozen=True)
class CycleCurves:
    """A signal over every gait cycle, P points from landing to the next landing of the same foot.

    Attributes
    ----------
    cycles : ndarray, shape (C, P) or (C, P, D)
    mean, sd : ndarray, shape (P,) or (P, D)
        Over the cycles; the deviation is NaN for one cycle.
    duration_s : ndarray, shape (C,)
    """

    cycles: Float
    mean: Float
    sd: Float
    duration_s: Float


def over_cycles(values: Float, landings: NDArray[np.int64], rate_hz: float, points: int = 101) -> CycleCurves:
    """Cut a signal into gait cycles and normalise each to 0 to 100 %.

    Parameters
    ----------
    values : ndarray, shape (N,) or (N, D)
    landings : ndarray of int, shape (C + 1,)
        Samples at which the foot lands.

    Raises
    ------
    ShapeError
        For fewer than two landings.
    """
    if len(landings) < 2:
        raise ShapeError(say("shoes.no_cycle"))
    table = values.reshape(len(values), -1)
    at = np.arange(len(values))
    cycles = []
    for start, end in pairwise(landings):
        where = np.linspace(start, end, points)
        cycles.append(np.column_stack([np.interp(where, at, column) for column in table.T]))
    stacked = np.array(cycles).reshape(len(cycles), points, *values.shape[1:])
    spread = stacked.std(axis=0, ddof=1) if len(cycles) > 1 else np.full(stacked.shape[1:], np.nan)
    return CycleCurves(stacked, stacked.mean(axis=0), spread, np.diff(landings) / rate_hz)


@dataclass(frozen=True)
class ForcePeaks:
    """The M of the vertical force over one stance, as parts of body weight; NaN where there is no M.

    Attributes
    ----------
    is_double : bool
        Whether there are two peaks with a valley between; slow and impaired gait may have one.
    """

    loading: float
    valley: float
    push_off: float
    is_double: bool


def force_peaks(vertical_n: Float, weight_n: float, least_depth: float = 0.02) -> ForcePeaks:
    """Return the peaks of the vertical force of one stance, shape (N,).

    Parameters
    ----------
    vertical_n : ndarray, shape (N,)
    least_depth : float
        Of the valley, as a part of body weight, to be more than noise.

    Raises
    ------
    ShapeError
        If there are fewer than five samples.
    """
    if len(vertical_n) < 5:
        raise ShapeError("a stance of fewer than five samples has no shape")
    force = vertical_n / weight_n
    peaks, _ = scipy.signal.find_peaks(force, prominence=least_depth, height=0.5)
    if len(peaks) < 2:
        return ForcePeaks(float(force.max()), float("nan"), float("nan"), False)
    half = len(force) / 2.0
    early, late = peaks[peaks < half], peaks[peaks >= half]
    if not len(early) or not len(late):
        early, late = peaks[:1], peaks[-1:]
    first, last = int(early[np.argmax(force[early])]), int(late[np.argmax(force[late])])
    return ForcePeaks(float(force[first]), float(force[first : last + 1].min()), float(force[last]), True)


def rms_difference(ours: Float, reference: Float) -> tuple[float, float]:
    """Return the root-mean-square difference and that as per cent of the largest reference.

    Parameters
    ----------
    ours, reference : ndarray, shape (N,) or (N, D)
        Of vectors the lengths are compared, as the instrumented-shoe study does; NaN in either is left out.

    Raises
    ------
    ShapeError
        If they differ in shape or share no finite sample.
    """
    if ours.shape != reference.shape:
        raise ShapeError(f"shapes {ours.shape} and {reference.shape} cannot be compared")
    one, two = (np.linalg.norm(part, axis=1) if part.ndim == 2 else part for part in (ours, reference))
    both = np.isfinite(one) & np.isfinite(two)
    if not both.any():
        raise ShapeError("no sample is finite in both")
    difference = float(np.sqrt(np.mean((one[both] - two[both]) ** 2)))
    return difference, 100.0 * difference / float(np.abs(two[both]).max())
