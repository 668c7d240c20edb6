"""Iron that moves with a sensor, found in a recording in which the sensor turned: an uncalibrated compass."""

from typing import Final

import numpy as np

from estimators.calibration.field.ellipsoid import fit_sphere
from estimators.recording import Float

_EARTH_T: Final = (20e-6, 75e-6)
_MOST_RESIDUAL: Final = 0.05
"""Of the radius: what the field of a room and soft iron add."""
_MOST_SIGMA: Final = 0.1
"""Of the radius, of the centre: so well must the turning show it."""
_POINTS: Final = 400


def device_iron(field_t: Float) -> Float | None:
    """Return the field of iron on a sensor; None where the turning does not show one.

    Parameters
    ----------
    field_t : ndarray, shape (N, 3)
        T; NaN where there is none.

    Returns
    -------
    ndarray, shape (3,), or None
        T, sensor axes. What is left after it is subtracted has the size of the earth's field in all attitudes.

    Notes
    -----
    Seen from a sensor that turns, a constant field lies on a sphere about the iron on it (hard iron). A wrong unit
    lies on a sphere about zero.
    """
    there = field_t[np.isfinite(field_t).all(axis=1)]
    if len(there) < 8:
        return None
    fit = fit_sphere(there[:: max(1, len(there) // _POINTS)])
    radius = 1.0 / float(fit.shape[0, 0])
    sigma = float(np.sqrt(np.linalg.eigvalsh(fit.covariance[:3, :3]).max()))
    is_found = _EARTH_T[0] < radius < _EARTH_T[1] and fit.residual < _MOST_RESIDUAL and sigma < _MOST_SIGMA
    return fit.centre if is_found else None
