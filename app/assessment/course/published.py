"""Published variation and important change of measures, each with its source.

Only what was published for the very measure: ranges of motion in an exercise have none.
"""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Published:
    """What is known of a measure before a clinic has patients of its own.

    Attributes
    ----------
    measure : str
        As progress names it, up to a side.
    movement : str
        Of the exercise; empty for any.
    scatter : float
        Standard error of measurement of test and retest, in the unit of the measure.
    important : float or None
        Minimal important change.
    people : int
        In whom the scatter was found.
    """

    measure: str
    movement: str
    scatter: float
    scatter_source: str
    important: float | None
    important_source: str
    people: int


_RETEST: Final = "Flansbjer et al. 2005, J Rehabil Med 37:75"
_MEANINGFUL: Final = "Perera et al. 2006, J Am Geriatr Soc 54:743"
PUBLISHED: Final = (
    Published("walk:speed", "", 0.07, _RETEST, 0.05, _MEANINGFUL, 50),
    Published("walk:test_time", "timed_up_and_go", 1.14, _RETEST, None, "", 50),
    Published("walk:test_distance", "six_minute_walk", 18.6, _RETEST, 20.0, _MEANINGFUL, 50),
)


def published_of(measure: str, movement: str) -> Published | None:
    """Return what was published of a measure; None without anything.

    Parameters
    ----------
    measure : str
        As progress names it.
    movement : str
        Of the exercise.
    """
    return next(
        (
            one
            for one in PUBLISHED
            if (measure == one.measure or measure.startswith(f"{one.measure}:"))
            and one.movement in ("", movement)
        ),
        None,
    )
