"""Published values of healthy people, each with its source: what progress shows as a band.

Only what was published for the very measure: ranges of motion in an exercise have none, for an exercise does not ask
for all that a joint can do.
"""

from dataclasses import dataclass
from datetime import date
from typing import Final


@dataclass(frozen=True)
class Norm:
    """Values of healthy people of some ages.

    Attributes
    ----------
    measure : str
        As progress names it.
    ages : tuple of int
        First and last, years.
    low, high : float
        In the unit of the measure.
    meaning : str
        What the bounds are: `confidence`, 95 percent of the mean of that age; `means`, the least and the largest mean
        of an age and sex.
    """

    measure: str
    ages: tuple[int, int]
    low: float
    high: float
    meaning: str
    source: str


_UP_AND_GO: Final = "Bohannon 2006, J Geriatr Phys Ther 29:64"
_SPEED: Final = "Bohannon and Andrews 2011, Physiotherapy 97:182"
NORMS: Final = (
    Norm("walk:test_time", (60, 69), 7.1, 9.0, "confidence", _UP_AND_GO),
    Norm("walk:test_time", (70, 79), 8.2, 10.2, "confidence", _UP_AND_GO),
    Norm("walk:test_time", (80, 99), 10.0, 12.7, "confidence", _UP_AND_GO),
    # Means of men and women by decade; the sex of a patient is not asked for.
    Norm("walk:speed:left", (20, 99), 0.943, 1.434, "means", _SPEED),
    Norm("walk:speed:right", (20, 99), 0.943, 1.434, "means", _SPEED),
)


def norm_of(measure: str, birth_date: date | None, on: date) -> Norm | None:
    """Return the published values for somebody of that age; None without any, or without an age.

    Parameters
    ----------
    on : date
        The day of the newest session.
    """
    if birth_date is None:
        return None
    age = on.year - birth_date.year - ((on.month, on.day) < (birth_date.month, birth_date.day))
    return next((one for one in NORMS if one.measure == measure and one.ages[0] <= age <= one.ages[1]), None)
