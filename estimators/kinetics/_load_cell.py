"""From the voltages of a load cell to forces and moments, and its zero found again in every swing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float

_LARGEST_CONDITION = 1e6


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

    Returns
    -------
    LoadCellCalibration

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
    if output.shape[0] < 12:
        raise CalibrationError(f"{output.shape[0]} loads are too few; use at least 12, in all directions")
    scale = np.maximum(np.ptp(output, axis=0), np.finfo(np.float64).tiny)
    design = np.column_stack(((output - output.mean(axis=0)) / scale, np.ones(output.shape[0])))
    if np.linalg.cond(design) > _LARGEST_CONDITION:
        raise CalibrationError(
            "the loads do not tell the channels apart; push along x, y and z, both ways and off the centre"
        )
    solution, *_ = np.linalg.lstsq(design, load, rcond=None)
    matrix = solution[:6].T / scale
    constant = solution[6] - matrix @ output.mean(axis=0)
    residual = load - design @ solution
    return LoadCellCalibration(
        np.ascontiguousarray(matrix),
        -np.linalg.solve(matrix, constant),
        np.sqrt(np.mean(residual**2, axis=0)),
    )


def unloaded(force_n: Float, limit_n: float = 10.0) -> NDArray[np.bool_]:
    """Return in which samples, shape (N,), a load cell carries nothing.

    Parameters
    ----------
    force_n : ndarray, shape (N, 3)
        A zero that is off by less than the limit does no harm.
    limit_n : float
        Of the length of the force, after a median over five samples.
    """
    size = median_filter(np.linalg.norm(force_n, axis=1), size=5, mode="nearest")
    return np.asarray(size < limit_n)


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
    rate_hz : float
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


__all__ = ["LoadCellCalibration", "calibrate_load_cell", "tare", "unloaded"]
