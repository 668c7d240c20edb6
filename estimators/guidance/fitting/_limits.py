"""Whether a stop rule can hold: what stops its own template, or a patient at rest, can never be met."""

from typing import Final

import numpy as np

from estimators.comparison.channels.names import channel_unit
from estimators.guidance._orders import UNKNOWN_M, UNKNOWN_RAD
from estimators.guidance._rules import StopRule
from estimators.guidance._stop_kernel import _SIGMAS
from estimators.recording import Float

_MARGIN_RAD: Final = float(np.radians(10.0))
_MARGIN_M: Final = 0.05
_ROUND_RAD: Final = float(np.radians(5.0))
_ROUND_M: Final = 0.01


def least_room(channel: str) -> float:
    """Return how far a limit must lie beyond what is allowed, rad or m: a rule stops two sigma before its limit."""
    return _SIGMAS * (UNKNOWN_M if channel_unit(channel) == "m" else UNKNOWN_RAD)


def farthest(side: str, values: Float) -> float:
    """Return the value nearest to a limit of this side, or beyond it; NaN where none is known.

    Parameters
    ----------
    side : {"below", "above"}
    values : ndarray
        rad or m, NaN where unknown.
    """
    known = values[np.isfinite(values)]
    if not len(known):
        return float("nan")
    return float(known.max() if side == "above" else known.min())


def nearest_limit(channel: str, side: str, value: float) -> float:
    """Return the tightest limit that lets this value be, rad or m."""
    return value + (1.0 if side == "above" else -1.0) * least_room(channel)


def is_broken(rule: StopRule, value: float) -> bool:
    """Return whether a rule of kind `limit` stops at this value; False of a value that is not known."""
    sign = 1.0 if rule.side == "above" else -1.0
    return bool(sign * (rule.limit - nearest_limit(rule.channel, rule.side, value)) < -1e-9)


def proposed_limit(channel: str, side: str, values: Float) -> float:
    """Return a limit for a movement: its extreme and a margin, outward to whole 5 degrees or centimetres.

    Parameters
    ----------
    side : {"below", "above"}
    values : ndarray
        Curves of the channel, rad or m.
    """
    is_length = channel_unit(channel) == "m"
    margin, step = (_MARGIN_M, _ROUND_M) if is_length else (_MARGIN_RAD, _ROUND_RAD)
    sign = 1.0 if side == "above" else -1.0
    outward = sign * farthest(side, values) + margin
    return sign * float(np.ceil(outward / step - 1e-9)) * step
