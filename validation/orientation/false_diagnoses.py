"""Sound recordings of many movements, devices and rates: how often one is accused of something."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from estimators.calibration import Finding, RecordingCheck, TwoLooks, check_recording
from validation.orientation.sound_recordings import SoundRecording, sound_recording
from validation.protocol import Data, Figure, Protocol, Values

_FIRST_S, _EVERY_S, _LEAST_S = 4.0, 12.0, 3.0
"""A live check looks at the first four seconds, then at each twelve together."""
_MOST_PERCENT: Final = 0.1


def accusations(recording: SoundRecording) -> tuple[list[Finding], list[Finding]]:
    """Return what is falsely said of a sound recording, as a file and at any time of a live session.

    Returns
    -------
    of_file, live : list of Finding
        All that is found, but a field that varies where there is iron in the room.
    """
    of_file = check_recording(recording.chunk, recording.names, hemisphere=recording.hemisphere)
    live = RecordingCheck(recording.names, recording.hemisphere)
    said: dict[tuple[str, str], Finding] = {}
    looks = TwoLooks()
    for first, stop in _parts(recording):
        live.add(recording.chunk.ticks(first, stop))
        said |= {found.subject: found for found in looks.reported(live.findings)}
    return [found for found in of_file if _is_false(found, recording)], [
        found for found in said.values() if _is_false(found, recording)
    ]


def _parts(recording: SoundRecording) -> Iterator[tuple[int, int]]:
    """Yield the stretches that a live session has checked, one after the other."""
    step_s, ticks = recording.chunk.time_step_s, recording.chunk.tick_count
    first, stop = 0, round(_FIRST_S / step_s)
    while first < ticks:
        stop = min(stop, ticks)
        if (stop - first) * step_s >= _LEAST_S:
            yield first, stop
        first, stop = stop, stop + round(_EVERY_S / step_s)


def _is_false(found: Finding, recording: SoundRecording) -> bool:
    return found.code != "magnetic_disturbance" or recording.is_field_clean


def _measured(seeds: Sequence[int], data: Data) -> Values:
    said = [accusations(sound_recording(seed)) for seed in seeds]
    return {
        "sound recordings accused, as files": np.array([100.0 * bool(of_file) for of_file, _ in said]),
        "sound recordings accused, live": np.array([100.0 * bool(live) for _, live in said]),
        "sound recordings refused": np.array(
            [100.0 * any(f.severity == "refuse" for f in (*of_file, *live)) for of_file, live in said]
        ),
    }


FALSE_DIAGNOSES = Protocol(
    name="false_diagnoses",
    title="Sound recordings accused of a fault",
    source="our own; no published figure",
    what="Recordings drawn at random: a limb that swings, circles or turns, a hand, an arm, a walk, somebody beside a"
    " magnetic source; 25 to 200 Hz, 8 to 150 s, six and nine axes, devices good, usual and cheap, iron in passing. A"
    " word about units, axes, signs, dead or clipped channels is false, as is a doubt; counted as a file and at any"
    " time of a live session. With 1,000 seeds at most one may be accused.",
    figures=(
        Figure("sound recordings accused, as files", "%", _MOST_PERCENT, judged_by="mean"),
        Figure("sound recordings accused, live", "%", _MOST_PERCENT, judged_by="mean"),
        Figure("sound recordings refused", "%", 0.0, judged_by="mean"),
    ),
    measure=_measured,
)
