"""When a foot stands, and how much each sample can be trusted: no threshold to set per person or speed."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.gait import _stance_kernel as kernels
from estimators.gait.foot import layout as at
from estimators.gait.foot.parameters import FootParameters
from estimators.recording import Float

Bool = NDArray[np.bool_]

_GRID_S = 0.02
_REFERENCE_RATE_HZ = 200.0
UNREST = 1000.0
"""T of samples that were not measured."""
NOT_CUT_OFF = np.empty(0, dtype=np.uint8)
_HEIGHT_ALONE_S = 0.35
_CALIBRATION_SHARE, _CALIBRATION_WINDOW_S, _CALIBRATION_TOLERANCE = 0.05, 0.3, 0.03
_CALIBRATION_SCALES = (0.5, 0.3)
_BIAS_LONGEST_S = 0.5


@dataclass(frozen=True)
class Windows:
    """The windows of the detector in samples of one rate."""

    half: int
    stride: int
    before: int
    after: int
    alone: int

    @classmethod
    def at_rate(cls, rate_hz: float, parameters: FootParameters) -> "Windows":
        """Round the windows of the parameters to samples."""
        stride = max(1, round(_GRID_S * rate_hz))
        return cls(
            half=max(1, round(0.5 * (parameters.window_s * rate_hz - 1.0))),
            stride=stride,
            before=max(1, round(parameters.reference_before_s * rate_hz / stride)),
            after=max(1, round(parameters.reference_after_s * rate_hz / stride)),
            alone=round(_HEIGHT_ALONE_S * rate_hz),
        )

    @property
    def ahead(self) -> int:
        """Samples after one that decide whether it is stance."""
        return max(self.after * self.stride, self.alone) + self.half

    @property
    def back(self) -> int:
        """Samples before one that decide whether it is stance."""
        return max((self.before + 1) * self.stride, self.alone) + self.half


@dataclass(frozen=True)
class Stance:
    """What the detector says about each of N samples.

    Attributes
    ----------
    statistic : ndarray, shape (N,)
        T: 0 at rest, 0.3 to 1 in the stance of walking, 4 to 13 of running.
    reference : ndarray, shape (N,)
        Low percentile of T around the sample, not below its floor.
    is_stance, is_standstill, is_height : ndarray of bool, shape (N,)
        The foot stands; the foot does not even turn; a sample that is taken for its level, one
        a stance or one in 0.35 s of standing.
    sigma_mps : ndarray, shape (N,)
        Standard deviation of the contact point's velocity, were this stance.
    """

    statistic: Float
    reference: Float
    is_stance: Bool
    is_standstill: Bool
    is_height: Bool
    sigma_mps: Float

    @property
    def bits(self) -> NDArray[np.uint8]:
        """What the filter measures at each sample."""
        bits = self.is_stance * at.STANCE + self.is_standstill * at.STANDSTILL + self.is_height * at.HEIGHT
        return np.asarray(bits, dtype=np.uint8)


def find_stance(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    rate_hz: float,
    parameters: FootParameters,
    is_missing: Bool | None = None,
) -> Stance:
    """Find the zero-velocity intervals of a whole record.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
        Sensor axes, finite.
    is_missing : ndarray of bool, shape (N,), optional
        Where nothing was measured and values only stand in: never a stance.

    Notes
    -----
    Eq. (2) to (6) of the page on foot tracking: T weighs turning, unsteady force and force that is not gravity;
    a sample is stance where T is near the lowest it gets within about a stride. So a runner's short, restless
    stances are found as well as those of somebody who shuffles.
    """
    windows = Windows.at_rate(rate_hz, parameters)
    samples = len(gyroscope_radps)
    statistic = np.empty(samples)
    write_statistic(
        np.ascontiguousarray(gyroscope_radps, dtype=np.float64),
        np.ascontiguousarray(accelerometer_mps2, dtype=np.float64),
        is_missing,
        0,
        samples,
        windows,
        parameters,
        statistic,
    )
    return judge(statistic, 0, 0, samples, rate_hz, windows, parameters)


def write_statistic(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    is_missing: Bool | None,
    first: int,
    stop: int,
    windows: Windows,
    parameters: FootParameters,
    statistic: Float,
) -> None:
    """Write T of the samples `[first, stop)` of contiguous arrays; what was never measured is unrest."""
    kernels.stance_statistic(
        gyroscope_radps,
        accelerometer_mps2,
        first,
        stop,
        windows.half,
        parameters.moving_gyroscope_radps,
        parameters.moving_accelerometer_mps2,
        statistic,
    )
    if is_missing is not None and is_missing.any():
        for k in np.flatnonzero(is_missing).tolist():
            low, high = max(first, k - windows.half), min(stop, k + windows.half + 1)
            if low < high:
                statistic[low:high] = UNREST


def judge(
    statistic: Float,
    origin: int,
    first: int,
    stop: int,
    rate_hz: float,
    windows: Windows,
    parameters: FootParameters,
) -> Stance:
    """Decide about the samples `[first, stop)` of a record from T of its samples from `origin` on."""
    count = stop - first
    reference, sigma, bits = np.empty(count), np.empty(count), np.empty(count, dtype=np.uint8)
    settings = decision_settings(rate_hz, parameters)
    decide(statistic, origin, first, stop, windows, settings, reference, sigma, bits)
    return Stance(
        statistic[first - origin : stop - origin],
        reference,
        (bits & at.STANCE) != 0,
        (bits & at.STANDSTILL) != 0,
        (bits & at.HEIGHT) != 0,
        sigma,
    )


def decide(
    statistic: Float,
    origin: int,
    first: int,
    stop: int,
    windows: Windows,
    settings: Float,
    reference: Float,
    sigma_mps: Float,
    bits: NDArray[np.uint8],
) -> None:
    """Write what `judge` finds into arrays of `stop - first` values."""
    kernels.decide(
        statistic,
        origin,
        first,
        stop,
        windows.stride,
        windows.before,
        windows.after,
        windows.alone,
        settings,
        reference,
        sigma_mps,
        bits,
    )


def decision_settings(rate_hz: float, parameters: FootParameters) -> Float:
    """Return the constants of the detector in the order of its kernel."""
    # The noise of neighbouring samples is one and the same: at a higher rate each of them says less.
    scale = math.sqrt(rate_hz / _REFERENCE_RATE_HZ)
    settings = np.zeros(kernels.DECIDE)
    settings[kernels.RATIO] = parameters.stance_ratio
    settings[kernels.FLOOR] = parameters.reference_floor
    settings[kernels.LIMIT] = parameters.stance_limit
    settings[kernels.STILL] = parameters.standstill_limit
    settings[kernels.SIGMA_FLOOR] = scale * parameters.velocity_sigma_floor_mps
    settings[kernels.SIGMA_SLOPE] = scale * parameters.velocity_sigma_slope_mps
    settings[kernels.SIGMA_EXPONENT] = parameters.velocity_sigma_exponent
    settings[kernels.RESTLESS] = parameters.restless_statistic
    settings[kernels.CONTRAST] = parameters.restless_contrast
    settings[kernels.SHARE] = 0.01 * parameters.reference_percentile
    return settings


def noise_settings(parameters: FootParameters) -> Float:
    """Return the constants of the noise in the order of its kernel."""
    settings = np.zeros(kernels.NOISE)
    settings[kernels.SHOCK] = min(parameters.shock_mps2, 0.97 * parameters.accelerometer_clip_mps2)
    settings[kernels.SHOCK_DENSITY] = parameters.shock_density
    settings[kernels.FORCE_DENSITY] = parameters.accelerometer_density
    settings[kernels.FORCE_JERK] = parameters.accelerometer_jerk_share
    settings[kernels.CLIP] = 0.99 * parameters.gyroscope_clip_radps
    settings[kernels.CLIP_DENSITY] = parameters.clip_density
    settings[kernels.RATE_DENSITY] = parameters.gyroscope_density
    settings[kernels.RATE_JERK] = parameters.gyroscope_jerk_share
    settings[kernels.GAP_FORCE] = parameters.gap_accelerometer_density
    settings[kernels.GAP_RATE] = parameters.gap_gyroscope_density
    return settings


def runs(mask: Bool) -> list[tuple[int, int]]:
    """Return the half-open stretches in which a mask is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def noise(
    gyroscope_radps: Float, accelerometer_mps2: Float, gap_s: Float, parameters: FootParameters
) -> tuple[Float, Float]:
    """Return the noise densities squared of each sample.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
    gap_s : ndarray, shape (N,)
        Length of the gap that a sample was filled into; zero where it was measured.

    Returns
    -------
    force_variance : ndarray, shape (N,)
        (m/s)^2/s
    rate_variance : ndarray, shape (N, 3)
        rad^2/s

    Notes
    -----
    Eq. (11) and (12). Impacts that the accelerometer cannot follow spoil the length of a stride, and a gyroscope
    at its clip level the heading; both are known from the samples themselves.
    """
    samples = len(gyroscope_radps)
    force_variance, rate_variance = np.empty(samples), np.empty((samples, 3))
    kernels.noise_densities(
        np.ascontiguousarray(gyroscope_radps),
        np.ascontiguousarray(accelerometer_mps2),
        np.sqrt(gap_s / parameters.gap_scale_s),
        NOT_CUT_OFF,
        0,
        samples,
        noise_settings(parameters),
        force_variance,
        rate_variance,
    )
    return force_variance, rate_variance


def gravity_scale(gyroscope_radps: Float, accelerometer_mps2: Float, rate_hz: float) -> float:
    """Return the factor that brings the calmest specific force to gravity, eq. (1); 1 where none is near it.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
    """
    width = round(_CALIBRATION_WINDOW_S * rate_hz)
    if len(gyroscope_radps) < width:
        return 1.0
    mean = _windowed(accelerometer_mps2, width)
    spread = np.sqrt(np.maximum(_windowed(accelerometer_mps2**2, width) - mean**2, 0.0).sum(axis=1))
    turning = np.sqrt(_windowed(gyroscope_radps**2, width).sum(axis=1))
    unrest = spread / _CALIBRATION_SCALES[0] + turning / _CALIBRATION_SCALES[1]
    count = max(1, round(_CALIBRATION_SHARE * len(unrest)))
    calm = np.argpartition(unrest, count - 1)[:count]
    at_rest = float(np.median(np.linalg.norm(mean[calm], axis=1)))
    return GRAVITY_MPS2 / at_rest if abs(at_rest / GRAVITY_MPS2 - 1.0) < _CALIBRATION_TOLERANCE else 1.0


def resting_bias(gyroscope_radps: Float, statistic: Float, rate_hz: float, limit: float) -> Float:
    """Return the gyroscope's median at standstill, shape (3,), rad/s; zeros when there is too little of it."""
    still = statistic < limit
    if np.count_nonzero(still) < _BIAS_LONGEST_S * rate_hz:
        return np.zeros(3)
    return np.asarray(np.median(gyroscope_radps[still], axis=0))


def _windowed(values: Float, width: int) -> Float:
    total = np.cumsum(np.concatenate([np.zeros((1, values.shape[1])), values]), axis=0)
    return np.asarray((total[width:] - total[:-width]) / width)
