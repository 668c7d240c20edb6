"""The one judgement of the readings of a whole recording, for the command line and for the service alike."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from app.errors import ImplausibleReadings
from estimators.calibration import (
    STRETCH_S,
    Correction,
    DeviceCalibration,
    Finding,
    Hemisphere,
    RecordingCheck,
    in_words,
    same_signals,
)
from estimators.recording import ImuChunk
from estimators.sentences import Sentence, say

PIECE_TICKS: Final = 1000


class Judgement(NamedTuple):
    """What is said of readings that are estimated, and how they are corrected before that.

    Attributes
    ----------
    doubts, notes : tuple of str
        What may be wrong; what was done.
    devices : dict of str to DeviceCalibration
        By the names of the sensors: accelerometers whose errors the movement shows.
    """

    doubts: tuple[str, ...]
    notes: tuple[str, ...]
    devices: dict[str, DeviceCalibration]


def judged(
    pieces: Iterable[ImuChunk],
    names: Sequence[str],
    hemisphere: Hemisphere,
    *,
    is_accepted: bool,
    remedy: Sentence,
) -> Judgement:
    """Look whether units, axes and signs can be right and sensors are several.

    Parameters
    ----------
    pieces : iterable of ImuChunk
        The whole recording from its first tick on (rad/s, m/s^2, T).
    names : sequence of str, length S
        What to call the sensors.
    hemisphere : {"north", "south", "unknown"}
        Of the place where it was recorded.
    is_accepted : bool
        Whether readings that cannot be right are estimated as they are.
    remedy : Sentence
        What a person can do about a refusal at this door.

    Raises
    ------
    ImplausibleReadings
        They cannot be right; `codes` says of which kinds.
    """
    if not names:
        return Judgement((), (), {})
    check = RecordingCheck(names, hemisphere, corrects=True)
    doubts: list[str] = []
    for number, chunk in enumerate(stretches(pieces, STRETCH_S)):
        check.add(chunk)
        if number == 0 and (copies := [names[row] for row in same_signals(chunk)]):
            doubts.append(say("upload.same_signals", where=copies))
    # What is not there is flagged where it is missing, and a pause is no fault of the readings.
    found = check.corrections
    findings = [one for one in check.findings if one.code != "no_data" and not _is_corrected(one, found)]
    refused = [finding for finding in findings if finding.severity == "refuse"]
    if refused and not is_accepted:
        raise ImplausibleReadings(
            say("upload.implausible", findings=in_words(refused), remedy=remedy),
            codes=[finding.code for finding in refused],
            findings=[{"sensor": finding.sensor, "code": finding.code} for finding in refused],
        )
    if findings:
        doubts.insert(0, in_words(findings))
    doubts += [one.message for one in found.values() if one.is_fault]
    return Judgement(
        tuple(doubts),
        tuple(one.message for one in found.values() if not one.is_fault),
        {name: one.device for name, one in found.items()},
    )


def _is_corrected(finding: Finding, found: Mapping[str, Correction]) -> bool:
    """Tell whether the message of a correction says it."""
    return finding.code == "accelerometer_uncalibrated" and finding.sensor in found


def cut(chunk: ImuChunk, piece_ticks: int = PIECE_TICKS) -> Iterator[ImuChunk]:
    """Yield a chunk piece by piece."""
    for first in range(0, chunk.tick_count, piece_ticks):
        yield chunk.ticks(first, min(first + piece_ticks, chunk.tick_count))


def stretches(pieces: Iterable[ImuChunk], length_s: float) -> Iterator[ImuChunk]:
    """Join the pieces of a recording to chunks of about a length, one at a time."""
    taken: list[ImuChunk] = []
    for piece in pieces:
        taken.append(piece)
        if sum(one.tick_count for one in taken) * piece.time_step_s >= length_s:
            yield ImuChunk.join(taken)
            taken = []
    if taken:
        yield ImuChunk.join(taken)
