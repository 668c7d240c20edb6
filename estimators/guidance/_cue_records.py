"""Records of cue rules and stop rules, what they remember, and what they say."""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.kernels import bundle, record, rows
from estimators.recording import Float

DEVIATION, AT_EQUAL, RANGE, FAST, SLOW = range(5)
"""Quantities of cue rules."""
LIMIT, VALID_COUNT, ATTEMPT_COUNT, TIME, LOST, UNSURE, WRONG_IN_A_ROW, PAIN = range(8)
"""What stops."""

RULE: Final = record(
    [
        ("quantity", "i8"),
        ("channel", "i8"),
        ("against", "i8"),  # channel at whose equal value AT_EQUAL looks
        ("least", "f8"),  # of that channel
        ("side", "i8"),  # -1 below, 0 both, 1 above
        ("first", "f8"),
        ("last", "f8"),
        ("tolerance", "f8"),  # NaN: the therapist's band
        ("hold_s", "f8"),
        ("priority", "i8"),
        ("is_on", "i8"),
    ]
)
RULE_STATE: Final = record([("held_s", "f8"), ("was_said", "i8"), ("value", "f8"), ("limit", "f8")])
CUE: Final = record(
    [
        ("tick", "i8"),
        ("rule", "i8"),  # -1: praise
        ("attempt", "i8"),
        ("phase", "f8"),
        ("value", "f8"),
        ("limit", "f8"),
    ]
)
STOP: Final = record(
    [
        ("kind", "i8"),
        ("channel", "i8"),
        ("side", "i8"),  # of LIMIT: 1 not above, -1 not below
        ("limit", "f8"),
        ("hold_s", "f8"),
    ]
)
STOP_STATE: Final = record([("held_s", "f8"), ("was_fired", "i8")])
STOPPED: Final = record([("tick", "i8"), ("rule", "i8"), ("value", "f8"), ("limit", "f8")])

CUE_SETTINGS: Final = record(
    [
        ("z", "f8"),
        ("silence_ticks", "i8"),
        ("praise_every", "i8"),
        ("cue_every", "i8"),
        ("template_moves_s", "f8"),
        ("moving_speed", "f8"),
    ]
)
CUE_STATE: Final = record(
    [
        ("last_tick", "i8"),
        ("said", "i8"),  # cues in this attempt
        ("silent_valid", "i8"),
        ("moved_s", "f8"),
        ("left_tick", "i8"),
        ("left_share", "f8"),  # of the first target, at that tick
        ("begun_phase", "f8"),
        ("is_timed", "i8"),
        ("stopped", "i8"),
        ("valid", "i8"),
        ("attempts", "i8"),
        ("wrong_in_a_row", "i8"),
        ("since_tick", "i8"),
    ]
)


class Orders(NamedTuple):
    """What the therapist ordered: record arrays of `RULE`, `STOP` and `CUE_SETTINGS`, and arrays of the template.

    Attributes
    ----------
    below, above : ndarray, shape (B, C)
        The therapist's band, infinite where free.
    origin : ndarray, shape (C,)
        The template's start posture, zero where the model's offsets are absolute.
    unknown_sigma : ndarray, shape (C,)
        Taken where a channel states none.
    """

    rules: NDArray[Any]
    stops: NDArray[Any]
    settings: NDArray[Any]
    below: Float
    above: Float
    origin: Float
    unknown_sigma: Float


class Said(NamedTuple):
    """What goes on from tick to tick: record arrays of `RULE_STATE`, `STOP_STATE` and `CUE_STATE`."""

    rules: NDArray[Any]
    stops: NDArray[Any]
    state: NDArray[Any]


class Spoken(NamedTuple):
    """What one chunk gives: record arrays of `CUE` and `STOPPED`; how many of each, shape (2,)."""

    cues: NDArray[Any]
    stops: NDArray[Any]
    counts: NDArray[np.int64]


_ROW, _TABLE = types.float64[::1], types.float64[:, ::1]
ORDERS = bundle(Orders, rows(RULE), rows(STOP), rows(CUE_SETTINGS), _TABLE, _TABLE, _ROW, _ROW)
SAID = bundle(Said, rows(RULE_STATE), rows(STOP_STATE), rows(CUE_STATE))
SPOKEN = bundle(Spoken, rows(CUE), rows(STOPPED), types.int64[::1])
