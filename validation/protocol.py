"""A published experiment as a protocol: its figures, and what we measured beside them."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Final, Literal

import numpy as np

from estimators.errors import ShapeError
from estimators.recording import Float, Recording
from validation.judgement import Estimate, Verdict, mean, quantile

Data = Mapping[str, Recording]
Values = dict[str, Float]
BATCH: Final = 10
"""Seeds that are measured together: what an experiment pools over seeds gives one value a batch."""


@dataclass(frozen=True)
class Figure:
    """One number of an experiment.

    Attributes
    ----------
    name : str
        Unique within its protocol.
    required : float, or None
        The limit; None for figures that are only shown.
    published : float, or None
        What the source reports under these conditions, if anything.
    at_most : bool
        The limit is an upper one; otherwise a lower one.
    judged_by : {"worst", "median", "mean"}
        What must meet the limit: of recordings the worst, the median or the mean; of seeds what nine in ten reach
        ("worst"), the median or the mean; of batches that a figure is pooled over the mean, or the median if so said.
    """

    name: str
    unit: str
    required: float | None = None
    published: float | None = None
    at_most: bool = True
    judged_by: Literal["worst", "median", "mean"] = "worst"


@dataclass(frozen=True)
class Curve:
    """One line of a plot.

    Attributes
    ----------
    name : str
        For the legend.
    x, y : ndarray, shape (N,)
        In the units of the plot; NaN makes a hole in the line.
    """

    name: str
    x: Float
    y: Float

    def __post_init__(self) -> None:
        if self.x.ndim != 1 or self.x.shape != self.y.shape:
            raise ShapeError(f"curve {self.name} has x of shape {self.x.shape} and y of {self.y.shape}")


@dataclass(frozen=True)
class Plot:
    """Curves on common axes, from one seed of an experiment.

    Attributes
    ----------
    logarithmic : bool
        Both axes (Allan deviation).
    """

    title: str
    x_label: str
    x_unit: str
    y_label: str
    y_unit: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False


def thinned(name: str, x: Float, y: Float, points: int = 300) -> Curve:
    """Return a curve of few points: of each stretch of samples the one with the largest value is retained.

    Parameters
    ----------
    x, y : ndarray, shape (N,)
        An error over time: its peaks matter and stay.
    """
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if len(x) <= points:
        return Curve(name, x, y)
    edges = np.linspace(0, len(x), points + 1).astype(int)
    retained = []
    for start, stop in pairwise(edges):
        stretch = y[start:stop]
        retained.append(start if np.isnan(stretch).all() else start + int(np.nanargmax(stretch)))
    return Curve(name, x[retained], y[retained])


@dataclass(frozen=True)
class Protocol:
    """A published experiment, ready to be repeated.

    Attributes
    ----------
    name : str
        Key for the command line.
    title : str
        For people.
    source : str
        Paper, section, table.
    what : str
        One or two sentences: what is done and what counts.
    measure : callable
        Takes seeds and data; returns for each figure one value a seed (or a recording).
    needs_data : str
        Empty for simulations; otherwise the set of recordings, for people.
    plots : callable, optional
        Takes the data and returns what to draw, measured with the first seed.
    """

    name: str
    title: str
    source: str
    what: str
    figures: tuple[Figure, ...]
    measure: Callable[[Sequence[int], Data], Values]
    needs_data: str = ""
    plots: Callable[[Data], tuple[Plot, ...]] | None = None


@dataclass(frozen=True)
class FigureResult:
    """One figure with what we measured.

    Attributes
    ----------
    values : ndarray, shape (N,)
        NaN where nothing could be measured.
    each : {"seed", "batch", "recording"}
        What a value is of. Recordings are no draws: they are judged as they are, without an interval. A figure that
        only some of the seeds have counts as pooled over batches.

    Notes
    -----
    `median`, `worst` and `spread` (standard deviation) are over the values; the worst is that farthest toward the
    limit.
    """

    figure: Figure
    values: Float
    each: Literal["seed", "batch", "recording"] = "seed"

    @property
    def median(self) -> float:
        """Median of the values; NaN when nothing could be measured."""
        finite = self.values[np.isfinite(self.values)]
        return float(np.median(finite)) if len(finite) else float("nan")

    @property
    def worst(self) -> float:
        """The value farthest toward the limit; NaN when any could not be measured."""
        if not len(self.values) or np.isnan(self.values).any():
            return float("nan")
        return float(self.values.max() if self.figure.at_most else self.values.min())

    @property
    def spread(self) -> float:
        """Standard deviation of the values; NaN for fewer than two."""
        return float(self.values.std(ddof=1)) if len(self.values) > 1 else float("nan")

    @cached_property
    def judged(self) -> Estimate:
        """What is held against the limit, with its confidence interval."""
        if not len(self.values):
            return Estimate(float("nan"), float("nan"), float("nan"))
        if self.each == "recording":
            value = {"worst": self.worst, "median": self.median, "mean": float(self.values.mean())}[
                self.figure.judged_by
            ]
            return Estimate(value, value, value)
        sign = 1.0 if self.figure.at_most else -1.0
        # What could not be measured counts as far beyond the limit.
        toward = np.where(np.isnan(self.values), np.inf, sign * self.values)
        by = self.figure.judged_by
        if by == "mean" or (by == "worst" and self.each == "batch"):
            found = mean(toward)
        else:
            found = quantile(toward, 0.5 if by == "median" else 0.9)
        ends = sorted((sign * found.low, sign * found.high))
        return Estimate(sign * found.value, *ends)

    @property
    def verdict(self) -> Verdict:
        """`pass` when the whole interval meets the limit; a figure without a limit always passes."""
        if self.figure.required is None:
            return "pass"
        return self.judged.verdict(self.figure.required, at_most=self.figure.at_most)

    @property
    def meets(self) -> bool:
        """Whether the estimate, without its interval, meets the limit."""
        if self.figure.required is None:
            return True
        alone = Estimate(self.judged.value, self.judged.value, self.judged.value)
        return alone.verdict(self.figure.required, at_most=self.figure.at_most) == "pass"


@dataclass(frozen=True)
class ProtocolResult:
    """A protocol with the results of all its figures."""

    protocol: Protocol
    figures: tuple[FigureResult, ...]
    seeds: int
    seconds: float = field(compare=False)
    plots: tuple[Plot, ...] = field(default=(), compare=False)
    first_seed: int = 0
    """The `seeds` seeds are this one and those after it."""

    @property
    def name(self) -> str:
        """Key of the protocol."""
        return self.protocol.name

    @property
    def verdict(self) -> Verdict:
        """The worst verdict of its figures."""
        found = {figure.verdict for figure in self.figures}
        return "short" if "short" in found else "open" if "open" in found else "pass"

    @property
    def meets(self) -> bool:
        """Whether the estimate of every figure meets its limit."""
        return all(figure.meets for figure in self.figures)

    def figure(self, name: str) -> FigureResult:
        """Return one figure by name; raises `KeyError` when there is none."""
        for found in self.figures:
            if found.figure.name == name:
                return found
        raise KeyError(name)


def parts_of(protocol: Protocol, seeds: Sequence[int]) -> tuple[Sequence[int], ...]:
    """Cut the seeds of an experiment into batches of `BATCH` or a few more.

    Fewer than two batches' worth stay together. So do the seeds of an experiment on recordings: these are the same
    for every seed, and it draws what it needs by itself.
    """
    if protocol.needs_data:
        return (seeds,)
    count = max(len(seeds) // BATCH, 1)
    edges = [len(seeds) * number // count for number in range(count + 1)]
    return tuple(seeds[start:stop] for start, stop in pairwise(edges))


def measured(protocol: Protocol, seeds: Sequence[int], data: Data) -> tuple[Values, float]:
    """Repeat one experiment with one batch of seeds.

    Returns
    -------
    values : dict of str to ndarray
    seconds : float

    Raises
    ------
    KeyError
        The experiment measured other figures than it names.
    """
    begin = time.perf_counter()
    values = protocol.measure(seeds, data)
    if amiss := set(values) ^ {figure.name for figure in protocol.figures}:
        raise KeyError(f"{protocol.name} measured {sorted(amiss)} amiss")
    found = {name: np.atleast_1d(np.asarray(value, dtype=np.float64)) for name, value in values.items()}
    return found, time.perf_counter() - begin


def gather(
    protocol: Protocol,
    seeds: Sequence[int],
    parts: Sequence[tuple[Values, float]],
    plots: tuple[Plot, ...] = (),
) -> ProtocolResult:
    """Put the batches of one experiment together.

    Parameters
    ----------
    seeds : sequence of int
        Of all batches.
    parts : sequence of tuple
        What `measured` returned for each batch.
    """
    figures = []
    for figure in protocol.figures:
        found = [part[figure.name] for part, _ in parts]
        each: Literal["seed", "batch", "recording"] = "recording"
        if not protocol.needs_data:
            each = "seed" if sum(map(len, found)) == len(seeds) and len(found[0]) > 1 else "batch"
        figures.append(FigureResult(figure, np.concatenate(found), each))
    seconds = sum(taken for _, taken in parts)
    return ProtocolResult(protocol, tuple(figures), len(seeds), seconds, plots, seeds[0] if seeds else 0)


def run_protocol(
    protocol: Protocol, seeds: int, data: Data, *, first_seed: int = 0, plots: bool = False
) -> ProtocolResult:
    """Repeat one experiment with `seeds` seeds from `first_seed` on, and with `plots` draw its curves too."""
    drawn = range(first_seed, first_seed + seeds)
    curves = protocol.plots(data) if plots and protocol.plots is not None else ()
    return gather(
        protocol, drawn, [measured(protocol, part, data) for part in parts_of(protocol, drawn)], curves
    )
