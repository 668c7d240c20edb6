"""A fix from a burst of a moving sensor, with the covariance that its physics gives.

`locate` holds the sensor still during a burst. Here both modules' inertial signals carry every pulse to one moment
(Roetenberg 2006, 6.5: features 15 and 18 of the page). What they cannot tell is the velocity at that moment: a fix is
solved at a given one and says by how much it would be off for another, `CarriedFix.velocity_effect`, so that a filter
can keep the correlation of the two. To first order, with pulses s = h(x, v) + n, pulse j at t_j after the moment of the
fix, S the covariance of n and A_j the turn of the source until then,

    x_fix - x = K (H_v (v - v_solved) + n),   K = (H^T S^-1 H)^-1 H^T S^-1,   H_v,j = (dh_j / dp) A_j t_j

so that the covariance of the fix is (H^T S^-1 H)^-1 for a velocity that is known. S is that of all values together:
magnetometer noise of on and off samples, of which pulses of a burst share the off ones; the earth's field h turned by
the noise of the gyroscope that carried the samples, (h x)(h x)^T; and the gain of the coils.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimators import rotation
from estimators.errors import ShapeError
from estimators.magnetic._coil import Source
from estimators.magnetic._measurement import MAGNETOMETER_SIGMA_T, predict, skew
from estimators.magnetic._pulses import Pulse, integrate_gyroscope
from estimators.magnetic.tracker.segment_tracker import (
    Fix,
    TrackerFlag,
    TrackerLimits,
    locate,
    most_chi_square,
)
from estimators.recording import Float


@dataclass(frozen=True)
class BurstNoise:
    """Noise per sample of the magnetometer, and of the gyroscope that carries its samples."""

    magnetometer_sigma_t: float = MAGNETOMETER_SIGMA_T
    rate_sigma_radps: float = 0.01


@dataclass(frozen=True)
class ModuleSignals:
    """Inertial signals of both modules over K ticks, gyroscopes less their offsets; all (K, 3)."""

    time_step_s: float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    source_gyroscope_radps: Float
    source_accelerometer_mps2: Float

    def __post_init__(self) -> None:
        shapes = {values.shape for values in (self.gyroscope_radps, self.accelerometer_mps2)}
        shapes |= {values.shape for values in (self.source_gyroscope_radps, self.source_accelerometer_mps2)}
        if len(shapes) != 1 or len(self.gyroscope_radps.shape) != 2 or self.gyroscope_radps.shape[1] != 3:
            raise ShapeError(f"both modules need signals of one shape (K, 3), not {sorted(shapes)}")


@dataclass(frozen=True)
class BurstPath:
    """Where the sensor was at each pulse, against the pose at one moment.

    Attributes
    ----------
    delay_s : ndarray, shape (N,)
        Mean time of the used samples of each pulse after that moment.
    source_turn : ndarray, shape (N, 3, 3)
        From the source's axes then to those at the pulse.
    sensor_turn : ndarray, shape (N, 4)
        From the sensor's axes at the pulse to those then.
    way_m : ndarray, shape (N, 3)
        Of the sensor, by acceleration alone, in the source's axes then.
    """

    delay_s: Float
    source_turn: Float
    sensor_turn: Float
    way_m: Float

    def moved(self, position_m: Float, velocity_mps: Float) -> Float:
        """Return how far the sensor was from `position_m` in the source frame at each pulse, shape (N, 3)."""
        away = position_m + self.delay_s[:, None] * velocity_mps + self.way_m
        return np.asarray((self.source_turn @ away[..., None])[..., 0] - position_m)

    def turned(self, q_source_sensor: Float) -> Float:
        """Return how the sensor was turned against the source at each pulse, in its own axes, shape (N, 4)."""
        source = rotation.from_matrix(self.source_turn)
        back = rotation.multiply(rotation.conjugate(q_source_sensor), source)
        return rotation.multiply(rotation.multiply(back, q_source_sensor), self.sensor_turn)

    def slopes(self, jacobian: Float) -> tuple[Float, Float]:
        """Turn slopes of the pulses, (N, 3, 6), into those by errors of pose and velocity at the tick.

        Returns
        -------
        by_pose : ndarray, shape (3 N, 6)
            The known turns come before and after the errors.
        by_velocity : ndarray, shape (3 N, 3)
        """
        back = np.swapaxes(rotation.to_matrix(self.sensor_turn), -1, -2)
        by_pose = np.concatenate([jacobian[..., :3] @ self.source_turn, jacobian[..., 3:] @ back], -1)
        by_velocity = (by_pose[..., :3] * self.delay_s[:, None, None]).reshape(-1, 3)
        return by_pose.reshape(-1, 6), by_velocity


@dataclass(frozen=True)
class CarriedFix:
    """A fix for one moment of a burst.

    Attributes
    ----------
    fix : Fix
        With the covariance of this module, for a velocity that is known.
    velocity_mps : ndarray, shape (3,)
        That it was solved at: of the sensor from the source, in source axes.
    velocity_effect : ndarray, shape (6, 3)
        By how much position (m, source axes) and orientation (rad, sensor axes) come out too large for each m/s that
        the velocity was larger than that.
    coil_covariance : ndarray, shape (6, 6)
        The part of the covariance of `fix` that the gain of the coils has: at the same place it is the same error in
        every burst, and no mean makes it smaller.
    """

    fix: Fix
    velocity_mps: Float
    velocity_effect: Float
    coil_covariance: Float


def burst_path(
    burst: Sequence[Pulse], signals: ModuleSignals, tick: int, q_source_sensor: Float
) -> BurstPath:
    """Carry both modules over a burst, from `tick` forward and backward.

    `q_source_sensor` at that tick brings the accelerations together: a degree of error is 0.3 mm after 60 ms.
    """
    last = len(signals.gyroscope_radps) - 1
    low = max(0, min(min(int(p.on.min()), p.middle) for p in burst) - 1)
    high = min(last, max(max(int(p.on.max()), p.middle) for p in burst) + 1)
    span, dt, at = slice(low, high + 1), signals.time_step_s, tick - low
    turns = []
    for rate in (signals.gyroscope_radps[span], signals.source_gyroscope_radps[span]):
        attitude = integrate_gyroscope(np.nan_to_num(rate), dt)
        turns.append(rotation.multiply(rotation.conjugate(attitude[at]), attitude))
    sensor, source = turns
    own = rotation.rotate(rotation.multiply(q_source_sensor, sensor), signals.accelerometer_mps2[span])
    worn = rotation.rotate(source, signals.source_accelerometer_mps2[span])
    net = np.nan_to_num(own - worn)
    speed = np.zeros_like(net)
    speed[1:] = np.cumsum(0.5 * dt * (net[1:] + net[:-1]), axis=0)
    speed -= speed[at]
    way = np.zeros_like(net)
    way[1:] = np.cumsum(0.5 * dt * (speed[1:] + speed[:-1]), axis=0)
    way -= way[at]
    middle = np.array([float(np.mean(p.on)) for p in burst]) - low
    grid, turn = np.arange(len(net)), rotation.log(source)
    between = [np.stack([np.interp(middle, grid, column) for column in x.T], axis=1) for x in (turn, way)]
    return BurstPath(
        (middle - at) * dt,
        np.swapaxes(rotation.to_matrix(rotation.exp(between[0])), -1, -2),
        sensor[[p.middle - low for p in burst]],
        between[1],
    )


def pulse_covariance(
    burst: Sequence[Pulse], time_step_s: float, noise: BurstNoise | None = None, gain_sigma: float = 0.0
) -> Float:
    """Return the covariance of all values of a burst together, shape (3 N, 3 N).

    A value is a sum of samples with weights w that add up to nothing, each turned by the gyroscope: a step of that
    from sample k to k + 1 turns what is weighed after it, so that the earth's field h gets into the value as
    -h x sum_k c_k e_k with c_k the sum of the weights after k, and e_k of sigma rate noise times tick.
    """
    n = noise or BurstNoise()
    low = min(int(min(p.on.min(), p.off.min())) for p in burst)
    high = max(int(max(p.on.max(), p.off.max())) for p in burst) + 1
    weights = np.zeros((len(burst), high - low))
    for row, pulse in zip(weights, burst, strict=True):
        row[pulse.on - low] += 1.0 / len(pulse.on)
        row[pulse.off - low] -= 1.0 / len(pulse.off)
    after = np.cumsum(weights[:, ::-1], axis=1)[:, ::-1][:, 1:]
    white = n.magnetometer_sigma_t**2 * weights @ weights.T
    turns = (n.rate_sigma_radps * time_step_s) ** 2 * after @ after.T
    levers = skew(np.stack([pulse.ambient_sensor_t for pulse in burst]))
    # (3N, 3N) from blocks (a, i, b, j)
    blocks = white[:, None, :, None] * np.eye(3)[None, :, None, :]
    blocks = blocks + np.einsum("ab,aik,bjk->aibj", turns, levers, levers)
    size = 3 * len(burst)
    covariance = blocks.reshape(size, size)
    strength = np.repeat([float(np.sum(p.field_sensor_t**2)) for p in burst], 3)
    return np.asarray(covariance + np.diag(gain_sigma**2 * strength))


def locate_moving(
    source: Source,
    burst: Sequence[Pulse],
    signals: ModuleSignals,
    tick: int,
    position_m: Float,
    q_source_sensor: Float,
    velocity_mps: Float,
    velocity_covariance: Float | None = None,
    noise: BurstNoise | None = None,
    limits: TrackerLimits | None = None,
) -> CarriedFix:
    """Find the pose at one tick that explains the pulses of a burst of a moving sensor.

    Parameters
    ----------
    burst : sequence of Pulse
        As `bursts` gathers them, extracted with the attitude of the sensor's gyroscope.
    signals : ModuleSignals
        Over the whole recording; the samples of the burst are used.
    tick : int
        Within the burst.
    position_m, q_source_sensor, velocity_mps : ndarray, shape (3,), (4,), (3,)
        What is known of that tick: the place chooses the hemisphere, orientation and velocity carry the pulses.
    velocity_covariance : ndarray, shape (3, 3), optional
        In source axes. Pulses may be off by what it allows before the fix is `DISTURBED`; it is not in the covariance.
    """
    bounds = limits or TrackerLimits()
    spread = pulse_covariance(burst, signals.time_step_s, noise, bounds.gain_sigma)
    noise_alone = pulse_covariance(burst, signals.time_step_s, noise)
    sigma_t = float(np.sqrt(np.trace(noise_alone) / len(spread)))
    coil, current = np.array([p.coil for p in burst]), np.array([p.current_a for p in burst])
    pulses = np.stack([p.field_sensor_t for p in burst])
    saturated = any(p.saturated for p in burst)
    velocity = np.array(velocity_mps, dtype=np.float64)
    place, q = np.array(position_m, dtype=np.float64), np.array(q_source_sensor, dtype=np.float64)
    # By the orientation that is given, not the one that is found: a filter's is better than a burst's.
    path = burst_path(burst, signals, tick, q)
    fix: Fix | None = None
    for _ in range(_PASSES):
        moved, turned = path.moved(place, velocity), path.turned(q)
        fix = locate(
            source,
            coil,
            current,
            pulses,
            sigma_t,
            last_position_m=position_m,
            moved_m=moved,
            q_turned=turned,
            saturated=saturated,
            limits=bounds,
            start=(place, q),
        )
        if fix.flags & TrackerFlag.NO_SOLUTION:
            return CarriedFix(fix, velocity, np.full((6, 3), np.nan), np.full((6, 6), np.nan))
        place, q = fix.position_m, fix.q_source_sensor
    assert fix is not None
    seen = predict(source, coil, current, place + moved, rotation.multiply(q, turned))
    rows, by_velocity = path.slopes(seen.jacobian)
    off = (seen.field_sensor_t - pulses).ravel()
    allowed = spread
    if velocity_covariance is not None:
        allowed = spread + by_velocity @ velocity_covariance @ by_velocity.T
    weighed, gain = _weighed(fix, off, rows, spread)
    weighed = _judged(weighed, _misfit(off, rows, allowed), most_chi_square(bounds, len(pulses)))
    return CarriedFix(
        weighed,
        velocity,
        np.asarray(gain @ by_velocity),
        np.asarray(gain @ (spread - noise_alone) @ gain.T),
    )


def _weighed(fix: Fix, off: Float, rows: Float, spread: Float) -> tuple[Fix, Float]:
    """Go one step more, with the whole covariance of the pulses, which `locate` weighs alike; and return its gain."""
    weighed = np.linalg.solve(spread, rows).T
    covariance = np.linalg.inv(weighed @ rows)
    gain = covariance @ weighed
    step = gain @ off
    stepped = replace(
        fix,
        position_m=fix.position_m - step[:3],
        q_source_sensor=rotation.positive(rotation.multiply(fix.q_source_sensor, rotation.exp(-step[3:]))),
        covariance=np.asarray(0.5 * (covariance + covariance.T)),
    )
    return stepped, gain


def _judged(fix: Fix, chi_square: float, most: float) -> Fix:
    flags = fix.flags & ~TrackerFlag.DISTURBED
    if chi_square > most:
        flags |= TrackerFlag.DISTURBED
    return replace(fix, chi_square=chi_square, flags=flags)


def _misfit(off: Float, rows: Float, spread: Float) -> float:
    """Return the chi-square of what no pose explains of residuals, shape (3 N,), by their whole covariance."""
    root = np.linalg.cholesky(spread)
    left, lever = np.linalg.solve(root, off), np.linalg.solve(root, rows)
    basis = np.linalg.qr(lever)[0]
    return float(left @ left - np.sum((basis.T @ left) ** 2))


_PASSES = 2
"""The second uses the pose of the first for what the turn of the source does to it; what is left is negligible."""
