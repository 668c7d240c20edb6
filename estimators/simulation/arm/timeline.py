"""Postures over time: minimum-jerk transitions, sway and tremor, with exact derivatives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.simulation.arm.kinematics import Scalar

Float = NDArray[np.float64]


def minimum_jerk(phase: Float) -> Scalar:
    """Return the minimum-jerk step from 0 to 1 over phase 0 to 1, constant outside.

    Notes
    -----
    Flash and Hogan (1985): 10 u^3 - 15 u^4 + 6 u^5. Rate and acceleration vanish at both ends, so
    transitions join with continuous acceleration.
    """
    u = np.clip(phase, 0.0, 1.0)
    rest = 1.0 - u
    return Scalar(
        u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * u**2 * rest**2, 60.0 * u * rest * (1.0 - 2.0 * u)
    )


def quintic(knot_s: Float, knots: Float, time_s: Float) -> Scalar:
    """Return quintic pieces through values, rates and accelerations at knots; held before and after.

    Parameters
    ----------
    knot_s : ndarray, shape (M,)
        Increasing.
    knots : ndarray, shape (M, 3) or (M, 3, C)
        Value, rate and acceleration at each knot.
    time_s : ndarray, shape (N,)

    Returns
    -------
    Scalar
        Each part of shape (N,) or (N, C).
    """
    index = np.clip(np.searchsorted(knot_s, time_s, side="right") - 1, 0, knot_s.size - 2)
    inside = (time_s >= knot_s[0]) & (time_s <= knot_s[-1])
    shape = (-1,) + (1,) * (knots.ndim - 2)
    width = np.diff(knot_s)[index].reshape(shape)
    u = (np.clip(time_s, knot_s[0], knot_s[-1]) - knot_s[index]).reshape(shape) / width
    start, rate = knots[index, 0], width * knots[index, 1]
    half = 0.5 * width**2 * knots[index, 2]
    gap = knots[index + 1, 0] - start - rate - half
    slope = width * knots[index + 1, 1] - rate - 2.0 * half
    bend = width**2 * knots[index + 1, 2] - 2.0 * half
    third = 10.0 * gap - 4.0 * slope + 0.5 * bend
    fourth = -15.0 * gap + 7.0 * slope - bend
    fifth = 6.0 * gap - 3.0 * slope + 0.5 * bend
    value = start + u * (rate + u * (half + u * (third + u * (fourth + u * fifth))))
    first = rate + u * (2.0 * half + u * (3.0 * third + u * (4.0 * fourth + u * 5.0 * fifth)))
    second = 2.0 * half + u * (6.0 * third + u * (12.0 * fourth + u * 20.0 * fifth))
    moving = inside.reshape(shape)
    return Scalar(value, np.where(moving, first / width, 0.0), np.where(moving, second / width**2, 0.0))


def submovements(phase: Float, count: NDArray[np.int64]) -> Scalar:
    """Return a step from 0 to 1 made of `count` overlapping minimum-jerk steps, sample by sample.

    Impaired reaches are sequences of short submovements with dips of speed between them (Rohrer et al.
    2002, J. Neurosci. 22:8297); they overlap by a fifth to a third here, so that the dips are seen.

    Parameters
    ----------
    phase : ndarray, shape (N,)
    count : ndarray of int, shape (N,)
        At least 1.
    """
    width = np.where(count == 1, 1.0, 1.2 / np.maximum(count, 1))
    delay = (1.0 - width) / np.maximum(count - 1, 1)
    total = Scalar(np.zeros_like(phase), np.zeros_like(phase), np.zeros_like(phase))
    for number in range(int(count.max(initial=1))):
        part = minimum_jerk((phase - number * delay) / width)
        weight = (number < count) / count
        total = Scalar(
            total.value + weight * part.value,
            total.rate + weight * part.rate / width,
            total.acceleration + weight * part.acceleration / width**2,
        )
    return total


@dataclass(frozen=True)
class Sinusoids:
    """A sum of sines on some coordinates, faded in by a minimum-jerk step.

    Attributes
    ----------
    columns : tuple of int
        Coordinates that it is added to.
    amplitude, frequency_hz, phase_rad : ndarray, shape (len(columns), J)
    fade_start_s, fade_s : float
        Zero before, full after; a start of -inf means always full.
    """

    columns: tuple[int, ...]
    amplitude: Float
    frequency_hz: Float
    phase_rad: Float
    fade_start_s: float = -np.inf
    fade_s: float = 1.0

    def at(self, time_s: Float) -> list[Scalar]:
        """Return one Scalar a column, each over `time_s`, shape (N,)."""
        if np.isfinite(self.fade_start_s):
            step = minimum_jerk((time_s - self.fade_start_s) / self.fade_s)
            fade = Scalar(step.value, step.rate / self.fade_s, step.acceleration / self.fade_s**2)
        else:
            fade = Scalar(np.ones_like(time_s), np.zeros_like(time_s), np.zeros_like(time_s))
        result = []
        for row in range(len(self.columns)):
            value, rate, acceleration = (np.zeros_like(time_s) for _ in range(3))
            for a, f, p in zip(self.amplitude[row], self.frequency_hz[row], self.phase_rad[row], strict=True):
                pulse = 2.0 * np.pi * f
                sine, cosine = np.sin(pulse * time_s + p), np.cos(pulse * time_s + p)
                value += a * sine
                rate += a * pulse * cosine
                acceleration -= a * pulse**2 * sine
            result.append(
                Scalar(
                    fade.value * value,
                    fade.rate * value + fade.value * rate,
                    fade.acceleration * value + 2.0 * fade.rate * rate + fade.value * acceleration,
                )
            )
        return result


def sway(columns: tuple[int, ...], rms: float, rng: np.random.Generator) -> Sinusoids:
    """Return the small slow wander of a standing person: three sines of 0.1 to 0.6 Hz a coordinate."""
    shape = (len(columns), 3)
    # A sine of amplitude a has RMS a / sqrt(2); three of equal size add up in quadrature.
    amplitude = np.full(shape, rms * np.sqrt(2.0 / 3.0))
    return Sinusoids(columns, amplitude, rng.uniform(0.1, 0.6, shape), rng.uniform(0.0, 2.0 * np.pi, shape))


@dataclass(frozen=True)
class Timeline:
    """Coordinates that go from posture to posture.

    Attributes
    ----------
    knot_s : ndarray, shape (M,)
        Increasing times at which the postures are reached.
    posture : ndarray, shape (M, C)
        Two equal neighbours are a hold.
    submovement_count : ndarray of int, shape (M - 1,)
        Of each transition.
    """

    knot_s: Float
    posture: Float
    submovement_count: NDArray[np.int64]
    wander: tuple[Sinusoids, ...] = ()

    def at(self, time_s: Float) -> list[Scalar]:
        """Return every coordinate over `time_s`, shape (N,); any times, in any order."""
        index = np.clip(np.searchsorted(self.knot_s, time_s, side="right") - 1, 0, len(self.knot_s) - 2)
        duration = (self.knot_s[1:] - self.knot_s[:-1])[index]
        step = submovements((time_s - self.knot_s[index]) / duration, self.submovement_count[index])
        change = np.diff(self.posture, axis=0)
        coordinates = [
            Scalar(
                self.posture[index, c] + change[index, c] * step.value,
                change[index, c] * step.rate / duration,
                change[index, c] * step.acceleration / duration**2,
            )
            for c in range(self.posture.shape[1])
        ]
        for part in self.wander:
            for column, extra in zip(part.columns, part.at(time_s), strict=True):
                held = coordinates[column]
                coordinates[column] = Scalar(
                    held.value + extra.value, held.rate + extra.rate, held.acceleration + extra.acceleration
                )
        return coordinates
