"""The therapist's tolerance over channels and phases, equation (11)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.comparison import PHASES, Template
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
    channel : str
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


def tolerance_band(template: Template, curves: Sequence[ToleranceCurve] = ()) -> tuple[Float, Float]:
    """Return how far below and above its mean a template lets each channel go.

    Parameters
    ----------
    template : Template
        Its `tolerance` is the recorded width: Student's t times the spread after alignment, not less than the floor
        nor than what the sensors themselves change.
    curves : sequence of ToleranceCurve
        At most one a channel; channels without one have the recorded width.

    Returns
    -------
    below, above : ndarray, shape (101, C)
        rad and m, infinite where free, NaN where the template has no value.

    Raises
    ------
    SetupError
        For a channel that the template has not, or two curves of one.

    Notes
    -----
    Equation (11): b± = max(t_{0.95,n-1} sqrt(1 + 1/n) sd, floor, 1.64 sigma) k±, of which `build_template` makes the
    maximum.
    """
    named = [curve.channel for curve in curves]
    if len(set(named)) != len(named) or set(named) - set(template.channels):
        raise SetupError(f"tolerances for {named}; the template has {template.channels}, each at most once")
    below, above = template.tolerance.copy(), template.tolerance.copy()
    phase = np.linspace(0.0, 1.0, PHASES)
    for curve in curves:
        column = template.channels.index(curve.channel)
        down, up = curve.factors(phase)
        below[:, column] *= down
        above[:, column] *= up
    return below, above


__all__ = ["FREE", "Knot", "ToleranceCurve", "tolerance_band"]
