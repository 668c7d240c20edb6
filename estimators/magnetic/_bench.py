"""The bench on which a source is measured: where a sensor lay still, and the pulses that it saw there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.errors import ShapeError
from estimators.magnetic._pulses import extract_pulses
from estimators.recording import Float

_STILL_RATE_RADPS = 0.08
_STILL_FORCE_MPS2 = 0.4
_SMOOTH_S = 0.15
_SHORTEST_S = 1.0
_HAND_GONE_S = 0.2
"""At both ends of a stop: a hand still touches the sensor."""
_LEAST_PULSES = 3


@dataclass(frozen=True)
class Stop:
    """A stretch in which the sensor lay still.

    Attributes
    ----------
    start, stop : int
        Ticks, half open.
    pulses_t : ndarray, shape (C, 3)
        Mean pulse of each coil in sensor axes, as at `current_a`; NaN of a coil that did not fire.
    current_a : ndarray, shape (C,)
        Mean current; NaN likewise.
    count : ndarray of int, shape (C,)
        Pulses in each mean.
    sigma_t : float
        Standard error of a mean, all axes, from the spread of the pulses.
    saturated : bool
        A pulse was at the magnetometer's limit; it is left out.
    """

    start: int
    stop: int
    pulses_t: Float
    current_a: Float
    count: NDArray[np.int64]
    sigma_t: float
    saturated: bool


def find_stops(
    gyroscope_radps: ArrayLike,
    accelerometer_mps2: ArrayLike,
    magnetometer_t: ArrayLike,
    coil: ArrayLike,
    current_a: ArrayLike,
    time_step_s: float,
    full_scale_t: float = np.inf,
    coils: int = 3,
) -> list[Stop]:
    """Find where the sensor lay still while every coil fired, and the mean pulse of each coil there.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2, magnetometer_t : array_like, shape (N, 3)
        Of the sensor, own axes; NaN where nothing was measured.
    coil, current_a : array_like, shape (N,)
        What the source did: 0 off, else from 1.
    full_scale_t : float
        Of the magnetometer.

    Returns
    -------
    list of Stop
        In the order of time; stretches without a pulse of every coil are no stops.
    """
    gyroscope = np.asarray(gyroscope_radps, dtype=np.float64)
    force = np.asarray(accelerometer_mps2, dtype=np.float64)
    field = np.asarray(magnetometer_t, dtype=np.float64)
    number, current = np.asarray(coil), np.asarray(current_a, dtype=np.float64)
    count = len(number)
    if gyroscope.shape != (count, 3) or force.shape != (count, 3) or field.shape != (count, 3):
        raise ShapeError("gyroscope, accelerometer and magnetometer need shape (N, 3), the coils shape (N,)")
    pulses = extract_pulses(field, number, current, None, full_scale_t=full_scale_t)
    found = []
    for start, stop in _still(gyroscope, force, time_step_s):
        here = [one for one in pulses if one.start >= start and one.stop <= stop and one.coil < coils]
        usable = [one for one in here if not one.saturated]
        per_ampere = [
            np.array([one.field_sensor_t / one.current_a for one in usable if one.coil == k])
            for k in range(coils)
        ]
        if not all(len(values) for values in per_ampere):
            continue
        currents = np.array(
            [np.mean([one.current_a for one in usable if one.coil == k]) for k in range(coils)]
        )
        means = np.stack([values.mean(axis=0) for values in per_ampere])
        spread = [
            (values - values.mean(axis=0)) * abs(ampere)
            for values, ampere in zip(per_ampere, currents, strict=True)
        ]
        freedom = 3 * sum(len(values) - 1 for values in per_ampere)
        assumed = np.sqrt(np.mean([one.covariance[0, 0] for one in usable]))
        single = assumed
        if len(usable) >= coils * _LEAST_PULSES:
            single = max(assumed, float(np.sqrt(sum(np.sum(values**2) for values in spread) / freedom)))
        fewest = min(len(values) for values in per_ampere)
        found.append(
            Stop(
                start,
                stop,
                means * currents[:, None],
                currents,
                np.array([len(values) for values in per_ampere], dtype=np.int64),
                float(single / np.sqrt(fewest)),
                len(usable) < len(here),
            )
        )
    return found


def _still(gyroscope: Float, force: Float, time_step_s: float) -> list[tuple[int, int]]:
    """Return stretches in which the sensor neither turned nor was pushed."""
    finite = np.isfinite(gyroscope) & np.isfinite(force)
    measured: NDArray[np.bool_] = np.asarray(finite.all(axis=1))
    if not measured.any():
        return []
    width = max(1, round(_SMOOTH_S / time_step_s))
    # Most of the time it lies: the median is what the gyroscope reads at rest.
    rate = np.where(measured[:, None], gyroscope - np.median(gyroscope[measured], axis=0), np.inf)
    turned = _moving_mean(np.linalg.norm(rate, axis=1), width)
    size = np.where(measured, np.linalg.norm(force, axis=1), np.inf)
    pushed = np.abs(_moving_mean(size, width) - np.median(size[measured]))
    is_still = (turned < _STILL_RATE_RADPS) & (pushed < _STILL_FORCE_MPS2)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(is_still, dtype=np.int64), [0]])))
    margin = round(_HAND_GONE_S / time_step_s)
    return [
        (int(start) + margin, int(stop) - margin)
        for start, stop in zip(edges[::2], edges[1::2], strict=True)
        if stop - start - 2 * margin >= _SHORTEST_S / time_step_s
    ]


def _moving_mean(values: Float, width: int) -> Float:
    """Return the mean of `width` values about each; infinite where one is."""
    wrong = ~np.isfinite(values)
    kernel = np.full(width, 1.0 / width)
    mean = np.convolve(np.where(wrong, 0.0, values), kernel, mode="same")
    near = np.convolve(wrong, np.ones(width), mode="same") > 0.5
    return np.asarray(np.where(near, np.inf, mean))
