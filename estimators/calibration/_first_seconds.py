"""The first seconds of a recording or stream: cut out where they tell most, checked, put in words."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from estimators.calibration._plausibility import Finding, Hemisphere, check_plausibility
from estimators.recording import ImuChunk
from estimators.sentences import CATALOGUE, say

FIRST_SECONDS_S: Final = 12.0
"""Length that is checked: a rest and a first movement."""
SEARCHED_S: Final = 60.0
"""How far into a recording the first movement is looked for."""
_MOVED_RADPS: Final = 0.5
_TIMES_REST: Final = 5.0
_BEFORE_S: Final = 3.0


def check_first_seconds(
    chunk: ImuChunk,
    names: Sequence[str],
    *,
    hemisphere: Hemisphere = "north",
) -> tuple[Finding, ...]:
    """Check the beginning of a recording, rest and first movement.

    Parameters
    ----------
    chunk : ImuChunk
        The recording, or its beginning; at most its first minute is looked at.
    names : sequence of str, length S
        What to call the sensors.
    hemisphere : {"north", "south", "unknown"}
        Of the place, see `check_plausibility`.

    Returns
    -------
    tuple of Finding
        Of the very first seconds, which tell units, and of those around the first movement, which tell axes; each
        once, with the graver of both verdicts.
    """
    length = max(1, round(FIRST_SECONDS_S / chunk.time_step_s))
    found: dict[tuple[str, str], Finding] = {}
    for start in (0, _movement(chunk)):
        stretch = chunk.ticks(start, min(start + length, chunk.tick_count))
        for finding in check_plausibility(stretch, names, hemisphere=hemisphere):
            known = found.get(finding.subject)
            # At rest a unit is only doubted; the movement then tells that it is wrong.
            if known is None or (known.severity, finding.severity) == ("warning", "refuse"):
                found[finding.subject] = finding
    return tuple(found.values())


def _movement(chunk: ImuChunk) -> int:
    """Return a tick shortly before most sensors begin to turn; 0 if they do at once or never."""
    ticks = min(chunk.tick_count, round(SEARCHED_S / chunk.time_step_s))
    speed = np.nan_to_num(np.median(np.linalg.norm(chunk.gyroscope_radps[:, :ticks], axis=-1), axis=0))
    # Against what it reads at first: noise of deg/s taken for rad/s is no movement.
    at_first = float(np.median(speed[: round(_BEFORE_S / chunk.time_step_s)]))
    moving = np.flatnonzero(speed > max(_MOVED_RADPS, _TIMES_REST * at_first))
    if not len(moving):
        return 0
    return max(0, int(moving[0]) - round(_BEFORE_S / chunk.time_step_s))


def in_words(findings: Sequence[Finding], *, most: int = 6) -> str:
    """Return findings as sentences for people, each kind once, with the names of all sensors it concerns.

    Parameters
    ----------
    findings : sequence of Finding
    most : int
        Kinds to tell; the rest is counted.
    """
    kinds: dict[str, tuple[str, dict[str, Any], list[str]]] = {}
    for finding in findings:
        code, parameters = finding.message.code, dict(finding.message.parameters)
        where = parameters.pop("where")
        # By the words: limits that were measured differ in the last digits.
        words = str(CATALOGUE.say(code, where=[], **parameters))
        kinds.setdefault(words, (code, parameters, []))[2].extend(where)
    told = [CATALOGUE.say(code, where=where, **others) for code, others, where in list(kinds.values())[:most]]
    if len(kinds) > most:
        told.append(say("readings.more", count=len(kinds) - most))
    return CATALOGUE.together(told)


__all__ = ["FIRST_SECONDS_S", "SEARCHED_S", "check_first_seconds", "in_words"]
