"""What a published experiment is here: a protocol, its figures, and what we measured beside them."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

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
    """

    name: str
    title: str
    source: str
    what: str
    figures: tuple[Figure, ...]
    measure: Callable[[Sequence[int], Data], Values]
    needs_data: str = ""


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
    def passed(self) -> bool:
        """Whether the limit is kept; a figure without one always passes, one without a value never."""
        if self.figure.required is None:
            return True
        judged = self.worst if self.figure.judged_by == "worst" else self.median
        if self.figure.at_most:
            return judged <= self.figure.required
        return judged >= self.figure.required


@dataclass(frozen=True)
class ProtocolResult:
    """A protocol with the results of all its figures."""

    protocol: Protocol
    figures: tuple[FigureResult, ...]
    seeds: int
    seconds: float = field(compare=False)

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


def run_protocol(protocol: Protocol, seeds: int, data: Data) -> ProtocolResult:
    """Repeat one experiment with seeds 0 to `seeds - 1`."""
    begin = time.perf_counter()
    values = protocol.measure(range(seeds), data)
    known = {figure.name for figure in protocol.figures}
    if set(values) != known:
        raise KeyError(f"{protocol.name} measured {sorted(set(values) ^ known)} amiss")
    figures = tuple(
        FigureResult(figure, np.atleast_1d(np.asarray(values[figure.name], dtype=np.float64)))
        for figure in protocol.figures
    )
    return ProtocolResult(protocol, figures, seeds, time.perf_counter() - begin)
