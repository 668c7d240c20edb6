"""Types of the guidance: its parameters, a template made ready, and what a chunk of ticks gives."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.guidance._records import Model
from estimators.guidance._rules import Cue, Stopped
from estimators.recording import Float

RepetitionKind = Literal["valid", "partial", "wrong", "ignored"]
KINDS: Final[tuple[RepetitionKind, ...]] = ("valid", "partial", "wrong", "ignored")
"""By their numbers in the compiled counter."""


@dataclass(frozen=True)
class GuidanceTemplate:
    """A template made ready for one patient.

    Attributes
    ----------
    channels : tuple of str
        Columns of what `Guide.feed` takes, C of them.
    side : str
        The patient's acting side.
    main : str
        Channel by which targets are counted.
    steering : tuple of str
        Channels that tell the phase, F of them, each with a weight above zero.
    mean : ndarray, shape (101, C)
        Absolute, in the patient's metres.
    below, above : ndarray, shape (101, C)
        Half widths of the band of equation (11), infinite where it is free.
    target_phase, target_offset : ndarray, shape (K,)
        Extremes of the main channel: phase 0 to 1, and how far from the start posture, rad or m.
    model : Model
        The same for the compiled filter.
    """

    channels: tuple[str, ...]
    side: str
    main: str
    steering: tuple[str, ...]
    duration_s: float
    mean: Float
    below: Float
    above: Float
    target_phase: Float
    target_offset: Float
    model: Model


@dataclass(frozen=True)
class CountedRepetition:
    """A finished attempt, equation (9).

    Attributes
    ----------
    attempt : int
        Number of the attempt, from 1, ignored ones included.
    start_tick, end_tick : int
        When the filter saw it begin and end.
    quotient : tuple of float
        Attained share of each target, q_k.
    wrong_share : float
        Mean P(WRONG).
    excursion : float
        Way from the start posture as a share of the template's.
    stiff_share : float
        How much of the time the movement was the template's only but for one joint that did not come along.
    """

    kind: RepetitionKind
    attempt: int
    start_tick: int
    end_tick: int
    quotient: tuple[float, ...]
    wrong_share: float
    excursion: float
    stiff_share: float = 0.0


@dataclass(frozen=True)
class GuidanceChunk:
    """What `Guide.feed` gives for N ticks.

    Attributes
    ----------
    phase, sigma : ndarray, shape (N,)
        (8): 0 to 1. NaN until the prompted rest is over. At rest the phase says nothing.
    rest, wrong : ndarray, shape (N,)
        P(REST) and P(WRONG).
    size : ndarray, shape (N,)
        Mean size of the movement as a share of the template's.
    deviation, deviation_sigma : ndarray, shape (N, C)
        (10): y - y0 - mu(phase) and its standard deviation, NaN where unknown.
    repetitions : tuple of CountedRepetition
        That ended in this chunk.
    """

    first_tick: int
    phase: Float
    sigma: Float
    rest: Float
    wrong: Float
    size: Float
    deviation: Float
    deviation_sigma: Float
    repetitions: tuple[CountedRepetition, ...]
    cues: tuple[Cue, ...]
    stops: tuple[Stopped, ...]

    @property
    def moving(self) -> NDArray[np.bool_]:
        """Ticks of a movement along the template, shape (N,)."""
        return self.rest + self.wrong < 0.5
