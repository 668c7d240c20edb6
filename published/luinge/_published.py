"""Luinge and Veltink's filter in its published structure, signs and dimensions corrected (A4), compiled.

For parity with earlier work: the error lives in the sensor frame without being turned with it (E-5),
only the diagonal blocks of the covariance are carried (E-6), and the predicted acceleration is taken for
independent of the orientation (E-7). The consistent form is in `_consistent`.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3, kernel, multiply, rotate_back
from estimators.kernels import Record, invert_symmetric, skew, step, turn
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import (
    BEGIN,
    FILTER,
    HOLD,
    SAMPLE,
    UNKNOWN,
    Estimates,
    Ticks,
    begin,
    force_without_acceleration,
    keep_acceleration,
    prepare,
    run_signature,
    store,
    store_details,
)
from estimators.recording import Float
from published._error_state import turn_by_rate
from published.luinge._consistent import SETTINGS, STATE

_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)


@step()
def predict_blocks(p: Float, sample: Record, c: Record) -> None:
    """Block covariances of A4.5, from the diagonal blocks of the last step alone."""
    noise = c.rate_variance * c.step_s * c.step_s + sample.gap_variance
    for i in range(3):
        for j in range(3):
            offset = p[3 + i, 3 + j]
            p[i, j] += c.step_s * c.step_s * offset
            p[i, 3 + j] = p[3 + j, i] = -c.step_s * offset
    for i in range(3):
        p[i, i] += noise
        p[3 + i, 3 + i] += c.bias_variance


@step()
def keep_spread(x: Record, p: Float, c: Record, cross: Float) -> None:
    """Keep Q_a = g^2 [Z x] Q_theta [Z x]' + sigma_A^2 I of the acceleration just measured (A4.9)."""
    vx, vy, vz = rotate_back(x.q[0], x.q[1], x.q[2], x.q[3], 0.0, 0.0, c.gravity)
    skew(vx, vy, vz, cross)
    column = 0
    for i in range(3):
        for j in range(i, 3):
            total = c.force_variance if i == j else 0.0
            for a in range(3):
                for b in range(3):
                    total += cross[i, a] * p[a, b] * cross[j, b]
            x.spread[column] = total
            column += 1


_SPARE, _ROWS, _COVARIANCE, _INVERSE, _ERROR, _ROOMS = range(6)
"""Matrices that a correction works in."""


@step()
def take_out(x: Record, p: Float, gain: Float, inverse: Float, innovation: Scalars3, error: Float) -> None:
    """Correct estimate and covariance by an innovation with `gain` = P C' and the inverse of its covariance."""
    for a in range(6):
        total = 0.0
        for i in range(3):
            for j in range(3):
                total += gain[a, i] * inverse[i, j] * innovation[j]
        error[a // 3, a % 3] = total
        for b in range(a, 6):
            total = 0.0
            for i in range(3):
                for j in range(3):
                    total += gain[a, i] * inverse[i, j] * gain[b, j]
            p[a, b] -= total
            p[b, a] = p[a, b]
    tw, tx, ty, tz = turn(-error[0, 0], -error[0, 1], -error[0, 2])
    x.q[0], x.q[1], x.q[2], x.q[3] = multiply(x.q[0], x.q[1], x.q[2], x.q[3], tw, tx, ty, tz)
    for axis in range(3):
        x.bias[axis] -= error[1, axis]


@step()
def correct(x: Record, p: Float, sample: Record, c: Record, work: Float, gain: Float) -> None:
    """Difference the two verticals in the sensor frame and take out the errors (A4.2 to A4.9)."""
    rows, innovation_covariance, inverse = work[_ROWS], work[_COVARIANCE], work[_INVERSE]
    qw, qx, qy, qz = x.q[0], x.q[1], x.q[2], x.q[3]
    ex, ey, ez = force_without_acceleration(x, sample, c)
    ux, uy, uz = rotate_back(qw, qx, qy, qz, ex, ey, ez)
    scale = 1.0 / (ux * ux + uy * uy + uz * uz) ** 0.5
    vx, vy, vz = rotate_back(qw, qx, qy, qz, 0.0, 0.0, 1.0)
    innovation = (ux * scale - vx, uy * scale - vy, uz * scale - vz)
    # C = -[(Z + a/g) x]; predicted acceleration in the sensor frame is what was taken from the force.
    skew(
        -(vx + (sample.force[0] - ux) / c.gravity),
        -(vy + (sample.force[1] - uy) / c.gravity),
        -(vz + (sample.force[2] - uz) / c.gravity),
        rows,
    )
    for i in range(3):
        for j in range(6):
            gain[j, i] = rows[i, 0] * p[0, j] + rows[i, 1] * p[1, j] + rows[i, 2] * p[2, j]
    # S = C P C' + (c_a^2 Q_a + (sigma_w^2 + sigma_A^2) I) / g^2
    white = (c.change_variance + c.force_variance) / c.gravity**2
    column = 0
    for i in range(3):
        for j in range(i, 3):
            value = gain[0, i] * rows[j, 0] + gain[1, i] * rows[j, 1] + gain[2, i] * rows[j, 2]
            value += c.acceleration_gain * c.acceleration_gain * x.spread[column] / c.gravity**2
            if i == j:
                value += white
            innovation_covariance[i, j] = innovation_covariance[j, i] = value
            column += 1
    invert_symmetric(innovation_covariance, inverse)
    for i in range(3):
        sample.innovation[i], sample.inverse[i] = innovation[i], 1.0 / innovation_covariance[i, i]
    take_out(x, p, gain, inverse, innovation, work[_ERROR])
    keep_acceleration(x, sample, c)
    keep_spread(x, p, c, work[_SPARE])


@step("float64(float64[:, ::1], UniTuple(float64, 3))")
def quadratic(p: Float, v: Scalars3) -> float:
    """Return v' P v over the attitude block."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += v[i] * p[i, j] * v[j]
    return total


@step()
def variances(x: Record, p: Float) -> Scalars3:
    """Return the variances of the orientation error about the earth axes, the diagonal of R P R'.

    As the error is not turned with the sensor, its covariance takes tilt for heading and claims to know where
    the sensor faces: that is unknown.
    """
    w, qx, y, z = x.q[0], x.q[1], x.q[2], x.q[3]
    # The earth axes in the sensor frame are the rows of R.
    east = quadratic(p, rotate_back(w, qx, y, z, 1.0, 0.0, 0.0))
    return east, quadratic(p, rotate_back(w, qx, y, z, 0.0, 1.0, 0.0)), UNKNOWN


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks, settings: NDArray[np.void], state: NDArray[np.void], covariance: Float, out: Estimates
) -> None:
    """Filter K ticks of S sensors; `state` and `covariance` (S, 6, 6, sensor frame) are carried on."""
    samples, work, gain = np.zeros(1, SAMPLE), np.zeros((_ROOMS, 3, 3)), np.zeros((6, 3))
    sample, c, quality = samples[0], settings[0], ticks.quality
    for s in range(quality.shape[0]):
        x, p = state[s], covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(ticks, s, k, x, c, sample)
            if action == BEGIN:
                begin(x, p, c)
                # This covariance is in the sensor frame.
                p[2, 2] = p[0, 0]
                for column in range(6):
                    x.spread[column] = c.force_variance if column == 0 or column == 3 or column == 5 else 0.0
            elif action != HOLD:
                turn_by_rate(x, sample.rate[0], sample.rate[1], sample.rate[2], c.step_s)
                predict_blocks(p, sample, c)
                if action == FILTER:
                    correct(x, p, sample, c, work, gain)
            store(out, s, k, x, variances(x, p), quality[s, k], action, _NO_HEADING, sample, c)
            if out.details.shape[0] > 0:
                store_details(out, s, k, 3, action, x, sample)
