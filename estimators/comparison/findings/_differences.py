"""How a measure of a session differs from the template's, and whether that is certain and worth a word."""

import functools
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from estimators.comparison._contract import Measure, RepetitionResult, Template
from estimators.comparison.channels.names import channel_unit, tells_movement

_CONFIDENCE = 0.975
_LEAST_RANGE_RAD = 0.087
LEAST_RANGE = {"rad": _LEAST_RANGE_RAD, "m": 0.01, "m/s": 0.1}
_LEAST_HIKE_M = 0.025
LEAST_SHARE = 0.15
"""Inside the therapist's band, differences below 5 degrees, 25 mm of a shoulder, 1 cm or 0.1 m/s of a foot, or 15
percent are not worth a word. What is outside it has its word whatever its size."""


@dataclass(frozen=True)
class Difference:
    """A measure beside its template value; `certainty` is the difference over its 95 percent limit."""

    value: float
    reference: float
    certainty: float

    @property
    def excess(self) -> float:
        return self.value - self.reference


def difference_of(
    name: str, retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> Difference | None:
    measure, reference = summary.get(name), template.measures.get(name)
    if measure is None or reference is None or not np.isfinite(measure.value) or not np.isfinite(reference):
        return None
    named = (one.by_name.get(name) for one in retained)
    own = [m.uncertainty for m in named if m is not None and np.isfinite(m.uncertainty)]
    # Sensor error is common to the repetitions of a session, so it does not average out; spread does.
    sensor = 2.0 * statistics.median(own) if own else 0.0
    count = measure.count
    chance = _student(count - 1) * measure.uncertainty / np.sqrt(count) if count > 1 else 0.0
    deviation = template.measure_sd.get(name, np.nan)
    others = template.repetition_count
    if others > 1 and np.isfinite(deviation):
        # With one repetition of the patient, the therapist's spread is all that is known about chance.
        shrink = 1 / others + (1 if count < 2 else 0)
        reference_chance = _student(others - 1) * deviation * np.sqrt(shrink)
    else:
        reference_chance = 0.0
    limit = float(np.sqrt(sensor**2 + chance**2 + reference_chance**2))
    return Difference(measure.value, reference, abs(measure.value - reference) / max(limit, 1e-9))


@functools.lru_cache(maxsize=256)
def _student(freedom: int) -> float:
    """Return the quantile of Student's t that 95 percent of both sides are within."""
    return float(scipy.stats.t.ppf(_CONFIDENCE, freedom))


def least_of(channel: str) -> float:
    """Return the smallest compensation inside the band that is worth a word, rad or m."""
    return _LEAST_RANGE_RAD if channel_unit(channel) == "rad" else _LEAST_HIKE_M


def other_range_of(
    channel: str, retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> Difference | None:
    """Return how the range of a channel differs, where that is certain and worth a word."""
    difference = difference_of(f"range:{channel}", retained, summary, template)
    is_primary, least = channel == template.primary_channel, LEAST_RANGE[channel_unit(channel)]
    if difference is None or difference.certainty < 1 or abs(difference.excess) < least:
        return None
    if not is_primary and not tells_movement(channel):
        return None
    if not is_primary and difference.reference < 2 * least and difference.excess < 0:
        return None
    return difference
