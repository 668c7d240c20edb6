"""What a published experiment is here: a protocol, its figures, and what we measured beside them."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np

from estimators.errors import ShapeError
from estimators.recording import Float, Recording

Data = Mapping[str, Recording]
Values = dict[str, Float]


@dataclass(frozen=True)
class Figure:
    """One number of an experiment.

    Attributes
    ----------
    name : str
        Unique within its protocol.
    unit : str
    required : float, or None
        Limit that every seed must keep; None for figures that are only shown.
    published : float, or None
        What the source reports under these conditions, if anything.
    at_most : bool
        The limit is an upper one; otherwise a lower one.
    judged_by : {"worst", "median"}
        Which value over the seeds must keep the limit.
    """

    name: str
    unit: str
    required: float | None = None
    published: float | None = None
    at_most: bool = True
    judged_by: Literal["worst", "median"] = "worst"


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
    title : str
    x_label, x_unit, y_label, y_unit : str
    curves : tuple of Curve
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
    """Return a curve of few points: of each stretch of samples the one with the largest value is kept.

    Parameters
    ----------
    name : str
    x, y : ndarray, shape (N,)
        An error over time: its peaks matter and stay.
    points : int
    """
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if len(x) <= points:
        return Curve(name, x, y)
    edges = np.linspace(0, len(x), points + 1).astype(int)
    kept = []
    for start, stop in pairwise(edges):
        stretch = y[start:stop]
        kept.append(start if np.isnan(stretch).all() else start + int(np.nanargmax(stretch)))
    return Curve(name, x[kept], y[kept])


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
    figures : tuple of Figure
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

    `median`, `worst` and `spread` (standard deviation) are over seeds or recordings; the worst is that
    farthest toward the limit.
    """

    figure: Figure
    values: Float

    @property
    def median(self) -> float:
        """Median over seeds; NaN when nothing could be measured."""
        finite = self.values[np.isfinite(self.values)]
        return float(np.median(finite)) if len(finite) else float("nan")

    @property
    def worst(self) -> float:
        """The value farthest toward the limit; NaN when any seed gave none."""
        if not len(self.values) or np.isnan(self.values).any():
            return float("nan")
        return float(self.values.max() if self.figure.at_most else self.values.min())

    @property
    def spread(self) -> float:
        """Standard deviation over seeds; NaN for fewer than two."""
        return float(self.values.std(ddof=1)) if len(self.values) > 1 else float("nan")

    @property
    def judged(self) -> float:
        """The one of the two that is held against the limit."""
        return self.worst if self.figure.judged_by == "worst" else self.median

    @property
    def passed(self) -> bool:
        """Whether the limit is kept; a figure without one always passes, one without a value never."""
        if self.figure.required is None:
            return True
        if self.figure.at_most:
            return self.judged <= self.figure.required
        return self.judged >= self.figure.required


@dataclass(frozen=True)
class ProtocolResult:
    """A protocol with the results of all its figures."""

    protocol: Protocol
    figures: tuple[FigureResult, ...]
    seeds: int
    seconds: float = field(compare=False)
    plots: tuple[Plot, ...] = field(default=(), compare=False)

    @property
    def name(self) -> str:
        """Key of the protocol."""
        return self.protocol.name

    @property
    def passed(self) -> bool:
        """Whether every figure keeps its limit."""
        return all(figure.passed for figure in self.figures)

    def figure(self, name: str) -> FigureResult:
        """Return one figure by name; raises `KeyError` when there is none."""
        for found in self.figures:
            if found.figure.name == name:
                return found
        raise KeyError(name)


def run_protocol(protocol: Protocol, seeds: int, data: Data, *, plots: bool = False) -> ProtocolResult:
    """Repeat one experiment with seeds 0 to `seeds - 1`, and with `plots` draw its curves too."""
    begin = time.perf_counter()
    values = protocol.measure(range(seeds), data)
    known = {figure.name for figure in protocol.figures}
    if set(values) != known:
        raise KeyError(f"{protocol.name} measured {sorted(set(values) ^ known)} amiss")
    figures = tuple(
        FigureResult(figure, np.atleast_1d(np.asarray(values[figure.name], dtype=np.float64)))
        for figure in protocol.figures
    )
    seconds = time.perf_counter() - begin
    drawn = protocol.plots(data) if plots and protocol.plots is not None else ()
    return ProtocolResult(protocol, figures, seeds, seconds, drawn)
