"""Smoothness and speed profile: spectral arc length, movement units, peak speed."""

import functools

import numpy as np
import scipy

from estimators.recording import Float

CUT_OFF_HZ = 10.0
AMPLITUDE_THRESHOLD = 0.05
PAD_LEVEL = 4
UNIT_RISE_MPS = 0.02
"""Smallest rise of speed that counts as a movement unit (Alt Murphy et al. 2011)."""
UNIT_RISE_RADPS = 0.07
"""The same for a turning movement: 2 cm/s at 0.3 m."""
UNIT_SPACING_S = 0.15


def spectral_arc_length(speed: Float, rate_hz: float) -> float:
    """Return the smoothness of a speed profile: the negative length of its normalised spectrum.

    Parameters
    ----------
    speed : ndarray, shape (N,)
        Any unit; only the shape counts.

    Returns
    -------
    float
        Dimensionless, below zero; nearer to zero is smoother. One minimum-jerk movement gives -1.41
        whatever its duration and size. NaN when nothing moves or the profile is too short.

    Notes
    -----
    SPARC of Balasubramanian, Melendez-Calderon, Roby-Brami and Burdet 2015, J NeuroEng Rehabil 12:112,
    with its parameters: the band ends at 10 Hz or where the magnitude last exceeds 5 percent of its
    maximum, whichever is lower (the adaptive cut-off); the transform is zero-padded four octaves above
    the length of the signal.
    """
    samples = len(speed)
    if samples < 8 or not np.isfinite(speed).all() or not speed.any():
        return float("nan")
    points = 2 ** (int(np.ceil(np.log2(samples))) + PAD_LEVEL)
    magnitude = np.abs(np.fft.rfft(speed, points))
    frequency_hz, step_hz = _band(points, rate_hz)
    # Of what is above the band nothing but its maximum counts.
    magnitude = magnitude[: len(frequency_hz)] / magnitude.max()
    inside = (magnitude >= AMPLITUDE_THRESHOLD).nonzero()[0]
    first, last = int(inside[0]), int(inside[-1])
    width_hz = frequency_hz[last] - frequency_hz[first]
    if width_hz <= 0:
        return float("nan")
    rise = magnitude[first + 1 : last + 1] - magnitude[first:last]
    return -float(np.hypot(step_hz[first:last] / width_hz, rise).sum())


@functools.lru_cache(maxsize=64)
def _band(points: int, rate_hz: float) -> tuple[Float, Float]:
    """Return the frequencies of a transform up to the cut-off, and their steps: the same for all of its length, Hz."""
    frequency_hz: Float = np.asarray(np.fft.rfftfreq(points, 1.0 / rate_hz))
    frequency_hz = frequency_hz[: int(np.searchsorted(frequency_hz, CUT_OFF_HZ, side="right"))]
    return frequency_hz, np.asarray(np.diff(frequency_hz))


def noise_level(speed: Float, rate_hz: float) -> float:
    """Return the standard deviation of what moves faster than people do (above `CUT_OFF_HZ`).

    Scaled to the whole band, taking the noise as white; NaN where the rate shows nothing above it.
    """
    return float(noise_levels(speed[None], rate_hz)[0])


def noise_levels(signals: Float, rate_hz: float) -> Float:
    """Return `noise_level` of several signals of the same ticks, shape (S, N): shape (S,)."""
    samples = signals.shape[1]
    if samples < 16 or rate_hz <= 2.4 * CUT_OFF_HZ:
        return np.full(len(signals), np.nan)
    window = np.hanning(samples)
    signals = np.ascontiguousarray(signals)
    spectrum = np.fft.rfft((signals - signals.mean(axis=1, keepdims=True)) * window, axis=1)
    frequency_hz = np.fft.rfftfreq(samples, 1.0 / rate_hz)
    power = np.abs(spectrum[:, int(np.searchsorted(frequency_hz, CUT_OFF_HZ, side="right")) :]) ** 2
    # rfft power per bin of white noise with variance s^2 is s^2 * sum(window^2).
    return np.asarray(np.sqrt(power.mean(axis=1) / np.sum(window**2)))


def spectral_arc_length_uncertainty(
    speed: Float, rate_hz: float, level: float | None = None, draws: int = 8
) -> float:
    """Return how far sensor noise alone moves the spectral arc length, one standard deviation.

    Noise of the level found in the profile itself, which is `level` where it is known already, is added again `draws`
    times with a fixed seed.
    """
    if level is None:
        level = noise_level(speed, rate_hz)
    if not np.isfinite(level):
        return float("nan")
    noise = np.random.default_rng(0).normal(0.0, level, (draws, len(speed)))
    return float(np.std([spectral_arc_length(one, rate_hz) for one in speed + noise], ddof=1))


def movement_units(speed: Float, rate_hz: float, rise: float = UNIT_RISE_MPS) -> int:
    """Count the separate pushes of a movement.

    A unit is a local maximum of speed that rises at least `rise` above the minimum before it, at least
    0.15 s after the last unit (Alt Murphy, Willen, Sunnerhagen 2011, Neurorehabil Neural Repair 25:71).
    """
    if len(speed) < 3:
        return 0
    padded = np.concatenate([[0.0], speed, [0.0]])
    peaks, _ = scipy.signal.find_peaks(
        padded, prominence=rise, distance=max(1, round(UNIT_SPACING_S * rate_hz))
    )
    return len(peaks)
