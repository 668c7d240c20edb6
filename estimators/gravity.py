"""Gravity in the readings of an accelerometer, whatever its unit."""

import numpy as np

from estimators.recording import Float

_CALM_S, _CALM_SHARE = 0.2, 0.1


def calm_size(force: Float, time_step_s: float) -> float:
    """Return the size of specific force where it changes least: gravity, in the unit of the readings.

    Parameters
    ----------
    force : ndarray, shape (N, 3)
        NaN where a sample is missing.

    Returns
    -------
    float
        Median over the calmest tenth of pieces of 0.2 s, or over all samples when no piece is whole; NaN without any.
        In a run the median over all samples is twice gravity, but every foot stands between its swings.
    """
    sizes = np.linalg.norm(force, axis=1)
    width = max(2, round(_CALM_S / time_step_s))
    parts = len(force) // width
    pieces = force[: parts * width].reshape(parts, width, 3)
    whole = np.isfinite(pieces).all(axis=(1, 2))
    if not whole.any():
        sizes = sizes[np.isfinite(sizes)]
        return float(np.median(sizes)) if len(sizes) else float("nan")
    spread = np.linalg.norm(pieces.std(axis=1), axis=1)
    calm = whole & (spread <= np.quantile(spread[whole], _CALM_SHARE))
    return float(np.median(sizes[: parts * width].reshape(parts, width)[calm]))
