"""Are the units what they were declared to be? Gravity and the earth's field are in every recording."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

import numpy as np

from app.errors import ImplausibleReadings, RecordingFormatError
from estimators.conventions import GRAVITY_MPS2
from estimators.gravity import calm_size
from estimators.recording import Float
from estimators.sentences import Sentence, say

TO_SI: Final[dict[str, float]] = {
    "rad/s": 1.0,
    "deg/s": np.pi / 180.0,
    "m/s^2": 1.0,
    "mdps": np.pi / 180_000.0,
    "g": GRAVITY_MPS2,
    "mg": 1e-3 * GRAVITY_MPS2,
    "T": 1.0,
    "mT": 1e-3,
    "uT": 1e-6,
    "G": 1e-4,
    "mG": 1e-7,
    # Multiples of the field where it was calibrated: heading needs its direction and constancy, not its size.
    "local": 45e-6,
}
UNITS: Final[dict[str, tuple[str, ...]]] = {
    "gyroscope": ("rad/s", "deg/s", "mdps"),
    "accelerometer": ("m/s^2", "g", "mg"),
    "magnetometer": ("T", "mT", "uT", "G", "mG", "local"),
}

GRAVITY_RANGE_MPS2: Final = (7.5, 13.0)
"""Median size of specific force over most recordings of a person."""
CALM_RANGE_MPS2: Final = (4.0, 24.0)
"""Its size where it is calm, in every one, quick walks and runs of a foot too; units differ by ten times."""
_STEPS_PERCENT, _LEAST_STEP_RADPS, _LEAST_STEP_MPS2 = 99.5, 1.0, 5.0
"""Of a foot's samples the quickest: a step turns it faster and shakes it harder than this."""
FIELD_RANGE_T: Final = (10e-6, 150e-6)
"""The earth's field is 22 to 67 microtesla; steel in buildings bends it."""
_MOST_IRON_T: Final = 2e-3
"""Larger fields than this are beyond what a compass measures: no iron, another unit."""
FASTEST_TURN_RADPS: Final = 70.0
"""4000 degrees a second: the widest gyroscopes clip there."""


_ACCEPTED: Final[ContextVar[list[Sentence] | None]] = ContextVar("accepted", default=None)


@contextmanager
def accepting(is_accepted: bool) -> Iterator[list[Sentence]]:
    """Read values that cannot be right as they are; yields what is said of them, to be shown as warnings.

    Parameters
    ----------
    is_accepted : bool
        Otherwise they are refused, as without this.
    """
    said: list[Sentence] = []
    token = _ACCEPTED.set(said if is_accepted else None)
    try:
        yield said
    finally:
        _ACCEPTED.reset(token)


def _refuse(message: Sentence, where: str, quantity: str) -> None:
    """Refuse readings that cannot be right, unless they are accepted."""
    said = _ACCEPTED.get()
    if said is None:
        raise ImplausibleReadings(message, sensor=where, quantity=quantity)
    said.append(message)


def check_accelerometer(values: Float, time_step_s: float, unit: str, where: str) -> None:
    """Refuse a sensor that does not show gravity where its specific force is calm, and guess the unit meant.

    Parameters
    ----------
    values : ndarray, shape (N, 3)
        m/s^2 after conversion from `unit`. Over a whole run the median of a foot is twice gravity; between its swings
        it stands.
    unit : str
        As declared.
    where : str
        Which sensor, for the message.
    """
    sizes = np.linalg.norm(values, axis=1)
    sizes = sizes[np.isfinite(sizes)]
    median = float(np.median(sizes)) if sizes.size else math.nan
    if not GRAVITY_RANGE_MPS2[0] <= median <= GRAVITY_RANGE_MPS2[1]:
        calm = calm_size(values, time_step_s)
        if not CALM_RANGE_MPS2[0] <= calm <= CALM_RANGE_MPS2[1]:
            _check_size(calm, unit, where, "accelerometer", GRAVITY_RANGE_MPS2)


def check_foot_gyroscope(gyroscope: Float, accelerometer: Float, unit: str, where: str) -> None:
    """Refuse a foot that feels steps and does not turn: radians declared as degrees.

    Parameters
    ----------
    gyroscope, accelerometer : ndarray, shape (N, 3)
        rad/s and m/s^2. A foot that only stands is let pass: it feels no steps either.
    unit, where : str
        Of the gyroscope as declared, and which sensor, for the message.
    """
    turning, force = np.linalg.norm(gyroscope, axis=1), np.linalg.norm(accelerometer, axis=1)
    if not turning.size:
        return
    fastest, hardest = (
        float(np.percentile(size, _STEPS_PERCENT)) for size in (turning, np.abs(force - GRAVITY_MPS2))
    )
    if fastest >= _LEAST_STEP_RADPS or hardest <= _LEAST_STEP_MPS2:
        return
    raw = fastest / TO_SI[unit]
    advice = _advice("rad/s" if unit == "deg/s" and raw >= _LEAST_STEP_RADPS else None)
    _refuse(say("signal.foot_gyroscope", where=where, raw=raw, unit=unit, advice=advice), where, "gyroscope")


def is_earths(field_t: Float) -> bool:
    """Return whether a field, shape (N, 3), T, has about the size of the earth's."""
    sizes = np.linalg.norm(field_t, axis=1)
    sizes = sizes[np.isfinite(sizes)]
    return bool(sizes.size) and FIELD_RANGE_T[0] <= float(np.median(sizes)) <= FIELD_RANGE_T[1]


def check_magnetometer(values: Float, unit: str, where: str) -> None:
    """Refuse a sensor whose median field is not about that of the earth, and guess the unit meant."""
    sizes = np.linalg.norm(values, axis=1)
    sizes = sizes[np.isfinite(sizes)]
    _check_size(
        float(np.median(sizes)) if sizes.size else math.nan, unit, where, "magnetometer", FIELD_RANGE_T
    )


def check_gyroscope(values: Float, unit: str, where: str) -> None:
    """Refuse turning rates that no sensor measures: degrees declared as radians."""
    finite = np.abs(values[np.isfinite(values)])
    if finite.size and float(np.percentile(finite, 99.0)) > FASTEST_TURN_RADPS:
        fastest = float(finite.max()) / TO_SI[unit]
        advice = _advice("deg/s" if unit == "rad/s" else None)
        message = say("signal.gyroscope_fast", where=where, raw=fastest, unit=unit, advice=advice)
        _refuse(message, where, "gyroscope")


def _check_size(size: float, unit: str, where: str, quantity: str, expected: tuple[float, float]) -> None:
    if math.isnan(size):
        raise RecordingFormatError(
            say("signal.no_numbers", where=where, quantity=quantity), sensor=where, quantity=quantity
        )
    low, high = expected
    if low <= size <= high:
        return
    raw = size / TO_SI[unit]
    fitting = [u for u in UNITS[quantity] if u != unit and low <= raw * TO_SI[u] <= high]
    advice = _advice(fitting[0] if fitting else None)
    message = (
        say("signal.no_gravity", where=where, raw=raw, unit=unit, advice=advice)
        if quantity == "accelerometer"
        else say(
            "signal.no_earth_field",
            where=where,
            raw=raw,
            unit=unit,
            advice=_iron_or(fitting) if size < _MOST_IRON_T else advice,
        )
    )
    _refuse(message, where, quantity)


def _iron_or(units: list[str]) -> Sentence:
    """Return what to do about a field that is not the earth's: iron is more often the cause than a wrong unit."""
    return say("signal.iron_or_unit", units=units) if units else say("signal.iron_or_columns")


def _advice(unit: str | None) -> Sentence:
    """Return what to do: declare the unit that the values fit, or check everything."""
    return say("file.looks_like_unit", unit=unit) if unit else say("signal.check_columns")
