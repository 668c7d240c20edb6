"""Measures of quiet standing and of reaching, each with its uncertainty."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
import scipy

from estimators.balance.sway._posture import lean_noise, sway_lean
from estimators.balance.sway._spectrum import SwayMeasure, SwaySpectrum, sway_spectrum, white_floor
from estimators.errors import ShapeError
from estimators.recording import Float

HIGHEST_SWAY_HZ: Final = 3.5
"""Above, nothing counts as sway (Mancini et al. 2012)."""
SHORTEST_S: Final = 10.0
"""Of a trial: shorter ones hold too few sways."""
_LOWEST_HZ: Final = 0.15
"""Below, a trial of half a minute holds too few cycles for a frequency (Prieto et al. 1996)."""
ELLIPSE_RADIUS: Final = math.sqrt(-2.0 * math.log(0.05))
"""Deviations that hold 95 % of a normal distribution in the plane; its square is 5.99, Prieto's 2 F(0.05; 2, n - 2)."""
_REST_S: Final = 1.0
_UNKNOWN: Final = math.nan


@dataclass(frozen=True)
class Trial:
    """What one sensor measured during one trial of quiet standing.

    Attributes
    ----------
    acceleration_mps2 : ndarray, shape (N, 2)
        Forward and left, from `sway_acceleration`; finite.
    rate_radps : ndarray, shape (N, 2)
        How fast it leans forward and left, as the gyroscope reads it; finite.
    sensor_height_m, height_m : float
        Above the ankles: of the sensor, and of the point of which displacement is given.
    """

    acceleration_mps2: Float
    rate_radps: Float
    rate_hz: float
    sensor_height_m: float
    height_m: float

    def __post_init__(self) -> None:
        shapes = self.acceleration_mps2.shape, self.rate_radps.shape
        if shapes[0] != shapes[1] or shapes[0][1:] != (2,):
            raise ShapeError(f"acceleration and rate have shapes {shapes}; both must be (N, 2)")
        if self.seconds < SHORTEST_S:
            raise ShapeError(f"{self.seconds:.1f} s are too short for sway; {SHORTEST_S} s are needed")

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return len(self.rate_radps) / self.rate_hz

    @cached_property
    def place_m(self) -> Float:
        """Where the point sways forward and left, shape (N, 2), m: height times `sway_lean`, mean removed."""
        return self.height_m * sway_lean(
            self.acceleration_mps2, self.rate_radps, self.rate_hz, self.sensor_height_m
        )

    @property
    def shown_m(self) -> Float:
        """The same way without what lies above 3.5 Hz, for a picture."""
        return _smoothed(self.place_m, self.rate_hz)

    def turned(self, axes: Float) -> "Trial":
        """Return the trial along other horizontal directions, the columns of `axes`, shape (2, 2)."""
        return replace(
            self, acceleration_mps2=self.acceleration_mps2 @ axes, rate_radps=self.rate_radps @ axes
        )

    def accelerations(self) -> SwaySpectrum:
        """Return the spectrum of acceleration, (m/s^2)^2."""
        floor = white_floor(self.acceleration_mps2, self.rate_hz)
        return sway_spectrum(self.acceleration_mps2, self.rate_hz, HIGHEST_SWAY_HZ, lambda _: floor)

    def places(self) -> SwaySpectrum:
        """Return the spectrum of displacement, m^2."""
        floors = [white_floor(one, self.rate_hz) for one in (self.acceleration_mps2, self.rate_radps)]

        def noise(frequency_hz: Float) -> Float:
            return self.height_m**2 * lean_noise(frequency_hz, self.sensor_height_m, *floors)

        return sway_spectrum(self.place_m, self.rate_hz, HIGHEST_SWAY_HZ, noise)


@dataclass(frozen=True)
class Ellipse:
    """The ellipse that holds 95 % of the places of `Trial.shown_m`.

    Attributes
    ----------
    long_m, short_m : float
        Half of its axes.
    angle_rad : float
        From forward to the longer axis, to the left.
    """

    long_m: float
    short_m: float
    angle_rad: float


def sway_ellipse(trial: Trial) -> Ellipse:
    """Return the ellipse to draw over the way of a trial; the measure `ellipse_area` is freed of noise besides."""
    spread, axes = np.linalg.eigh(np.cov(trial.shown_m.T))
    short, long = ELLIPSE_RADIUS * np.sqrt(np.maximum(spread, 0.0))
    return Ellipse(float(long), float(short), math.atan2(axes[1, 1], axes[0, 1]))


def sway_measures(trial: Trial) -> dict[str, SwayMeasure]:
    """Return the measures of one trial of quiet standing by name.

    Returns
    -------
    dict of str to SwayMeasure
        `acceleration_rms`, `acceleration_rms_forward`, `acceleration_rms_sideways` : m/s^2
            Root of the mean square of `sway_acceleration`, of both directions and of each (Mancini et al. 2012: RMS).
        `jerk_rms` : m/s^3
            Root of the mean square of its derivative; the ISway's JERK is half its square times the duration.
        `median_frequency`, `frequency_95` : Hz
            Below which half and 95 % of the power of both directions between 0.15 and 3.5 Hz lie (F50, F95).
        `displacement_rms_forward`, `displacement_rms_sideways` : m
            Of the point at `height_m` (`Trial.place_m`): Prieto et al. (1996) RDIST of each direction.
        `path_length` : m, `sway_speed` : m/s
            Way of that point over the trial, and that over its duration (TOTEX and MVELO).
        `ellipse_area` : m^2
            Of the ellipse that holds 95 % of its places, `5.99 pi sqrt(det C)` (AREA-CE).

    Notes
    -----
    Everything is below 3.5 Hz. Variances are sums over the spectrum with sensor noise subtracted, along the principal
    axes, in which the directions are not correlated. The way along the path is shortened by the share of noise in the
    variance of speed. Sigma follows from that of the sums (`SwaySpectrum.sum`), by the delta method; that of a
    frequency from the sigma of the share of power below it, and the step of frequency.
    """
    along, places = trial.accelerations(), trial.places()
    across = trial.turned(_principal(trial.acceleration_mps2)).accelerations()
    axes = trial.turned(_principal(trial.place_m)).places()
    forward, sideways = _roots(along, "m/s^2")
    ahead, aside = _roots(places, "m")
    speed = _speed(trial, axes)
    return {
        "acceleration_rms": _root(*_together(across), "m/s^2"),
        "acceleration_rms_forward": forward,
        "acceleration_rms_sideways": sideways,
        "jerk_rms": _root(*_together(across, 1), "m/s^3"),
        "median_frequency": _frequency(across, 0.5),
        "frequency_95": _frequency(across, 0.95),
        "displacement_rms_forward": ahead,
        "displacement_rms_sideways": aside,
        "path_length": SwayMeasure(speed.value * trial.seconds, speed.sigma * trial.seconds, "m"),
        "sway_speed": speed,
        "ellipse_area": _ellipse(axes),
    }


def romberg_ratio(closed: SwayMeasure, opened: SwayMeasure) -> SwayMeasure:
    """Return a measure with eyes closed over the same with eyes open.

    Parameters
    ----------
    closed, opened : SwayMeasure
        Of the same measure and surface.

    Returns
    -------
    SwayMeasure
        Without unit; `sigma = r sqrt((s_c / m_c)^2 + (s_o / m_o)^2)`, as trials are independent. NaN where the sway
        with eyes open is not above zero.

    Notes
    -----
    Romberg's quotient (Njiokiktjien and Van Parys 1976): above 1 vision steadies this person.
    """
    if not opened.value > 0.0 or not closed.value > 0.0:
        return SwayMeasure(_UNKNOWN, _UNKNOWN, "1")
    ratio = closed.value / opened.value
    relative = math.hypot(closed.sigma / closed.value, opened.sigma / opened.value)
    return SwayMeasure(ratio, ratio * relative, "1")


@dataclass(frozen=True)
class Reach:
    """How far somebody leaned in one reach.

    Attributes
    ----------
    lean : SwayMeasure
        Largest inclination against that of the first second, rad.
    displacement : SwayMeasure
        Way forward of a point at the stated height, taking the body for one stiff link, m.
    peak_s : float
        When, since the beginning of the trial.
    """

    lean: SwayMeasure
    displacement: SwayMeasure
    peak_s: float


def reach(forward_lean_rad: Float, sigma_rad: Float, rate_hz: float, height_m: float) -> Reach:
    """Return the largest forward lean of a trial that begins upright (functional reach, Duncan et al. 1990).

    Parameters
    ----------
    forward_lean_rad : ndarray, shape (N,)
        From `posture`; finite.
    sigma_rad : ndarray, shape (N,)
        Its one-sigma at each tick.
    rate_hz, height_m : float
        Height of the point of which the way is given, above the ankles.

    Returns
    -------
    Reach
        Sigma joins that of the orientation at rest and at the peak, and how much the first second swayed.

    Raises
    ------
    ShapeError
        Fewer than two seconds.
    """
    rest = max(round(_REST_S * rate_hz), 2)
    if len(forward_lean_rad) < 2 * rest:
        raise ShapeError(f"{len(forward_lean_rad) / rate_hz:.1f} s are too short for a reach")
    smooth = _smoothed(forward_lean_rad, rate_hz)
    base = float(np.mean(smooth[:rest]))
    top = int(np.argmax(smooth))
    sigma = math.sqrt(
        float(np.mean(sigma_rad[:rest] ** 2)) + float(sigma_rad[top] ** 2) + float(np.var(smooth[:rest]))
    )
    lean = float(smooth[top]) - base
    way = height_m * (math.sin(float(smooth[top])) - math.sin(base))
    return Reach(
        SwayMeasure(lean, sigma, "rad"),
        SwayMeasure(way, height_m * math.cos(float(smooth[top])) * sigma, "m"),
        top / rate_hz,
    )


def _principal(values: Float) -> Float:
    """Return the principal axes of two directions as columns, shape (2, 2)."""
    return np.asarray(np.linalg.eigh(np.cov(values.T))[1])


def _together(spectrum: SwaySpectrum, order: int = 0) -> tuple[float, float]:
    total, variance = spectrum.sum(order)
    return float(total.sum()), float(variance.sum())


def _root(total: float, variance: float, unit: str) -> SwayMeasure:
    """Return the root of a sum; its sigma by the delta method."""
    if not total > 0.0:
        return SwayMeasure(_UNKNOWN, _UNKNOWN, unit)
    return SwayMeasure(math.sqrt(total), 0.5 * math.sqrt(variance / total), unit)


def _roots(spectrum: SwaySpectrum, unit: str) -> tuple[SwayMeasure, SwayMeasure]:
    total, variance = spectrum.sum()
    return (
        _root(float(total[0]), float(variance[0]), unit),
        _root(float(total[1]), float(variance[1]), unit),
    )


def _ellipse(axes: SwaySpectrum) -> SwayMeasure:
    (small, large), variance = axes.sum()
    if not (small > 0.0 and large > 0.0):
        return SwayMeasure(_UNKNOWN, _UNKNOWN, "m^2")
    area = ELLIPSE_RADIUS**2 * math.pi * math.sqrt(small * large)
    return SwayMeasure(
        area, 0.5 * area * math.hypot(math.sqrt(variance[0]) / small, math.sqrt(variance[1]) / large), "m^2"
    )


def _speed(trial: Trial, axes: SwaySpectrum) -> SwayMeasure:
    """Return the mean speed along the smoothed path, freed of the share of noise in its variance."""
    total, variance = _together(axes, 1)
    noisy, _ = _together(replace(axes, power=axes.raw), 1)
    if not total > 0.0:
        return SwayMeasure(_UNKNOWN, _UNKNOWN, "m/s")
    way = np.diff(trial.shown_m, axis=0)
    value = float(np.mean(np.linalg.norm(way, axis=1))) * trial.rate_hz * math.sqrt(total / noisy)
    return SwayMeasure(value, 0.5 * value * math.sqrt(variance) / total, "m/s")


def _smoothed(values: Float, rate_hz: float) -> Float:
    sections = scipy.signal.butter(4, HIGHEST_SWAY_HZ, fs=rate_hz, output="sos")
    return np.asarray(scipy.signal.sosfiltfilt(sections, values, axis=0))


def _frequency(spectrum: SwaySpectrum, share: float) -> SwayMeasure:
    """Return the frequency below which a share of the power lies."""
    inside = spectrum.frequency_hz >= _LOWEST_HZ
    frequency, power = spectrum.frequency_hz[inside], spectrum.power[inside].sum(axis=1)
    total = float(power.sum())
    if not total > 0.0:
        return SwayMeasure(_UNKNOWN, _UNKNOWN, "Hz")
    # Noise subtracted can make a step negative: what lies below must not fall.
    below = np.maximum.accumulate(np.cumsum(power) / total)
    at = float(np.interp(share, below, frequency))
    moved = (frequency <= at).astype(np.float64) - share
    sigma = math.sqrt(spectrum.taper_cost * float((moved**2 @ spectrum.squared[inside]).sum())) / total
    low, high = np.interp([share - sigma, share + sigma], below, frequency)
    return SwayMeasure(at, float(np.hypot(0.5 * (high - low), frequency[1] - frequency[0])), "Hz")
