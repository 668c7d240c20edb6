"""From the voltages of a load cell to forces and moments, and its zero found again in every swing."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float
from estimators.sentences import say

_LEAST_SHARE = 0.25
"""A toe that drags loads the forefoot for half a swing, rarely longer."""
_LEAST_SWING_S = 0.5
_LARGEST_CONDITION = 1e6
_LEAST_LOADS = 12


@dataclass(frozen=True)
class LoadCellCalibration:
    """Load = `matrix` (output - `offset`).

    Attributes
    ----------
    matrix : ndarray, shape (6, 6)
        Rows force x, y, z in N and moment x, y, z in Nm; columns the cell's outputs, volts say.
    offset : ndarray, shape (6,)
        Output without load.
    residual : ndarray, shape (6,)
        Root mean square of what the fit leaves, N and Nm; zero for a maker's matrix.
    """

    matrix: Float
    offset: Float
    residual: Float

    def apply(self, output: Float) -> Float:
        """Return loads, shape (N, 6), of outputs, shape (N, 6)."""
        if output.ndim != 2 or output.shape[1] != 6:
            raise ShapeError(f"a load cell has six outputs a sample; got shape {output.shape}")
        return np.asarray((output - self.offset) @ self.matrix.T)


def calibrate_load_cell(output: Float, load: Float) -> LoadCellCalibration:
    """Find the matrix of a load cell from known loads.

    Parameters
    ----------
    output : ndarray, shape (N, 6)
        Means of the outputs while each load rested, at least 12 of them.
    load : ndarray, shape (N, 6)
        Force in N and moment in Nm about the centre of the cell, in its axes; include no load at all.

    Raises
    ------
    ShapeError
        If the two tables do not match or hold values that are not finite.
    CalibrationError
        If the loads do not tell the six channels apart; the message says what to add.

    Notes
    -----
    Static calibration as used for the shoes of Schepers (2009) chapter 4: least squares of
    `load = C output + c`.
    """
    if output.shape != load.shape or output.ndim != 2 or output.shape[1] != 6:
        raise ShapeError(f"outputs {output.shape} and loads {load.shape} must both have shape (N, 6)")
    if not (np.isfinite(output).all() and np.isfinite(load).all()):
        raise ShapeError("outputs and loads must be finite; leave out what was not measured")
    if output.shape[0] < _LEAST_LOADS:
        raise CalibrationError(say("shoes.few_loads", loads=output.shape[0], least=_LEAST_LOADS))
    scale = np.maximum(np.ptp(output, axis=0), np.finfo(np.float64).tiny)
    design = np.column_stack(((output - output.mean(axis=0)) / scale, np.ones(output.shape[0])))
    if np.linalg.cond(design) > _LARGEST_CONDITION:
        raise CalibrationError(say("shoes.loads_alike"))
    solution, *_ = np.linalg.lstsq(design, load, rcond=None)
    matrix = solution[:-1].T / scale
    constant = solution[-1] - matrix @ output.mean(axis=0)
    residual = load - design @ solution
    return LoadCellCalibration(
        np.ascontiguousarray(matrix),
        -np.linalg.solve(matrix, constant),
        np.sqrt(np.mean(residual**2, axis=0)),
    )


def unloaded(
    force_n: Float, limit_n: float = 10.0, is_swinging: NDArray[np.bool_] | None = None
) -> NDArray[np.bool_]:
    """Return in which samples, shape (N,), a load cell carries nothing.

    Parameters
    ----------
    force_n : ndarray, shape (N, 3)
        A zero that is off by less than the limit does no harm.
    limit_n : float
        Of the length of the force, after a median over five samples.
    is_swinging : ndarray of bool, shape (N,), optional
        Where the shoe turns fast. When more of these samples are near their own median than near zero, the cell's zero
        is off, by that median. Without, a zero that is off by more than the limit is not seen.
    """
    found = _within(force_n, limit_n)
    if is_swinging is None or not is_swinging.any():
        return found
    moved = _within(force_n - np.median(force_n[is_swinging], axis=0), limit_n)
    return moved if np.mean(moved[is_swinging]) > np.mean(found[is_swinging]) else found


def _within(force_n: Float, limit_n: float) -> NDArray[np.bool_]:
    size = scipy.ndimage.median_filter(np.linalg.norm(force_n, axis=1), size=5, mode="nearest")
    return np.asarray(size < limit_n)


def is_tareable(is_unloaded: NDArray[np.bool_], is_swinging: NDArray[np.bool_], rate_hz: float) -> bool:
    """Return whether a cell's zero can be determined: the shoe never swings, or the cell carries nothing when it does.

    Parameters
    ----------
    is_unloaded, is_swinging : ndarray of bool, shape (N,)
    """
    if is_swinging.sum() < _LEAST_SWING_S * rate_hz:
        return True
    return float(np.mean(is_unloaded[is_swinging])) >= _LEAST_SHARE


def clipped_at(force_n: Float, least_n: float, count: int = 5) -> float | None:
    """Return the level at which a channel stands still, as a saturated load cell does; None where none does.

    Parameters
    ----------
    force_n : ndarray, shape (N, 3)
        As it was sent, before any filter.
    least_n : float
        Lower levels are no saturation but rest.
    count : int
        So many equal samples one after the other at the channel's extreme.
    """
    for channel in force_n.T:
        level = float(np.abs(channel).max())
        if level < least_n:
            continue
        at_level = np.abs(channel) >= level * (1.0 - 1e-6)
        edges = np.flatnonzero(np.diff(np.concatenate(([0], at_level.astype(np.int8), [0])))).reshape(-1, 2)
        if (edges[:, 1] - edges[:, 0]).max() >= count:
            return level
    return None


def tare(
    load: Float,
    is_unloaded: NDArray[np.bool_],
    rate_hz: float,
    *,
    guard_s: float = 0.04,
    least_s: float = 0.1,
) -> Float:
    """Take out the zero of a load cell, found again in every swing.

    Parameters
    ----------
    load : ndarray, shape (N, 6)
    is_unloaded : ndarray of bool, shape (N,)
        From `unloaded`, of this cell.
    guard_s : float
        Left out at both ends of a swing, where the shoe still touches.
    least_s : float
        The shortest stretch that is used, after that.

    Returns
    -------
    ndarray, shape (N, 6)
        Loads less the zero: the mean of each swing, linear between swings and held before and after them,
        so that a drifting zero is followed. Unchanged when the cell was never unloaded.
    """
    guard, least = round(guard_s * rate_hz), max(1, round(least_s * rate_hz))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], is_unloaded.astype(np.int8), [0]))))
    middles, zeros = [], []
    for start, end in edges.reshape(-1, 2):
        inner = slice(start + guard if start else 0, end - guard if end < load.shape[0] else end)
        if inner.stop - inner.start >= least:
            middles.append(0.5 * (inner.start + inner.stop - 1))
            zeros.append(load[inner].mean(axis=0))
    if not middles:
        return load.copy()
    at = np.arange(load.shape[0], dtype=np.float64)
    table = np.array(zeros)
    zero = np.column_stack([np.interp(at, middles, table[:, channel]) for channel in range(6)])
    return np.asarray(load - zero)
