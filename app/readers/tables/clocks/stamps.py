"""Checks of time columns, and the rate that a device was set to."""

import numpy as np

from app.errors import RecordingFormatError
from estimators.recording import Float
from estimators.sentences import say

LOWEST_HZ, HIGHEST_HZ = 1.0, 4000.0
_EVEN, _APART = 1.5, 0.05
"""Steps: as far as stamps of an even rate stray that are coarse; a share: holes make the mean step longer."""
_FEW, _FINER = 20, 0.02
"""In steps, and a share."""
UNIT_FACTORS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def seconds_of(column: Float, unit: str, first_row: int = 2) -> Float:
    """Return a time column in seconds from its first value.

    Parameters
    ----------
    column : ndarray, shape (N,)
    unit : {"s", "ms", "us", "ns"}
    first_row : int
        Line of the file in which the first value stands, for messages.

    Raises
    ------
    RecordingFormatError
        A value is missing, time stands still or runs backwards, or the unit cannot be right.
    """
    if column.size < 2:
        raise RecordingFormatError(say("file.too_few_rows"))
    wrong = np.flatnonzero(~np.isfinite(column))
    if wrong.size:
        raise RecordingFormatError(
            say("file.no_time_in_row", row=int(wrong[0] + first_row)), row=int(wrong[0] + first_row)
        )
    steps = np.diff(column)
    wrong = np.flatnonzero(steps <= 0)
    if wrong.size:
        row = int(wrong[0] + first_row + 1)
        raise RecordingFormatError(
            say("file.time_stands_still", row=row)
            if steps[wrong[0]] == 0
            else say("file.time_backwards", row=row),
            row=row,
            count=int(wrong.size),
        )
    check_unit(float(np.median(steps)), unit)
    return np.asarray((column - column[0]) * UNIT_FACTORS[unit])


def check_unit(step: float, unit: str) -> None:
    """Refuse a time unit in which the rows come at a rate that no sensor has.

    Parameters
    ----------
    step : float
        Usual difference of two rows, as written.
    unit : {"s", "ms", "us", "ns"}
    """
    if unit in (fitting := units_of(step)):
        return
    advice = say("file.looks_like_unit", unit=fitting[0]) if fitting else say("file.check_time_unit")
    raise RecordingFormatError(
        say(
            "file.time_unit",
            unit=unit,
            rate_hz=1.0 / (step * UNIT_FACTORS[unit]),
            lowest_hz=LOWEST_HZ,
            highest_hz=HIGHEST_HZ,
            advice=advice,
        )
    )


def units_of(step: float) -> list[str]:
    """Return the units in which rows that are `step` apart come at a rate that sensors have."""
    if not step > 0.0:
        return []
    # A stamp in whole milliseconds makes 1000 Hz a little more now and then.
    return [
        unit
        for unit, factor in UNIT_FACTORS.items()
        if 0.999 * LOWEST_HZ <= 1.0 / (step * factor) <= 1.001 * HIGHEST_HZ
    ]


def nominal_rate(time_s: Float) -> float:
    """Return the rate that a device was set to: a whole number when the stamps say nearly that."""
    steps = np.diff(time_s)
    middle, mean = float(np.median(steps)), float(time_s[-1] - time_s[0]) / steps.size
    # In whole milliseconds the steps of 128 Hz are 7 and 8: their mean is right, without those of missing samples.
    usual = float(steps[(steps > 0.49 * middle) & (steps < 1.51 * middle)].mean())
    if (
        abs(mean / usual - 1.0) > _APART
        and np.abs(time_s - time_s[0] - mean * np.arange(time_s.size)).max() < _EVEN * middle
    ):
        # None is missing: of 800 Hz the steps are 1 and 2.
        usual = mean
    # Over small holes, too: of few steps of 2 and 3 ms there may be more of one.
    count = np.rint(steps / usual)
    near = (count > 0) & (count < _FEW)
    if abs(finer := float(steps[near].sum() / count[near].sum()) / usual - 1.0) < _FINER:
        usual *= 1.0 + finer
    measured = 1.0 / usual
    whole = round(measured)
    return float(whole) if abs(measured - whole) < 2e-3 * whole else measured
