"""Findings about the readings of a sensor, and their words for people."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from estimators.sentences import CATALOGUE, Sentence, say

Hemisphere = Literal["north", "south", "unknown"]
"""Of the place: the magnetic field points down in the north and up in the south."""
Severity = Literal["refuse", "warning"]
FindingCode = Literal[
    "accelerometer_axes",
    "accelerometer_clipped",
    "accelerometer_dead",
    "accelerometer_uncalibrated",
    "accelerometer_unit",
    "gravity_reversed",
    "gyroscope_axes",
    "gyroscope_clipped",
    "gyroscope_dead",
    "gyroscope_or_accelerometer_axes",
    "gyroscope_or_magnetometer_axes",
    "gyroscope_unit",
    "magnetic_disturbance",
    "magnetometer_axes",
    "magnetometer_dead",
    "magnetometer_frozen",
    "magnetometer_unit",
    "no_data",
    "unexplained",
]


@dataclass(frozen=True)
class Finding:
    """Something about the readings of one sensor that must not be estimated silently.

    Attributes
    ----------
    sensor : str
        Its name.
    code : str
        One of `FindingCode`, for programs.
    severity : {"refuse", "warning"}
        `refuse`: certain, and the estimate would be wrong; `warning`: a doubt, or the estimate will be worse.
    message : Sentence
        What is wrong and what to do, for people; its parameter `where` names the sensor.
    value : float
        What was measured, in the unit that the message names.
    """

    sensor: str
    code: FindingCode
    severity: Severity
    message: Sentence
    value: float

    @property
    def subject(self) -> tuple[str, str]:
        """What it is about: another stretch may blame another triad of the sensor for the same mix of axes."""
        return self.sensor, "axes" if self.code.endswith("_axes") else self.code


class TwoLooks:
    """Reports of a session that goes on: what is certain at once, a doubt only where two looks in turn have it.

    A doubt rests on the little that was seen: more of it makes most of those go away that mean nothing.
    """

    def __init__(self) -> None:
        self._doubted: frozenset[tuple[str, str]] = frozenset()

    def reported(self, findings: Sequence[Finding]) -> list[Finding]:
        """Return what of the findings of the next look is reported."""
        before, self._doubted = self._doubted, frozenset(found.subject for found in findings)
        return [found for found in findings if found.severity == "refuse" or found.subject in before]

    def forget(self, sensor: str) -> None:
        """Begin again with one sensor: another device may have come in its place."""
        self._doubted = frozenset(subject for subject in self._doubted if subject[0] != sensor)


def in_words(findings: Sequence[Finding], *, most: int = 6) -> str:
    """Return findings as sentences for people, each kind once, with the names of all sensors it concerns.

    Parameters
    ----------
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
    stated = [
        CATALOGUE.say(code, where=where, **others) for code, others, where in list(kinds.values())[:most]
    ]
    if len(kinds) > most:
        stated.append(say("readings.more", count=len(kinds) - most))
    return CATALOGUE.together(stated)
