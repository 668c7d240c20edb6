"""Roetenberg's detector of magnetic disturbance (method page 2.4 and 2.5) over sensors side by side, compiled."""

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._lanes import LANES_TYPE, at_least, chosen, column, in_lanes, put_column
from estimators.orientation import _roetenberg_layout as at
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_SMOOTH_NORM, _SMOOTH_DIP, _LAST_NORM, _LAST_DIP = at.SMOOTH_NORM, at.SMOOTH_DIP, at.LAST_NORM, at.LAST_DIP
_REFERENCE_DIP = at.REFERENCE_DIP
_NOMINAL, _MISMATCH, _DETECTING, _PINNED = at.NOMINAL, at.MISMATCH, at.DETECTING, at.PINNED
_COMPENSATE, _RAW_DETECTOR, _FLOOR_VARIANCE = at.COMPENSATE, at.RAW_DETECTOR, at.FLOOR_VARIANCE
_SMOOTHING, _DEAD_BAND, _NORM_GAIN, _DIP_GAIN = at.SMOOTHING, at.DEAD_BAND, at.NORM_GAIN, at.DIP_GAIN
_NOMINAL_NORM, _NOMINAL_DIP, _NOMINAL_TICKS = at.NOMINAL_NORM, at.NOMINAL_DIP, at.NOMINAL_TICKS
_GUARD_NORM, _GUARD_DIP = at.GUARD_NORM, at.GUARD_DIP
_MEASURED, _IS_NOMINAL, _IS_FOREIGN, _HELD = at.MEASURED, at.IS_NOMINAL, at.IS_FOREIGN, at.HELD
_L, _I, _ROWS = LANES_TYPE, types.intp, types.float64[:, ::1]


@in_lanes(types.void(_I, _I, _ROWS, types.int64[:, ::1], _ROWS, types.float64[::1]))
def count_fields(
    first: int, last: int, memory: Float, counters: NDArray[np.int64], samples: Float, settings: Float
) -> None:
    """Count samples of nominal and of foreign field, and hold a disturbance to nothing after enough of the former."""
    for s in range(first, last + 1):
        if samples[s - first, _MEASURED] > 0.0:
            nominal = counters[s, _NOMINAL] + 1 if samples[s - first, _IS_NOMINAL] > 0.0 else 0
            counters[s, _NOMINAL] = nominal
            counters[s, _MISMATCH] = (
                counters[s, _MISMATCH] + 1 if samples[s - first, _IS_FOREIGN] > 0.0 else 0
            )
            pinned = settings[_COMPENSATE] == 0.0 or nominal >= settings[_NOMINAL_TICKS]
            counters[s, _PINNED] = 1 if pinned else 0
        samples[s - first, _HELD] = counters[s, _PINNED]


@in_lanes(_L(_I, _I, _ROWS, types.int64[:, ::1], _ROWS, types.float64[::1], _L, _L))
def detect(
    first: int,
    last: int,
    memory: Float,
    counters: NDArray[np.int64],
    samples: Float,
    settings: Float,
    norm: float,
    dip: float,
) -> float:
    """Return the variance by which the disturbance may have changed since the last sample (page 2.4).

    Takes the norm of the field over that of the reference, and its dip; `samples` says where they were measured.
    Also counts samples of nominal and of foreign field.
    """
    measured = column(samples, (0, last - first, _MEASURED)) > 0.0
    smooth_norm, smooth_dip = (
        column(memory, (first, last, _SMOOTH_NORM)),
        column(memory, (first, last, _SMOOTH_DIP)),
    )
    last_norm, last_dip = column(memory, (first, last, _LAST_NORM)), column(memory, (first, last, _LAST_DIP))
    detecting = True
    for s in range(first, last + 1):
        detecting &= counters[s, _DETECTING] != 0
        samples[s - first, _HELD] = counters[s, _DETECTING]
    if not detecting:
        fresh = measured & (column(samples, (0, last - first, _HELD)) <= 0.0)
        smooth_norm, smooth_dip = chosen(fresh, norm, smooth_norm), chosen(fresh, dip, smooth_dip)
        last_norm, last_dip = chosen(fresh, norm, last_norm), chosen(fresh, dip, last_dip)
        for s in range(first, last + 1):
            if samples[s - first, _MEASURED] > 0.0:
                counters[s, _DETECTING] = 1
    norm_step, dip_step = (
        settings[_SMOOTHING] * (norm - smooth_norm),
        settings[_SMOOTHING] * (dip - smooth_dip),
    )
    smooth_norm, smooth_dip = (
        chosen(measured, smooth_norm + norm_step, smooth_norm),
        chosen(measured, smooth_dip + dip_step, smooth_dip),
    )
    band = settings[_DEAD_BAND]
    if settings[_RAW_DETECTOR] > 0.0:
        norm_step, dip_step, band = norm - last_norm, dip - last_dip, 0.0
    put_column(memory, (first, last, _SMOOTH_NORM), smooth_norm)
    put_column(memory, (first, last, _SMOOTH_DIP), smooth_dip)
    put_column(memory, (first, last, _LAST_NORM), chosen(measured, norm, last_norm))
    put_column(memory, (first, last, _LAST_DIP), chosen(measured, dip, last_dip))
    change = settings[_NORM_GAIN] * at_least(abs(norm_step) - band, 0.0)
    change += settings[_DIP_GAIN] * at_least(abs(dip_step) - band, 0.0)
    norm_off = abs(smooth_norm - 1.0)
    dip_off = abs(smooth_dip - column(memory, (first, last, _REFERENCE_DIP)))
    nominal = (norm_off < settings[_NOMINAL_NORM]) & (dip_off < settings[_NOMINAL_DIP])
    foreign = (norm_off > settings[_GUARD_NORM]) | (dip_off > settings[_GUARD_DIP])
    put_column(samples, (0, last - first, _IS_NOMINAL), chosen(nominal, 1.0, 0.0))
    put_column(samples, (0, last - first, _IS_FOREIGN), chosen(foreign, 1.0, 0.0))
    floor = settings[_FLOOR_VARIANCE]
    return chosen(measured, floor + change * change, floor)


__all__ = ["count_fields", "detect"]
