"""Heading from movement, and what only looks like movement (Roetenberg 2006, 4.5; method page V8)."""

import numpy as np

from estimators._kernels import step
from estimators.optical import _layout as at
from estimators.recording import Float

_T, _FORCE = at.TIME_STEP, at.FORCE_SIGMA
_EP, _EV, _ET = at.E_POSITION, at.E_VELOCITY, at.E_ATTITUDE
_DOUBT = 16.0
"""Four sigma, squared."""


@step("void(float64[:, ::1], float64[:, ::1], float64[::1])")
def doubt_heading(phi: Float, p: Float, settings: Float) -> None:
    """Weaken the way from a heading to velocity and position in a transition, where nothing may have moved.

    A heading shows by level acceleration only. At rest an estimate of it is never zero: the noise of the force, and
    what tilt and bias of the force are not known yet, look like movement, and the heading would become better known
    (a wrongly observable direction). What lies within four sigma of both, by the covariance `p` before the step, tells
    no heading.
    """
    t = settings[_T]
    along = np.empty(2)
    for i in range(2):
        along[i] = phi[_EV + i, _ET + 2] / t
    level = along[0] * along[0] + along[1] * along[1]
    # Columns of tilt and of the bias of the force, which follow each other but for the heading and the gyroscope.
    variance = 0.0
    columns = (_ET, _ET + 1, at.E_FORCE, at.E_FORCE + 1, at.E_FORCE + 2)
    for i in range(2):
        for j in columns:
            for k in columns:
                variance += phi[_EV + i, j] * p[j, k] * phi[_EV + i, k] / (t * t)
    doubt = _DOUBT * (settings[_FORCE] ** 2 + 0.5 * variance)
    trust = max(0.0, 1.0 - doubt / level) if level > 0.0 else 0.0
    for i in range(2):
        phi[_EV + i, _ET + 2] *= trust
        phi[_EP + i, _ET + 2] *= trust
