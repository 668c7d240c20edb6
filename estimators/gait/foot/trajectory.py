"""Where a foot went, off-line: the foot filter there and back over a whole record, twice."""

from dataclasses import dataclass, replace
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from estimators.errors import ShapeError
from estimators.gait._stance import Stance, find_stance, gravity_scale, noise, resting_bias
from estimators.gait.foot import layout as at
from estimators.gait.foot.bridge_kernel import BESIDE_S, add_bridge_noise
from estimators.gait.foot.filter import (
    NO_FIELD,
    START_S,
    Records,
    is_usable_rate,
    rate_of,
    root,
    settings_of,
    start_covariance,
    start_state,
)
from estimators.gait.foot.gaps import FilledSignals, fill_gaps
from estimators.gait.foot.kernel import FootState, FootTicks
from estimators.gait.foot.parameters import FootParameters, with_clips
from estimators.gait.foot.second_look import doubtful_stances, stood
from estimators.recording import Float, SensorSignals
from estimators.sentences import say

_SEGMENT = 4096
"""Samples recorded at once; the way there is run twice over longer records, so memory stays the same."""
COAST_S = 3.0
"""So long after the last stance a position is worth nothing."""
LOST_SIGMA_MPS = 1.0
"""Where samples are missing the foot is taken to go nowhere, to this: it bounds the velocity, no more."""


class FootFlag(IntFlag):
    """What a later stage must know about a sample of a foot's trajectory; zero means sound."""

    SOUND = 0
    INVALID = 1
    """No estimate yet, or the record has no samples here."""
    BRIDGED = 2
    """Interpolated across a short gap."""
    NO_STANCE = 8
    """No stance for so long, before and after, that position and velocity are not known; live also until a stance has
    shown which way is up, where a record begins in the middle of a stride."""
    PLACE_LOST = 16
    """Live: after a long gap. Place and heading against the time before are lost; strides since then are sound."""
    BEGINS_ANEW = 32
    """Live: the first sample after a long gap, where a stretch with a place and a heading of its own begins."""
    SATURATED = 64
    """The gyroscope or the accelerometer was at its clip level."""


@dataclass(frozen=True)
class FootTrajectory:
    """Movement of one foot's sensor over N samples.

    Attributes
    ----------
    time_s : ndarray, shape (N,)
    position_m, velocity_mps : ndarray, shape (N, 3)
        Of the sensor, in a world with z up that has its origin and its heading at the first sample.
    q_world_sensor : ndarray, shape (N, 4)
    gyroscope_bias_radps : ndarray, shape (N, 3)
    pivot_m : ndarray, shape (N, 3)
        From the contact point to the sensor, sensor axes; means something in stance only.
    position_sigma_m, attitude_sigma_rad : ndarray, shape (N, 3)
        One sigma with what was known up to the sample; along x, y, z and about them.
    flags : ndarray of uint8, shape (N,)
        `FootFlag` bits.
    """

    time_s: Float
    position_m: Float
    velocity_mps: Float
    q_world_sensor: Float
    gyroscope_bias_radps: Float
    pivot_m: Float
    position_sigma_m: Float
    attitude_sigma_rad: Float
    stance: Stance
    flags: NDArray[np.uint8]

    @property
    def has_stance(self) -> bool:
        """Whether the foot was ever seen to stand; without that there is no position to speak of."""
        return bool(self.stance.is_stance.any())


def smooth(
    signals: SensorSignals,
    parameters: FootParameters | None = None,
    *,
    passes: int = 2,
) -> FootTrajectory:
    """Estimate the trajectory of a foot from its sensor, off-line.

    Parameters
    ----------
    signals : SensorSignals
        Real time stamps, even or not. Holes, and samples that are not finite, are filled in and flagged.
    passes : int
        The second pass starts from what the first found out about the first sample, which matters when a record
        starts in the middle of a stride.

    Returns
    -------
    FootTrajectory
        On the stamps of the record and of what was filled in, with `FootFlag.NO_STANCE` wherever no stance was
        found for long.

    Raises
    ------
    ShapeError
        For less than half a second or a rate that cannot be used.

    Notes
    -----
    Section 5 of the page on foot tracking without its three scale and delay states, which that page measured and
    switched off. Time and memory grow linearly and not at all with the length of the record.
    """
    chosen = parameters or FootParameters()
    if len(signals.time_s) < 3:
        raise ShapeError(say("walk.too_short", least_s=0.5))
    rate_hz = rate_of(signals.time_s)
    if not is_usable_rate(rate_hz):
        raise ShapeError(say("walk.rate", rate_hz=rate_hz))
    run = _Run(fill_gaps(signals, rate_hz), with_clips(signals, chosen))
    run.there_and_back()
    doubtful = run.leave_out_doubtful()
    for _ in range(passes - 1 if passes > 1 or not doubtful else 1):
        run.there_and_back()
    if doubtful and run.restore(doubtful):
        run.there_and_back()
    return run.trajectory()


class _Run:
    """One record on its way through the filter."""

    def __init__(self, filled: FilledSignals, parameters: FootParameters) -> None:
        signals, rate_hz = filled.signals, filled.rate_hz
        samples = len(signals.time_s)
        self.filled, self.parameters = filled, parameters
        self.time_s = signals.time_s
        gyroscope = self.gyroscope = np.ascontiguousarray(signals.gyroscope_radps, dtype=np.float64)
        scale = gravity_scale(gyroscope, signals.accelerometer_mps2, rate_hz)
        self.accelerometer = np.ascontiguousarray(scale * signals.accelerometer_mps2)
        self.step_s = np.diff(self.time_s, prepend=self.time_s[0])
        self.settings = settings_of(parameters)
        missing = filled.is_missing
        self.stance = find_stance(gyroscope, self.accelerometer, rate_hz, parameters, missing)
        self.sigma_mps = np.where(missing, LOST_SIGMA_MPS, self.stance.sigma_mps)
        self.force_variance, self.rate_variance = noise(
            gyroscope, self.accelerometer, np.where(missing, filled.gap_s, 0.0), parameters
        )
        is_filled = filled.gap_s > 0.0
        add_bridge_noise(
            gyroscope,
            self.accelerometer,
            is_filled & ~missing,
            is_filled,
            0,
            samples,
            max(1, round(BESIDE_S * rate_hz)),
            filled.lag,
            filled.lag / rate_hz,
            self.force_variance,
            self.rate_variance,
        )
        self.wanted = self.stance.bits
        # Where nothing is known the foot is taken to go nowhere, loosely.
        self.wanted[missing] = at.STANCE
        self.field = NO_FIELD
        field = signals.magnetometer_t
        if field is not None:
            usable = np.isfinite(field).all(axis=1) & self.stance.is_stance
            self.wanted = np.asarray(self.wanted | usable * np.uint8(at.HEADING))
            self.field = np.ascontiguousarray(np.where(usable[:, None], field, 0.0))
        start = max(1, round(START_S * rate_hz))
        bias = resting_bias(gyroscope, self.stance.statistic, rate_hz, parameters.standstill_limit)
        self.x = start_state(self.accelerometer[:start].mean(axis=0), bias)
        self.p = start_covariance(float(self.stance.statistic[:start].mean()), parameters)
        self.smooth = np.empty((samples, at.STATE))
        self.spread = np.empty((samples, 6))

    def there_and_back(self) -> None:
        """Filter, smooth, and take the smoothed first sample for the next start."""
        samples = len(self.time_s)
        pieces = [slice(i, min(i + _SEGMENT, samples)) for i in range(0, samples, _SEGMENT)]
        records = Records(min(samples, _SEGMENT))
        self.bits = self.wanted.copy()
        x, p, memory = self.x.copy(), self.p.copy(), np.zeros(at.MEMORY)
        marks = []
        for piece in pieces:
            marks.append((x.copy(), p.copy(), memory.copy()))
            self._forward(records, piece, x, p, memory)
        adjoint = np.zeros(at.ERRORS)
        for piece, mark in zip(reversed(pieces), reversed(marks), strict=True):
            if piece.stop < samples:
                self._forward(records, piece, *mark)
            count = piece.stop - piece.start
            records.backward(0, count, count, adjoint, self.smooth[piece])
            self.spread[piece] = records.trace.spread[:count]
        first = self.smooth[0]
        retained = slice(at.V, at.PIVOT)
        self.x[retained] = first[retained]

    def leave_out_doubtful(self) -> list[tuple[int, int]]:
        """Measure nothing in stances that are likely the middle of a long swing, and return them."""
        found = self.stance.is_stance & ~self.filled.is_missing
        doubtful = doubtful_stances(self.stance.statistic, found, self.time_s)
        for first, stop in doubtful:
            self.wanted[first:stop] = 0
        return doubtful

    def restore(self, doubtful: list[tuple[int, int]]) -> bool:
        """Measure again in those in which the foot stood; returns whether there are any."""
        restored = stood(doubtful, self.smooth[:, at.V : at.V + 3])
        for first, stop in restored:
            self.wanted[first:stop] = self.stance.bits[first:stop]
        return bool(restored)

    def _forward(self, records: Records, piece: slice, x: Float, p: Float, memory: Float) -> None:
        records.forward(
            slice(0, piece.stop - piece.start),
            FootTicks(
                self.step_s[piece],
                self.gyroscope[piece],
                self.accelerometer[piece],
                self.sigma_mps[piece],
                self.bits[piece],
                self.force_variance[piece],
                self.rate_variance[piece],
                self.field[piece] if len(self.field) else NO_FIELD,
            ),
            self.settings,
            FootState(memory, x, p),
        )

    def trajectory(self) -> FootTrajectory:
        """Put the result together."""
        sigma = root(self.spread)
        believed = ((self.bits & at.STANCE) != 0) & ~self.filled.is_missing
        self.stance = replace(
            self.stance,
            is_stance=believed,
            is_standstill=self.stance.is_standstill & believed,
            is_height=self.stance.is_height & believed,
        )
        return FootTrajectory(
            time_s=self.time_s,
            position_m=self.smooth[:, at.P : at.P + 3].copy(),
            velocity_mps=self.smooth[:, at.V : at.V + 3].copy(),
            q_world_sensor=self.smooth[:, at.Q : at.Q + 4].copy(),
            gyroscope_bias_radps=self.smooth[:, at.GYROSCOPE_BIAS : at.GYROSCOPE_BIAS + 3].copy(),
            pivot_m=self.smooth[:, at.PIVOT : at.PIVOT + 3].copy(),
            position_sigma_m=sigma[:, :3],
            attitude_sigma_rad=sigma[:, 3:],
            stance=self.stance,
            flags=self._flags(),
        )

    def _flags(self) -> NDArray[np.uint8]:
        stance_s = self.time_s[self.stance.is_stance]
        if len(stance_s):
            after = np.searchsorted(stance_s, self.time_s)
            before_s = self.time_s - stance_s[np.maximum(after - 1, 0)]
            before_s[after == 0] = np.inf
            ahead_s = stance_s[np.minimum(after, len(stance_s) - 1)] - self.time_s
            ahead_s[after == len(stance_s)] = np.inf
            lost = np.minimum(before_s, ahead_s) > COAST_S
        else:
            lost = np.ones(len(self.time_s), dtype=np.bool_)
        clips = self.parameters
        clipped = (np.abs(self.gyroscope) > 0.99 * clips.gyroscope_clip_radps).any(axis=1)
        clipped |= (np.abs(self.accelerometer) > 0.99 * clips.accelerometer_clip_mps2).any(axis=1)
        missing, filled = self.filled.is_missing, self.filled.gap_s > 0.0
        bits = lost * FootFlag.NO_STANCE + clipped * FootFlag.SATURATED + missing * FootFlag.INVALID
        bits = bits + (filled & ~missing) * FootFlag.BRIDGED
        return np.asarray(bits, dtype=np.uint8)
