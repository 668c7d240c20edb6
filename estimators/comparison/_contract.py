"""Types of the comparison: what goes in, what a template is, what comes out."""

import itertools
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._bands import NamedPhase, ToleranceCurve
from estimators.errors import SetupError
from estimators.recording import Float

PHASES = 101
"""Points of a time-normalised repetition, phase 0 to 100 percent."""


@dataclass(frozen=True)
class Trajectory:
    """The channels of one session that comparisons use, on an even time base.

    Attributes
    ----------
    time_s : ndarray, shape (N,)
        Session time.
    channels : tuple of str
        Names of `FrameLayout` angles and scalars, and points as `<point>.x|y|z`.
    values : ndarray, shape (N, C)
        rad and m; NaN where there is no estimate.
    sigma : ndarray, shape (N, C)
        One standard deviation of the estimate, NaN where unknown.
    valid : ndarray of bool, shape (N, C)
        False inside gaps and where the estimate is flagged invalid.
    unseated : ndarray of bool, shape (N, C), or None
        Where a sensor has turned in its strap: the value moves as the person does, and repetitions are found by it, but
        it is off by nobody knows how much, and nothing is measured by it. None where none has.
    """

    time_s: Float
    channels: tuple[str, ...]
    values: Float
    sigma: Float
    valid: NDArray[np.bool_]
    unseated: NDArray[np.bool_] | None = None

    @property
    def measured(self) -> Float:
        """The values that can be stated, shape (N, C); NaN elsewhere."""
        stated = self.valid if self.unseated is None else self.valid & ~self.unseated
        return np.where(stated, self.values, np.nan)


@dataclass(frozen=True)
class Repetition:
    """One repetition, half-open in session time, retained or dropped with its reason.

    `counted` says how it was counted while it was made: `valid`, `partial` or `wrong`; empty where nobody counted.
    """

    number: int
    start_s: float
    end_s: float
    is_kept: bool = True
    reason: str = ""
    counted: str = ""

    def ticks(self, time_s: Float) -> slice:
        """Return which ticks are within it, of session times (s, ascending)."""
        first, last = np.searchsorted(time_s, (self.start_s - 1e-9, self.end_s - 1e-9))
        return slice(int(first), int(last))


@dataclass(frozen=True)
class Template:
    """The mean of a therapist's repetitions with a tolerance band per channel and phase.

    What was recorded and what the therapist drew on it stand apart: `tolerance` never changes, `tolerances` are factors
    on it, and everybody who judges reads `below` and `above`.

    Attributes
    ----------
    mean, tolerance : ndarray, shape (101, C)
        The recorded band is `mean +- tolerance`: Student's t times the spread after alignment, not less than the floor.
    primary_channel : str
        The channel whose range is the main measure.
    reach_m : float
        Upper arm plus forearm of the person who recorded it; positions are compared in units of it.
    tolerances : tuple of ToleranceCurve
        The therapist's factors on the band, at most one curve a channel; channels without one keep the recorded width.
    watched : tuple of str
        Channels that are shown and not judged. The primary channel always counts.
    phases : tuple of NamedPhase
        In order, none over another.

    Raises
    ------
    SetupError
        For a drawing that does not fit: a channel that the template has not, two curves of one, phases over each other.
    """

    channels: tuple[str, ...]
    mean: Float
    tolerance: Float
    duration_s: float
    duration_sd_s: float
    repetition_count: int
    primary_channel: str
    side: str
    reach_m: float
    measures: dict[str, float] = field(default_factory=dict)
    """The template's own value of each measure, for display beside the patient's."""
    measure_sd: dict[str, float] = field(default_factory=dict)
    """Standard deviation of each measure between the therapist's repetitions; NaN where unknown."""
    tolerances: tuple[ToleranceCurve, ...] = ()
    watched: tuple[str, ...] = ()
    phases: tuple[NamedPhase, ...] = ()

    def __post_init__(self) -> None:
        named = [curve.channel for curve in self.tolerances]
        if len(set(named)) != len(named) or {*named, *self.watched} - set(self.channels):
            raise SetupError(
                f"tolerances for {named}, only watched {self.watched}; each at most once, of {self.channels}"
            )
        if self.primary_channel in self.watched:
            raise SetupError(f"{self.primary_channel} is the main channel, which always counts")
        for one, following in itertools.pairwise(self.phases):
            if following.start < one.end or following.name == one.name:
                raise SetupError(f"the phases {one} and {following} lie over each other or have one name")

    @cached_property
    def below(self) -> Float:
        """How far below its mean the therapist lets each channel go, rad and m, shape (101, C).

        Infinite where free, NaN where the template has no value. Equation (11) of the guidance:
        b± = max(t_{0.95,n-1} sqrt(1 + 1/n) sd, floor, 1.64 sigma) k±, of which `tolerance` is the maximum.
        """
        return self._band[0]

    @cached_property
    def above(self) -> Float:
        """How far above; see `below`."""
        return self._band[1]

    @cached_property
    def counts(self) -> NDArray[np.bool_]:
        """Which channels are judged, shape (C,)."""
        return np.array([name not in self.watched for name in self.channels], dtype=np.bool_)

    @cached_property
    def _band(self) -> tuple[Float, Float]:
        below, above = self.tolerance.copy(), self.tolerance.copy()
        phase = np.linspace(0.0, 1.0, PHASES)
        for curve in self.tolerances:
            column = self.channels.index(curve.channel)
            down, up = curve.factors(phase)
            below[:, column] *= down
            above[:, column] *= up
        return below, above


@dataclass(frozen=True)
class Measure:
    """A number with unit, uncertainty and the count behind it."""

    name: str
    group: str
    """timing, shape, range, smoothness, coordination, path or compensation."""
    value: float
    unit: str
    uncertainty: float
    count: int
    note: str = ""
    """Why it is undefined, a sentence for people; empty where it is not."""


@dataclass(frozen=True)
class RepetitionResult:
    """One repetition of the patient beside the template.

    Attributes
    ----------
    curves : ndarray, shape (101, C)
        The patient's channels over patient phase.
    aligned : ndarray, shape (101, C)
        The patient's channels over template phase, after alignment in time.
    sigma : ndarray, shape (101, C)
        One standard deviation of `aligned` by the sensors' own uncertainty there, NaN where unknown.
    warp_template_phase : ndarray, shape (101,)
        Template phase (0 to 100) for each patient phase; never decreases.
    outside : dict of channel to list of half-open phase intervals of the template
    """

    repetition: Repetition
    measures: tuple[Measure, ...]
    curves: Float
    aligned: Float
    sigma: Float
    warp_template_phase: Float
    outside: dict[str, list[tuple[int, int]]]

    @cached_property
    def by_name(self) -> dict[str, Measure]:
        """Its measures by their names."""
        return {measure.name: measure for measure in self.measures}


@dataclass(frozen=True)
class ComparisonResult:
    """Every repetition and the summary over the retained ones."""

    channels: tuple[str, ...]
    repetitions: tuple[RepetitionResult, ...]
    summary: tuple[Measure, ...]
    findings: tuple[str, ...]
