"""Starting the relative-pose filter, and finding the sensor again, from a burst of three coils (method page 3.6)."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.magnetic._coil import Source
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.motion import inject
from estimators.magnetic.relative.parameters import RelativePoseParameters
from estimators.magnetic.relative.watch import retreat
from estimators.magnetic.tracker.segment_tracker import Fix, TrackerLimits, locate
from estimators.recording import Float

_WELL_KNOWN_RAD = math.radians(20.0)
_RESTART_VELOCITY_MPS = 0.5
"""Sigma of the velocity after a start in motion: what people do with their limbs."""
_ROUNDS = 2
_LOST_SHARE = 0.5
"""Of the distance: with a place known less well than this it tells no mirror image apart."""
_AGREES = 22.46
"""99.9 % point of chi-square with 6 degrees of freedom."""
_STEP = 0.05
"""Share by which the moment is changed to see what that does to a fix."""
_VELOCITY = slice(at.E_VELOCITY, at.E_VELOCITY + 3)
_ATTITUDE = slice(at.E_ATTITUDE, at.E_ATTITUDE + 3)
_NOMINAL_ATTITUDE = slice(at.ATTITUDE, at.ATTITUDE + 4)
_PULSE_VALUE = slice(at.BURST_VALUE, at.BURST_VALUE + 3)
_PULSE_PLACE = slice(at.BURST_POSITION, at.BURST_POSITION + 3)
_PULSE_ATTITUDE = slice(at.BURST_ATTITUDE, at.BURST_ATTITUDE + 4)


@dataclass(frozen=True)
class _Burst:
    """What a burst says.

    Attributes
    ----------
    fix : Fix
        Its covariance includes what the sensor may have moved against what was assumed.
    ago_s : float
        How long before now its middle was: by so much times the error of the velocity the place is off.
    estimate_m : ndarray, shape (3,)
        The filter's own place, which is to be compared with the fix: at the velocity that the fix was made with.
    slope : ndarray, shape (6,)
        Error of the fix if the moment is larger than stated, per unit.
    score, information : float
        What the residuals say about the moment, as in `relative.moment`.
    """

    fix: Fix
    ago_s: float
    estimate_m: Float
    slope: Float
    score: float
    information: float


def start_from_burst(
    source: Source,
    parameters: RelativePoseParameters,
    settings: Float,
    nominal: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
    usual_place_m: Float | None = None,
) -> None:
    """Solve the burst in memory and start or correct by it, or wait for the next one; changes the arrays in place.

    Once started, a fix that agrees with what the filter expects corrects it as any measurement does, so that what is
    known of velocity and offsets is retained; any other fix puts it back to the beginning. `usual_place_m` tells mirror
    images apart once the filter's own place says nothing.
    """
    counters[at.EVENT] = 0
    counters[at.BURST_COIL] = 0
    counters[at.STREAK] = 0
    started = bool(counters[at.STARTED])
    burst = _solve(source, parameters, settings, nominal, covariance, memory, counters, usual_place_m)
    if burst.fix.flags or not _plausible(
        burst.fix, parameters, settings, nominal, covariance, memory, started
    ):
        retreat(settings, counters)
        return
    if not started or not _correct(burst, nominal, covariance, memory):
        _restart(burst, parameters, settings, nominal, covariance, memory, counters)
        counters[at.RESTARTED] += 1
    memory[at.NIS_WINDOW : at.NIS_WINDOW + at.NIS_LENGTH] = 0.0
    memory[at.MOMENT_SCORE] += burst.score
    memory[at.MOMENT_INFORMATION] += burst.information
    counters[at.PHASE] = at.TRACK
    counters[at.STARTED] = 1
    counters[at.REFUSED] = 0
    counters[at.FAILURES] = 0


def _correct(burst: _Burst, nominal: Float, covariance: Float, memory: Float) -> bool:
    """Correct by a fix as by a measurement of the pose; false, with nothing changed, if it must not be."""
    if math.sqrt(float(np.trace(covariance[_ATTITUDE, _ATTITUDE]))) > _WELL_KNOWN_RAD:
        return False
    gain, error, h = _gain(burst.fix, burst.estimate_m, burst.ago_s, nominal, covariance)
    inverse = np.linalg.inv(h @ covariance @ h.T + burst.fix.covariance)
    if not error @ inverse @ error < _AGREES:
        return False
    keep = np.eye(at.ERRORS) - gain @ h
    after = keep @ covariance @ keep.T + gain @ burst.fix.covariance @ gain.T
    if np.diagonal(after)[_VELOCITY].max() > _RESTART_VELOCITY_MPS**2:
        return False
    inject(nominal, gain @ error)
    covariance[:] = 0.5 * (after + after.T)
    sensitivity = memory[at.SENSITIVITY : at.SENSITIVITY + at.ERRORS]
    effect = h @ sensitivity - burst.slope
    memory[at.MOMENT_SCORE] += float(effect @ inverse @ error)
    memory[at.MOMENT_INFORMATION] += float(effect @ inverse @ effect)
    sensitivity -= gain @ effect
    return True


def _restart(
    burst: _Burst,
    parameters: RelativePoseParameters,
    settings: Float,
    nominal: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
) -> None:
    """Take the pose of a fix; of the rest only the offsets are known."""
    p = parameters
    spread = np.diag(covariance).copy()
    fix_covariance = burst.fix.covariance.copy()
    rate_sigma = 1.5 * p.rate_sigma_radps / math.sqrt(settings[at.CALIBRATE_TICKS]) + 1e-4
    # After a burst that was refused or did not come, nobody knows whether the wearer still stands still.
    stands = counters[at.REFUSED] == 0 and counters[at.MISSED] == 0
    first = np.repeat(
        [
            0.0,
            0.01 if stands else _RESTART_VELOCITY_MPS,
            0.0,
            p.force_bias_sigma_mps2,
            rate_sigma,
            p.force_bias_sigma_mps2,
            rate_sigma,
        ],
        3,
    )
    variances = first**2
    if counters[at.STARTED]:
        variances = spread
        if math.sqrt(spread[at.E_VELOCITY : at.E_VELOCITY + 3].max()) > _RESTART_VELOCITY_MPS:
            # Dead reckoning has lost the velocity: nothing known is better than something wrong.
            nominal[at.VELOCITY : at.VELOCITY + 3] = 0.0
        variances[at.E_VELOCITY : at.E_VELOCITY + 3] = _RESTART_VELOCITY_MPS**2
    else:
        nominal[at.VELOCITY : at.VELOCITY + 3] = 0.0
    fix_covariance[:3, :3] += np.eye(3) * variances[at.E_VELOCITY] * burst.ago_s**2
    nominal[at.POSITION : at.POSITION + 3] = burst.fix.position_m
    nominal[at.ATTITUDE : at.ATTITUDE + 4] = burst.fix.q_source_sensor
    if p.published_mechanisation:
        variances[at.E_SOURCE_FORCE :] = 0.0
    covariance[:] = np.diag(variances)
    covariance[np.ix_(at.POSE, at.POSE)] = fix_covariance
    memory[at.SENSITIVITY : at.SENSITIVITY + at.ERRORS] = 0.0
    memory[at.SENSITIVITY + at.POSE] = burst.slope


def _solve(
    source: Source,
    parameters: RelativePoseParameters,
    settings: Float,
    nominal: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
    usual_place_m: Float | None,
) -> _Burst:
    rows = memory[at.BURST : at.BURST + 3 * at.BURST_COLUMNS].reshape(3, at.BURST_COLUMNS)
    started = bool(counters[at.STARTED])
    here = nominal[at.POSITION : at.POSITION + 3].copy()
    back = (counters[at.TICK] - 1 - rows[:, at.BURST_TICK]) * settings[at.TIME_STEP]
    ago_s, last, turned = 0.0, None, None
    if started:
        ago_s, last = float(back.mean()), here
        turned = rotation.multiply(rotation.conjugate(nominal[_NOMINAL_ATTITUDE]), rows[:, _PULSE_ATTITUDE])
        if np.trace(covariance[:3, :3]) > (_LOST_SHARE * np.linalg.norm(here)) ** 2:
            last = usual_place_m
    direction = np.asarray(parameters.mounting_direction, dtype=np.float64)

    def found(moved: Float | None, share: float = 1.0) -> Fix:
        return locate(
            source,
            np.arange(3),
            share * rows[:, at.BURST_CURRENT],
            rows[:, _PULSE_VALUE],
            _field_sigma(settings),
            direction=direction if np.any(direction != 0.0) else None,
            last_position_m=last,
            moved_m=moved,
            q_turned=turned,
            # Coils that are known less well leave more of a burst, which is then no reason to refuse it.
            limits=TrackerLimits(gain_sigma=parameters.gain_sigma),
        )

    # Which velocity carries the pulses together: the filter's, what the fix itself then says of it, or none.
    knows = started and math.sqrt(float(np.trace(covariance[_ATTITUDE, _ATTITUDE]))) < _WELL_KNOWN_RAD
    moved = rows[:, _PULSE_PLACE] - here if knows else None
    wrong, loose = np.zeros(3), 0.0
    velocity = nominal[at.VELOCITY : at.VELOCITY + 3].copy()
    if started and not knows:
        wrong, loose = velocity, _RESTART_VELOCITY_MPS
    fix = found(moved)
    if moved is not None:
        carried = moved
        fix, wrong = _followed(
            fix, lambda v: found(carried + v * back[:, None]), here, ago_s, nominal, covariance
        )
        moved = moved + wrong * back[:, None]
        loose = _left(fix, ago_s, covariance)
        if fix.flags:
            wrong, moved = velocity, None
            fix = found(moved)
            loose = math.sqrt(float(np.diagonal(covariance)[_VELOCITY].max()))
    by_strength = _by_strength(fix, found(moved, 1.0 - _STEP), found(moved, 1.0 + _STEP))
    # Beside a common error of the velocity: how unevenly the pulses share it.
    fix.covariance[:3, :3] += (min(loose, _RESTART_VELOCITY_MPS) * float(back.std())) ** 2 * np.eye(3)
    return _Burst(fix, ago_s, here - wrong * ago_s, *by_strength)


def _followed(
    fix: Fix, found: Callable[[Float], Fix], here: Float, ago_s: float, nominal: Float, covariance: Float
) -> tuple[Fix, Float]:
    """Return the fix of pulses that are carried by what it says itself of the velocity's error, and that error."""
    wrong = np.zeros(3)
    for _ in range(_ROUNDS):
        if not np.isfinite(fix.covariance).all():
            break
        gain, error, _ = _gain(fix, here - wrong * ago_s, ago_s, nominal, covariance)
        wrong = (gain @ error)[_VELOCITY]
        fix = found(wrong)
    return fix, wrong


def _by_strength(fix: Fix, weaker: Fix, stronger: Fix) -> tuple[Float, float, float]:
    """Return how a fix moves with the strength of the source, (6,), and score and information about it."""
    turn = rotation.multiply(rotation.conjugate(weaker.q_source_sensor), stronger.q_source_sensor)
    slope = -np.concatenate([stronger.position_m - weaker.position_m, rotation.log(turn)]) / (2.0 * _STEP)
    score = -(stronger.chi_square - weaker.chi_square) / (4.0 * _STEP)
    information = (stronger.chi_square - 2.0 * fix.chi_square + weaker.chi_square) / (2.0 * _STEP**2)
    if not (
        np.isfinite(slope).all()
        and np.linalg.norm(slope[:3]) < np.linalg.norm(fix.position_m)
        and information > 0.0
    ):
        # Another minimum: by the third power of the distance.
        return np.r_[-fix.position_m / 3.0, np.zeros(3)], 0.0, 0.0
    return slope, score, information


def _field_sigma(settings: Float) -> float:
    """Return the standard deviation of a pulse of the start."""
    off = settings[at.START_OFF_TICKS]
    return math.sqrt(
        settings[at.FIELD_SIGMA] ** 2 * (1.0 / settings[at.START_ON_TICKS] + 1.0 / off)
        + 0.7 * off * (settings[at.RATE_SIGMA] * settings[at.TIME_STEP] * settings[at.EARTH_FIELD]) ** 2
    )


def _gain(
    fix: Fix, estimate_m: Float, ago_s: float, nominal: Float, covariance: Float
) -> tuple[Float, Float, Float]:
    """Return gain, error and H of a fix taken as a measurement of the pose, `ago_s` times the velocity ago."""
    turn = rotation.multiply(rotation.conjugate(fix.q_source_sensor), nominal[at.ATTITUDE : at.ATTITUDE + 4])
    error = np.concatenate([estimate_m - fix.position_m, rotation.log(turn)])
    h = np.zeros((6, at.ERRORS))
    h[np.arange(6), at.POSE] = 1.0
    h[np.arange(3), np.arange(at.E_VELOCITY, at.E_VELOCITY + 3)] = -ago_s
    gain = np.linalg.solve(h @ covariance @ h.T + fix.covariance, h @ covariance).T
    return np.asarray(gain, dtype=np.float64), np.asarray(error), h


def _left(fix: Fix, ago_s: float, covariance: Float) -> float:
    """Return the largest sigma of the velocity that a fix would leave."""
    if not np.isfinite(fix.covariance).all():
        return _RESTART_VELOCITY_MPS
    h = np.zeros((6, at.ERRORS))
    h[np.arange(6), at.POSE] = 1.0
    h[np.arange(3), np.arange(at.E_VELOCITY, at.E_VELOCITY + 3)] = -ago_s
    taken = np.linalg.solve(h @ covariance @ h.T + fix.covariance, h @ covariance)
    left = np.diagonal(covariance - covariance @ h.T @ taken)[_VELOCITY]
    return math.sqrt(max(0.0, float(left.max())))


def _plausible(
    fix: Fix,
    parameters: RelativePoseParameters,
    settings: Float,
    nominal: Float,
    covariance: Float,
    memory: Float,
    started: bool,
) -> bool:
    """Whether gravity (at a start) and the gyroscopes (at a restart) agree with the burst.

    Exchanging the numbers of all three coils in a circle turns source axes into source axes: the burst fits
    perfectly, and only these can tell.
    """
    limit = math.radians(parameters.inconsistent_deg)
    own = math.sqrt(float(np.trace(fix.covariance[3:, 3:])))
    if started:
        known = math.sqrt(float(np.trace(covariance[_ATTITUDE, _ATTITUDE])))
        if known > _WELL_KNOWN_RAD:
            return True
        angle = rotation.angle_between(nominal[at.ATTITUDE : at.ATTITUDE + 4], fix.q_source_sensor)
        return bool(angle < limit + 3.0 * math.hypot(own, known))
    sensor = memory[at.SUM_FORCE : at.SUM_FORCE + 3]
    worn = memory[at.SUM_SOURCE_FORCE : at.SUM_SOURCE_FORCE + 3]
    turned = rotation.rotate(fix.q_source_sensor, sensor)
    cosine = float(turned @ worn / (np.linalg.norm(turned) * np.linalg.norm(worn)))
    return math.acos(min(1.0, max(-1.0, cosine))) < limit + 3.0 * own
