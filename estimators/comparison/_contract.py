"""Types of the comparison: what goes in, what a template is, what comes out."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

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
    """

    time_s: Float
    channels: tuple[str, ...]
    values: Float
    sigma: Float
    valid: NDArray[np.bool_]


@dataclass(frozen=True)
class Repetition:
    """One repetition, half-open in session time, retained or dropped with its reason."""

    number: int
    start_s: float
    end_s: float
    is_kept: bool = True
    reason: str = ""


@dataclass(frozen=True)
class Template:
    """The mean of a therapist's repetitions with a tolerance band per channel and phase.

    Attributes
    ----------
    channels : tuple of str
    mean, tolerance : ndarray, shape (101, C)
        Band is `mean +- tolerance`.
    duration_s, duration_sd_s : float
    repetition_count : int
    primary_channel : str
        The channel whose range is the main measure.
    reach_m : float
        Upper arm plus forearm of the person who recorded it; positions are compared in units of it.
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


@dataclass(frozen=True)
class Measure:
    """A number with unit, uncertainty and the count behind it."""

    name: str
    group: str
    """timing, shape, range, smoothness, path or compensation."""
    value: float
    unit: str
    uncertainty: float
    count: int


@dataclass(frozen=True)
class RepetitionResult:
    """One repetition of the patient beside the template.

    Attributes
    ----------
    curves : ndarray, shape (101, C)
        The patient's channels over patient phase.
    aligned : ndarray, shape (101, C)
        The patient's channels over template phase, after alignment in time.
    warp_template_phase : ndarray, shape (101,)
        Template phase (0 to 100) for each patient phase; never decreases.
    outside : dict of channel to list of half-open phase intervals of the template
    """

    repetition: Repetition
    measures: tuple[Measure, ...]
    curves: Float
    aligned: Float
    warp_template_phase: Float
    outside: dict[str, list[tuple[int, int]]]


@dataclass(frozen=True)
class ComparisonResult:
    """Every repetition and the summary over the retained ones."""

    channels: tuple[str, ...]
    repetitions: tuple[RepetitionResult, ...]
    summary: tuple[Measure, ...]
    findings: tuple[str, ...]
