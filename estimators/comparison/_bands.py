"""A therapist's drawing on a template: named phases, and the tolerance of each channel over the phase."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.errors import SetupError
from estimators.recording import Float

FREE: Final = float("inf")
"""A factor that lets a channel do what it likes."""
_WIDEST: Final = 100.0


@dataclass(frozen=True)
class Knot:
    """How many times its recorded width the band has at one phase.

    Attributes
    ----------
    phase : float
        0 to 1.
    below, above : float
        k- and k+, above zero; `FREE` for no limit.
    """

    phase: float
    below: float = 1.0
    above: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.phase <= 1.0:
            raise SetupError(f"the phase of a knot is {self.phase}; it goes from 0 to 1")
        for factor in (self.below, self.above):
            if not (0.0 < factor <= _WIDEST or factor == FREE):
                raise SetupError(f"a factor on the band is {factor}; it lies within 0 and 100, or is FREE")


@dataclass(frozen=True)
class ToleranceCurve:
    """The factors of one channel over the phase, stored apart from the spread that was recorded.

    Attributes
    ----------
    knots : tuple of Knot
        In order of phase, different phases. Straight lines between them, level before the first and after the last;
        next to a free knot the band is free as far as the next one.
    """

    channel: str
    knots: tuple[Knot, ...]

    def __post_init__(self) -> None:
        phases = [knot.phase for knot in self.knots]
        if not phases or sorted(set(phases)) != phases:
            raise SetupError(f"knots of {self.channel} must be one or more, in order and at different phases")

    def factors(self, phase: Float) -> tuple[Float, Float]:
        """Return k- and k+ at each phase, 0 to 1, each of the shape of `phase`."""
        at = np.array([knot.phase for knot in self.knots])
        return (
            _between(at, np.array([knot.below for knot in self.knots]), phase),
            _between(at, np.array([knot.above for knot in self.knots]), phase),
        )


def _between(at: Float, factor: Float, phase: Float) -> Float:
    """Interpolate; between a finite and an infinite factor lies only infinity."""
    free = np.isinf(factor)
    line = np.interp(phase, at, np.where(free, 1.0, factor))
    share = np.interp(phase, at, free.astype(np.float64))
    return np.where(share > 0.0, np.inf, line)


@dataclass(frozen=True)
class NamedPhase:
    """A stretch of the movement that a therapist gave a name.

    Attributes
    ----------
    name : str
        The therapist's word, for instance `Lift`.
    start, end : float
        0 to 1, start before end.
    """

    name: str
    start: float
    end: float

    def __post_init__(self) -> None:
        if not self.name.strip() or not 0.0 <= self.start < self.end <= 1.0:
            raise SetupError(f"{self}: a phase has a name, and its start before its end, both within 0 and 1")
