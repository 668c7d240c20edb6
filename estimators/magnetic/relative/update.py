"""Updates of the relative-pose filter by a pulse of one coil and by the common gravity; compiled."""

import math

import numpy as np

from estimators._kernels import rotate_back, step
from estimators.kernels.attitudes import attitude_matrix
from estimators.kernels.matrices import cholesky, joseph, solve
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.moment import learn_moment
from estimators.magnetic.relative.motion import add_skew, inject
from estimators.magnetic.relative.pulse import predict_path
from estimators.recording import Float

_Q, _ET, _EA, _EG, _EAC = at.ATTITUDE, at.E_ATTITUDE, at.E_FORCE, at.E_RATE, at.E_SOURCE_FORCE
_TIME_STEP, _GAIN_SIGMA, _PASSES, _NIS_SOFT = at.TIME_STEP, at.GAIN_SIGMA, at.PASSES, at.NIS_SOFT
_NIS_STREAK = at.NIS_STREAK
_INCLINATION_SIGMA = at.INCLINATION_SIGMA
_FS, _FC, _LATE = at.S_FORCE, at.S_SOURCE_FORCE, at.PULSE_LATE
_VALUE, _WHITE, _AMBIENT, _TURNING, _LEVER = (
    at.PULSE_VALUE,
    at.PULSE_WHITE,
    at.PULSE_AMBIENT,
    at.PULSE_TURNING,
    at.PULSE_LEVER,
)
_DONE = 1e-7
_SEEN, _CLEAR = 5.42, 25.0
"""Times the noise (all three axes): below the first (99.9 % point) a field is none, above the second it is clear."""
_OFF = 100.0
"""Six sigmas and more from what was expected: that is no estimate too sure of itself, the pulse is another's."""
UNSEEN = -2.0


@step("float64(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64[:, ::1])")
def innovate(p: Float, h: Float, r: Float, innovation: Float, gain: Float) -> float:
    """Write K = P H^T S^-1 and return the normalised innovation squared; minus one if S is not positive."""
    n, m = p.shape[0], h.shape[0]
    s = np.empty((m, m))
    for i in range(n):
        for a in range(m):
            total = 0.0
            for k in range(n):
                if h[a, k] != 0.0:
                    total += p[i, k] * h[a, k]
            gain[i, a] = total
    for a in range(m):
        for b in range(m):
            total = r[a, b]
            for k in range(n):
                if h[a, k] != 0.0:
                    total += h[a, k] * gain[k, b]
            s[a, b] = total
    for a in range(m):
        for b in range(a):
            s[a, b] = s[b, a] = 0.5 * (s[a, b] + s[b, a])
    if not cholesky(s):
        return -1.0
    whitened = innovation.copy()
    solve(s, whitened)
    nis = 0.0
    for a in range(m):
        nis += innovation[a] * whitened[a]
    for i in range(n):
        solve(s, gain[i])
    return nis


@step(
    "float64(float64[:, ::1], float64, float64[::1], float64[:, ::1], float64[::1], float64[::1], float64,"
    "float64[::1], float64[:, ::1], float64[::1], float64[:, ::1])"
)
def update_pulse(
    loops: Float,
    coil: float,
    pulse: Float,
    path: Float,
    rates: Float,
    settings: Float,
    inflation: float,
    nominal: Float,
    p: Float,
    memory: Float,
    work: Float,
) -> float:
    """Correct state and covariance by a pulse (iterated, softly weighted); return its normalised innovation squared.

    Of one above `nis_streak` nobody knows whether the pulse is wrong or what was expected: both are held for equally
    likely, and state and covariance are the mean and the spread of the two. So the state follows halfway, and is as
    uncertain as that makes it until the next pulse. One that is off by far corrects nothing. Returns `UNSEEN`, with
    nothing changed, when a pulse that must be
    clear to see is not there at all: that it is far away would be the wrong conclusion.
    """
    n = p.shape[0]
    h, gain, r = np.zeros((3, n)), np.empty((n, 3)), np.zeros((3, 3))
    value, innovation, right = np.empty(3), np.empty(3), np.empty(3)
    expected, straight, surprise = value, h, innovation
    correction, trial = np.zeros(n), nominal.copy()
    delay = pulse[_LATE] * settings[_TIME_STEP]
    first, is_doubtful = -1.0, False
    field = pulse[_AMBIENT : _AMBIENT + 3]
    ambient = field[0] ** 2 + field[1] ** 2 + field[2] ** 2
    # An error of the gyroscope's offset turns the ambient field that is taken off the pulse.
    add_skew(h, 0, _EG, pulse[_LEVER], field[0], field[1], field[2])
    for number in range(int(settings[_PASSES])):
        predict_path(loops, coil, pulse, path, delay, nominal, trial, rates, value, h)
        if number == 0:
            size = value[0] * value[0] + value[1] * value[1] + value[2] * value[2]
            for i in range(3):
                for j in range(3):
                    r[i, j] = -inflation * pulse[_TURNING] * field[i] * field[j]
                r[i, i] += inflation * (
                    pulse[_WHITE] + pulse[_TURNING] * ambient + settings[_GAIN_SIGMA] ** 2 * size
                )
        for i in range(3):
            innovation[i] = value[i] - pulse[_VALUE + i]
        nis = innovate(p, h, r, innovation, gain)
        if nis < 0.0 or not math.isfinite(nis):
            return -1.0
        if number == 0:
            first = nis
            # Before the correction, so that noise of this pulse is in the innovation alone.
            expected, straight, surprise = value.copy(), h.copy(), innovation.copy()
            # With a noise of its own alone: what the expected field is wrong by is no noise of a field of zero.
            noise = 3.0 * inflation * (pulse[_WHITE] + pulse[_TURNING] * ambient)
            seen = pulse[_VALUE] ** 2 + pulse[_VALUE + 1] ** 2 + pulse[_VALUE + 2] ** 2
            if nis > settings[_NIS_SOFT] and seen < _SEEN * noise and size > _CLEAR * noise:
                return UNSEEN
            if nis > _OFF:
                return first
            is_doubtful = nis > settings[_NIS_STREAK]
            if nis > settings[_NIS_SOFT] and not is_doubtful:
                # R += (NIS / limit - 1) S: an outlier weighs less the farther out it is, but is never shut out.
                share = nis / settings[_NIS_SOFT] - 1.0
                for a in range(3):
                    for b in range(3):
                        total = r[a, b]
                        for k in range(n):
                            if h[a, k] != 0.0:
                                for m in range(n):
                                    total += h[a, k] * p[k, m] * h[b, m]
                        work[a, b] = total
                for a in range(3):
                    for b in range(3):
                        r[a, b] += share * 0.5 * (work[a, b] + work[b, a])
                innovate(p, h, r, innovation, gain)
        largest = 0.0
        for i in range(3):
            right[i] = innovation[i]
            for k in range(_EA):
                right[i] += h[i, k] * correction[k]
        for i in range(n):
            total = gain[i, 0] * right[0] + gain[i, 1] * right[1] + gain[i, 2] * right[2]
            largest = max(largest, abs(total - correction[i]))
            correction[i] = total
        for i in range(trial.shape[0]):
            trial[i] = nominal[i]
        inject(trial, correction)
        if largest < _DONE:
            break
    if is_doubtful:
        # Mean of the hypotheses, and half of either covariance: (P + P+) / 2 = P with half of what is taken off.
        for i in range(n):
            correction[i] *= 0.5
        inject(nominal, correction)
        before = p.copy()
        joseph(p, h, r, gain, work)
        for i in range(n):
            for j in range(n):
                p[i, j] = 0.5 * (p[i, j] + before[i, j]) + correction[i] * correction[j]
        return first
    for i in range(nominal.shape[0]):
        nominal[i] = trial[i]
    learn_moment(p, straight, r, gain, surprise, expected, memory)
    joseph(p, h, r, gain, work)
    return first


@step(
    "void(float64[::1], float64[::1], float64[::1], float64, float64[:, ::1], float64[::1], float64[:, ::1])"
)
def update_inclination(
    nominal: Float, signals: Float, settings: Float, factor: float, p: Float, memory: Float, work: Float
) -> None:
    """Correct by the gravity that both modules see while quasi-static: R^T f_c = f_s (method page 3.9b).

    `factor` scales the variance: accelerations last for longer than the interval between updates, which matters
    once no pulse corrects what that overstates.
    """
    n = p.shape[0]
    h, gain, noise = np.zeros((3, n)), np.empty((n, 3)), np.zeros((3, 3))
    innovation, correction, r = np.empty(3), np.empty(n), np.empty((3, 3))
    attitude_matrix(nominal[_Q : _Q + 4], r)
    seen = rotate_back(
        nominal[_Q],
        nominal[_Q + 1],
        nominal[_Q + 2],
        nominal[_Q + 3],
        signals[_FC],
        signals[_FC + 1],
        signals[_FC + 2],
    )
    for i in range(3):
        innovation[i] = seen[i] - signals[_FS + i]
        noise[i, i] = factor * settings[_INCLINATION_SIGMA] ** 2
        h[i, _EA + i] = -1.0
        for j in range(3):
            h[i, _EAC + j] = r[j, i]
    h[0, _ET + 1], h[0, _ET + 2] = -seen[2], seen[1]
    h[1, _ET], h[1, _ET + 2] = seen[2], -seen[0]
    h[2, _ET], h[2, _ET + 1] = -seen[1], seen[0]
    if innovate(p, h, noise, innovation, gain) < 0.0:
        return
    for i in range(n):
        correction[i] = gain[i, 0] * innovation[0] + gain[i, 1] * innovation[1] + gain[i, 2] * innovation[2]
    inject(nominal, correction)
    learn_moment(p, h, noise, gain, innovation, np.zeros(3), memory)
    joseph(p, h, noise, gain, work)
