"""Starting the relative-pose filter, and starting it anew, from a burst of three coils (method page 3.6)."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.magnetic import _relative_layout as at
from estimators.magnetic._coil import Source
from estimators.magnetic._relative_parameters import RelativePoseParameters
from estimators.magnetic._tracker import Fix, TrackerLimits, locate
from estimators.recording import Float

_WELL_KNOWN_RAD = math.radians(20.0)
_RESTART_VELOCITY_MPS = 0.5
"""Sigma of the velocity after a start in motion: what people do with their limbs."""


def start_from_burst(
    source: Source,
    parameters: RelativePoseParameters,
    settings: Float,
    nominal: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
) -> None:
    """Solve the burst in memory and start from it, or wait for the next attempt; changes the arrays in place."""
    counters[at.EVENT] = 0
    counters[at.BURST_COIL] = 0
    counters[at.STREAK] = 0
    started = bool(counters[at.STARTED])
    fix = _solve(source, parameters, settings, nominal, memory, started)
    if fix.flags or not _plausible(fix, parameters, settings, nominal, covariance, memory, started):
        counters[at.PHASE] = at.WAIT
        counters[at.WAIT_UNTIL] = counters[at.TICK] + int(settings[at.RETRY_TICKS])
        counters[at.FAILURES] += 1
        return
    p = parameters
    spread = np.diag(covariance).copy()
    nominal[at.POSITION : at.POSITION + 3] = fix.position_m
    nominal[at.ATTITUDE : at.ATTITUDE + 4] = fix.q_source_sensor
    rate_sigma = 1.5 * p.rate_sigma_radps / math.sqrt(settings[at.CALIBRATE_TICKS]) + 1e-4
    first = np.repeat(
        [
            0.0,
            # After a burst that was refused, nobody knows whether the wearer still stands still.
            0.01 if counters[at.FAILURES] == 0 else _RESTART_VELOCITY_MPS,
            0.0,
            p.force_bias_sigma_mps2,
            rate_sigma,
            p.force_bias_sigma_mps2,
            rate_sigma,
        ],
        3,
    )
    variances = first**2
    if started:
        variances = spread
        if math.sqrt(spread[at.E_VELOCITY : at.E_VELOCITY + 3].max()) > _RESTART_VELOCITY_MPS:
            # Dead reckoning has lost the velocity: nothing known is better than something wrong.
            nominal[at.VELOCITY : at.VELOCITY + 3] = 0.0
        variances[at.E_VELOCITY : at.E_VELOCITY + 3] = _RESTART_VELOCITY_MPS**2
    else:
        nominal[at.VELOCITY : at.VELOCITY + 3] = 0.0
    if p.published_mechanisation:
        variances[at.E_SOURCE_FORCE :] = 0.0
    covariance[:] = np.diag(variances)
    pose = np.r_[at.E_POSITION : at.E_POSITION + 3, at.E_ATTITUDE : at.E_ATTITUDE + 3]
    covariance[np.ix_(pose, pose)] = fix.covariance
    memory[at.NIS_WINDOW : at.NIS_WINDOW + at.NIS_LENGTH] = 0.0
    counters[at.PHASE] = at.TRACK
    counters[at.STARTED] = 1
    counters[at.FAILURES] = 0


def _solve(
    source: Source,
    parameters: RelativePoseParameters,
    settings: Float,
    nominal: Float,
    memory: Float,
    started: bool,
) -> Fix:
    rows = memory[at.BURST : at.BURST + 3 * at.BURST_COLUMNS].reshape(3, at.BURST_COLUMNS)
    moved = turned = None
    last = None
    if started:
        moved = rows[:, 3:6] - nominal[at.POSITION : at.POSITION + 3]
        back = rotation.conjugate(nominal[at.ATTITUDE : at.ATTITUDE + 4])
        turned = rotation.multiply(back, rows[:, 6:10])
        last = nominal[at.POSITION : at.POSITION + 3]
    off = settings[at.START_OFF_TICKS]
    sigma = math.sqrt(
        settings[at.FIELD_SIGMA] ** 2 * (1.0 / settings[at.START_ON_TICKS] + 1.0 / off)
        + 0.7 * off * (settings[at.RATE_SIGMA] * settings[at.TIME_STEP] * settings[at.EARTH_FIELD]) ** 2
    )
    direction = np.asarray(parameters.mounting_direction, dtype=np.float64)
    return locate(
        source,
        np.arange(3),
        rows[:, 10],
        rows[:, :3],
        sigma,
        direction=direction if np.any(direction != 0.0) else None,
        last_position_m=last,
        moved_m=moved,
        q_turned=turned,
        # Coils that are known less well leave more of a burst, which is then no reason to refuse it.
        limits=TrackerLimits(gain_sigma=parameters.gain_sigma),
    )


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
        known = math.sqrt(float(np.trace(covariance[6:9, 6:9])))
        if known > _WELL_KNOWN_RAD:
            return True
        angle = rotation.angle_between(nominal[at.ATTITUDE : at.ATTITUDE + 4], fix.q_source_sensor)
        return bool(angle < limit + 3.0 * math.hypot(own, known))
    sensor = memory[at.SUM_FORCE : at.SUM_FORCE + 3]
    worn = memory[at.SUM_SOURCE_FORCE : at.SUM_SOURCE_FORCE + 3]
    turned = rotation.rotate(fix.q_source_sensor, sensor)
    cosine = float(turned @ worn / (np.linalg.norm(turned) * np.linalg.norm(worn)))
    return math.acos(min(1.0, max(-1.0, cosine))) < limit + 3.0 * own


__all__ = ["start_from_burst"]
