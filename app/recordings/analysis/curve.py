"""Curves over ticks, and what a kind of session says of those that it has."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from estimators.pipelines import Frames, SessionSetup
from estimators.recording import Float


@dataclass(frozen=True)
class Curve:
    """One number over ticks.

    Attributes
    ----------
    name : str
        With its unit where the name of a channel has one: `centre_of_mass_ahead_m`, `wrist_right.x`.
    unit : str
        SI, as people write it.
    values : ndarray, shape (K,)
        NaN where there is nothing.
    sigma : ndarray, shape (K,), or None
    """

    name: str
    unit: str
    values: Float
    sigma: Float | None = None


@dataclass(frozen=True)
class Series:
    """Curves that are computed together of a result's frames.

    Attributes
    ----------
    curves : callable(frames, setup)
        Returns the curves of consecutive ticks at full rate, always the same ones of a result.
    lacks : callable(setup, layout)
        Returns a sentence when a result cannot have them, else an empty one.
    margin_s : float
        What the curves look at to both sides of a tick.
    """

    name: str
    curves: Callable[[Frames, SessionSetup], Sequence[Curve]]
    lacks: Callable[[SessionSetup, Mapping[str, Any]], str] = lambda setup, layout: ""
    margin_s: float = 0.0
