"""Gaps of markers: report, and splines for comparison."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.errors import ShapeError
from estimators.optical._contract import OpticalResult, Provenance
from estimators.recording import Float

_ANCHORS = 10
WITHHELD_M = 0.010
"""Frames whose two-sigma position is worse are withheld (method page 2.7)."""


@dataclass(frozen=True)
class Gap:
    """Ticks `[start, stop)` without a marker, its length, and the largest position sigma within."""

    start: int
    stop: int
    length_s: float
    sigma_m: float
    withheld: bool


def gap_report(result: OpticalResult, time_step_s: float) -> list[Gap]:
    """List the gaps that were filled, with their uncertainty."""
    empty = np.isin(result.provenance, (Provenance.FILLED, Provenance.REJECTED))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], empty.astype(np.int8), [0]])))
    found = []
    for start, stop in edges.reshape(-1, 2).tolist():
        sigma = float(np.max(result.position_sigma_m[start:stop]))
        found.append(Gap(start, stop, (stop - start) * time_step_s, sigma, 2.0 * sigma > WITHHELD_M))
    return found


def fill_by_spline(marker_m: ArrayLike, time_step_s: float) -> Float:
    """Fill inner gaps by quintics that meet position, velocity and acceleration at both ends (page 2.6).

    The boundary values are local quadratic fits to ten samples on each side. For comparison, and for gaps below
    0.05 s; longer ones need the inertial module.
    """
    marker = np.array(marker_m, dtype=np.float64)
    if marker.ndim != 2 or marker.shape[1] != 3:
        raise ShapeError(f"markers need shape (N, 3), not {marker.shape}")
    missing: NDArray[np.bool_] = np.asarray(~np.isfinite(marker).all(axis=1))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], missing.astype(np.int8), [0]]))).reshape(-1, 2)
    filled = marker.copy()
    for start, stop in edges.tolist():
        before = np.arange(max(0, start - _ANCHORS), start)
        after = np.arange(stop, min(len(marker), stop + _ANCHORS))
        if len(before) < 3 or len(after) < 3 or missing[before].any() or missing[after].any():
            continue
        length = (stop - start + 1) * time_step_s
        ends = []
        for rows, origin in ((before, start - 1), (after, stop)):
            t = (rows - origin) * time_step_s
            fit = np.polynomial.polynomial.polyfit(t, marker[rows], 2)
            ends.append((fit[0], fit[1], 2.0 * fit[2]))
        (p0, v0, a0), (p1, v1, a1) = ends
        s = (np.arange(start, stop) - (start - 1))[:, None] * time_step_s / length
        v0, v1, a0, a1 = v0 * length, v1 * length, a0 * length**2, a1 * length**2
        filled[start:stop] = (
            p0
            + v0 * s
            + 0.5 * a0 * s**2
            + (10 * (p1 - p0) - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1) * s**3
            + (-15 * (p1 - p0) + 8 * v0 + 7 * v1 + 1.5 * a0 - a1) * s**4
            + (6 * (p1 - p0) - 3 * (v0 + v1) - 0.5 * (a0 - a1)) * s**5
        )
    return filled
