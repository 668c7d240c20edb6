"""Numbers of the running service in Prometheus' text format 0.0.4.

Written out here rather than by a package: everything that is counted is counted already, in plain attributes that the
live path raises without a lock, and is read only when somebody asks. Names begin with `telemotion_`; a counter ends in
`_total`. No label holds an identifier, so the number of lines is fixed.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal

CONTENT_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
PREFIX: Final = "telemotion_"

Labels = Mapping[str, str]
Values = float | Mapping[tuple[tuple[str, str], ...], float]


class Histogram:
    """Counts of what was observed, by upper bound.

    Parameters
    ----------
    bounds : iterable of float
        Upper bounds, ascending, in the unit of what is observed.
    """

    def __init__(self, bounds: Iterable[float]) -> None:
        self.bounds = tuple(bounds)
        self.counts = [0] * (len(self.bounds) + 1)
        self.total = 0.0

    def observe(self, value: float) -> None:
        """Count one value."""
        self.counts[bisect_left(self.bounds, value)] += 1
        self.total += value


@dataclass(frozen=True)
class Metric:
    """One name: what it means and how it is read.

    Attributes
    ----------
    read : callable or Histogram
        Returns a number, or numbers by labels as pairs of name and value.
    """

    name: str
    kind: Literal["counter", "gauge", "histogram"]
    meaning: str
    read: Callable[[], Values] | Histogram

    def lines(self) -> Iterable[str]:
        """Yield the lines of the exposition."""
        name = PREFIX + self.name
        yield f"# HELP {name} {self.meaning}"
        yield f"# TYPE {name} {self.kind}"
        if isinstance(self.read, Histogram):
            counted = 0
            for bound, count in zip((*self.read.bounds, math.inf), list(self.read.counts), strict=True):
                counted += count
                yield f'{name}_bucket{{le="{_number(bound)}"}} {counted}'
            yield f"{name}_sum {_number(self.read.total)}"
            yield f"{name}_count {counted}"
            return
        values = self.read()
        if isinstance(values, Mapping):
            for labels, value in sorted(values.items()):
                written = ",".join(f'{key}="{_escaped(word)}"' for key, word in labels)
                yield f"{name}{{{written}}} {_number(value)}"
        else:
            yield f"{name} {_number(values)}"


class Registry:
    """Every metric of a service."""

    def __init__(self) -> None:
        self._metrics: dict[str, Metric] = {}

    @property
    def names(self) -> list[str]:
        """With prefix, in the order in which they were added."""
        return [PREFIX + name for name in self._metrics]

    def counter(self, name: str, meaning: str, read: Callable[[], Values]) -> None:
        """Add something that only rises."""
        self._add(Metric(name, "counter", meaning, read))

    def gauge(self, name: str, meaning: str, read: Callable[[], Values]) -> None:
        """Add something that rises and falls."""
        self._add(Metric(name, "gauge", meaning, read))

    def histogram(self, name: str, meaning: str, histogram: Histogram) -> None:
        """Add a distribution."""
        self._add(Metric(name, "histogram", meaning, histogram))

    def text(self) -> str:
        """Return everything; may block on the database."""
        return "\n".join(line for metric in self._metrics.values() for line in metric.lines()) + "\n"

    def _add(self, metric: Metric) -> None:
        if metric.name in self._metrics:
            raise ValueError(f"{metric.name} is there already")
        self._metrics[metric.name] = metric


def _number(value: float) -> str:
    if math.isinf(value):
        return "+Inf" if value > 0 else "-Inf"
    return repr(int(value)) if float(value).is_integer() else repr(float(value))


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
