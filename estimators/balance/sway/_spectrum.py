"""Power of sway over frequency, freed of sensor noise, and how well its sums are known from one trial."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from estimators.recording import Float

_TAPER = 0.2
"""Share of the trial over which its ends fade (Tukey): slow sway would leak into all frequencies otherwise."""
_FLOOR = (0.30, 0.50)
"""Band of the noise floor, as a share of the rate: nobody sways there."""
_FLOOR_NEEDS_HZ = 40.0
"""Slower sampling leaves no such band free of sway."""
_LOWEST_STEPS = 3
_NEIGHBOURS = 5


@dataclass(frozen=True)
class SwayMeasure:
    """One number of a trial.

    Attributes
    ----------
    value : float
        In `unit`; NaN where it cannot be known.
    sigma : float
        One-sigma: this stretch of sway stands for all the sway of that person in that stance.
    """

    value: float
    sigma: float
    unit: str


@dataclass(frozen=True)
class SwaySpectrum:
    """Power of two horizontal directions over frequency.

    Attributes
    ----------
    frequency_hz : ndarray, shape (F,)
        Above 0, evenly spaced.
    power : ndarray, shape (F, 2)
        Variance in each step of frequency, unit of the signal squared, noise subtracted: single steps may be negative.
    raw : ndarray, shape (F, 2)
        The same with the noise.
    taper_cost : float
        What the taper costs: factor of the variance of sums, 1 without a taper.
    floor_steps : int
        Steps of frequency from which the noise was found.
    """

    frequency_hz: Float
    power: Float
    raw: Float
    taper_cost: float
    floor_steps: int

    def sum(self, order: int = 0) -> tuple[Float, Float]:
        """Return the variance of the signal in each direction and how far that is uncertain, both shape (2,).

        Parameters
        ----------
        order : int
            0 for the signal, 1 for its derivative: power times `(2 pi f)^(2 order)`.

        Returns
        -------
        total, variance : ndarray, shape (2,)
            The second is the square of the sigma of the first.

        Notes
        -----
        Removing the mean of a trial takes the half step at frequency 0 away; it is put back as the mean of the lowest
        three. Ordinates of a periodogram are independent and exponentially distributed about the spectrum S, so that
        Var(sum w I) = c sum w^2 S^2 with c = N sum h^4 / (sum h^2)^2 of the taper h (Priestley 1981, 6.2). The noise
        found in M steps adds its own variance. The variance is known from 2 total^2 / variance degrees of freedom
        alone, hence its factor, that of Student's distribution.
        """
        w = (2.0 * np.pi * self.frequency_hz) ** (2 * order)
        if order == 0:
            w[:_LOWEST_STEPS] += 0.5 / _LOWEST_STEPS
        variance = self.taper_cost * (w**2 @ self.squared)
        total = w @ self.power
        variance = variance + (w @ (self.raw - self.power)) ** 2 / self.floor_steps
        return np.asarray(total), np.asarray(variance * (1.0 + variance / total**2))

    @property
    def squared(self) -> Float:
        """Squared spectrum with its noise, shape (F, 2), from the mean M of five neighbours: E[M^2] = S^2 (1 + 1/5)."""
        around = scipy.ndimage.uniform_filter1d(self.raw, _NEIGHBOURS, axis=0, mode="nearest")
        return np.asarray(around**2 / (1.0 + 1.0 / _NEIGHBOURS))


def white_floor(values: Float, rate_hz: float) -> Float:
    """Return the density of white sensor noise in a trial, shape (2,), unit of `values` squared per Hz.

    Parameters
    ----------
    values : ndarray, shape (N, 2)
        Evenly sampled.

    Notes
    -----
    Median power between 30 and 50 % of the rate over ln 2, the median of an exponential distribution. Sampled slower
    than 40 Hz it is 0: no such band is free of sway.
    """
    if rate_hz < _FLOOR_NEEDS_HZ:
        return np.zeros(2)
    frequency, density, _ = _periodogram(values, rate_hz)
    high = (frequency >= _FLOOR[0] * rate_hz) & (frequency < _FLOOR[1] * rate_hz)
    return np.asarray(np.median(density[high], axis=0) / np.log(2.0))


def sway_spectrum(
    values: Float, rate_hz: float, highest_hz: float, noise: Callable[[Float], Float]
) -> SwaySpectrum:
    """Return the spectrum of a trial up to a frequency, freed of sensor noise.

    Parameters
    ----------
    values : ndarray, shape (N, 2)
        Evenly sampled.
    highest_hz : float
        Nothing above counts as sway.
    noise : callable
        Density of the noise, shape (F, 2) or (2,), at frequencies of shape (F,).
    """
    frequency, density, cost = _periodogram(values, rate_hz)
    inside = (frequency > 0.0) & (frequency <= highest_hz)
    step = float(frequency[1])
    raw = density[inside] * step
    return SwaySpectrum(
        frequency_hz=frequency[inside],
        power=raw - noise(frequency[inside]) * step,
        raw=raw,
        taper_cost=cost,
        floor_steps=round((_FLOOR[1] - _FLOOR[0]) * rate_hz / step),
    )


def _periodogram(values: Float, rate_hz: float) -> tuple[Float, Float, float]:
    """Return frequencies, the one-sided density of each column, and what the taper costs."""
    count = len(values)
    taper = scipy.signal.windows.tukey(count, _TAPER)
    values = values - np.average(values, axis=0, weights=taper)
    density = np.abs(np.fft.rfft(values * taper[:, None], axis=0)) ** 2
    density *= 2.0 / (rate_hz * np.sum(taper**2))
    cost = float(count * np.sum(taper**4) / np.sum(taper**2) ** 2)
    frequency = np.asarray(np.fft.rfftfreq(count, 1.0 / rate_hz), dtype=np.float64)
    return frequency, np.asarray(density, dtype=np.float64), cost
