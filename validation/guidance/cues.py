"""Cues on single faults, on sound repetitions, and where the estimate is less certain than the fault."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from estimators.guidance import Cue, Guide, default_rules
from estimators.recording import Float
from validation.guidance.sessions import FAULTS, STEP_S, GuidedSession, session
from validation.protocol import Data, Figure, Protocol, Values

_HARD: Final = ("pauses", "no rest")
_AFTER: Final = 70
"""Ticks after the end of a repetition in which a cue is still of it."""


def _cues(one: GuidedSession, sigma: Float) -> list[list[Cue]]:
    """Cues of each repetition; praise is none."""
    guide = Guide(one.ready, STEP_S, valid_share=0.5, rules=default_rules(one.ready), stops=())
    said = [cue for cue in guide.feed(one.values, sigma).cues if cue.rule is not None]
    starts = [int(start) for start, _ in one.bounds[1:]]
    ends = [min(int(end) + _AFTER, nxt) for (_, end), nxt in zip(one.bounds, [*starts, 10**9], strict=True)]
    return [
        [cue for cue in said if int(start) <= cue.tick < end]
        for (start, _), end in zip(one.bounds, ends, strict=True)
    ]


def _left_tick(one: GuidedSession, number: int, cue: Cue) -> float:
    """Return when the true deviation left the tolerance, NaN for rules that look at no deviation."""
    if cue.rule is None or cue.rule.quantity != "deviation":
        return float("nan")
    start, end = one.bounds[number]
    column = one.ready.channels.index(cue.rule.channel)
    phase = np.linspace(0.0, 1.0, len(one.ready.mean))
    offset = one.ready.mean[:, column] - one.ready.mean[0, column]
    truth = one.true_values[start:end, column]
    off = truth - truth[0] - np.interp(one.phase[start:end], phase, offset)
    signed = np.abs(off) if cue.rule.side == "both" else cue.rule.side_sign * off
    outside = np.flatnonzero(signed > cue.limit)
    return float(start + outside[0]) if len(outside) else float("nan")


def _measure(seeds: Sequence[int], data: Data) -> Values:
    hits, faults, false, late, sound, false_on_sound = 0, 0, 0, [], 0, 0
    for seed in seeds:
        one = session("faults", seed)
        for number, cues in enumerate(_cues(one, one.sigma)):
            wanted = FAULTS.get(one.faults[number], "")
            right = [cue for cue in cues if cue.sentence == wanted]
            faults += bool(wanted)
            sound += not wanted
            hits += bool(right)
            false += len({cue.sentence for cue in cues} - {wanted})
            false_on_sound += 0 if wanted else len(cues)
            late += [(cue.tick - _left_tick(one, number, cue)) * STEP_S for cue in right[:1]]
    hard, false_on_hard, unsure = 0, 0, 0
    for seed in seeds:
        for kind in _HARD:
            one = session(kind, seed)
            for planned, cues in zip(one.plan, _cues(one, one.sigma), strict=True):
                hard += 1
                # Who really is slower or faster than the tolerance may hear it; the therapist's own pace is 0.9.
                pace = planned.pace / 0.9
                may = (
                    {"guidance.slower"} if pace > 1.45 else {"guidance.quicker"} if pace < 1 / 1.5 else set()
                )
                false_on_hard += len([cue for cue in cues if cue.sentence not in may])
        one = session("faults", seed)
        # As unsure as the largest deviation there is: 45 degrees, and half a metre of a hike or a place.
        doubt = np.where([("." in c or c.endswith("_m")) for c in one.ready.channels], 0.5, np.radians(45.0))
        blind = _cues(one, np.broadcast_to(doubt, one.sigma.shape).copy())
        unsure += sum(
            cue.rule is not None and cue.rule.quantity in ("deviation", "at_equal")
            for cues in blind
            for cue in cues
        )
    known = np.array(late)[np.isfinite(late)] if late else np.zeros(0)
    return {
        _RECALL: np.array([hits / max(faults, 1)]),
        _PRECISION: np.array([hits / max(hits + false, 1)]),
        _FALSE: np.array([100.0 * false_on_sound / max(sound, 1)]),
        _FALSE_HARD: np.array([100.0 * false_on_hard / hard]),
        _LATE: np.array([np.percentile(known, 95) if len(known) else np.nan]),
        _SILENT: np.array([float(unsure)]),
    }


_RECALL: Final = "faults that brought their cue"
_PRECISION: Final = "cues that were right"
_FALSE: Final = "false cues on sound repetitions, of 100"
_FALSE_HARD: Final = "false cues with pauses, tremor, stops or no rest, of 100"
_LATE: Final = "cue after the true deviation left its tolerance, 95 %"
_SILENT: Final = "cues where the estimate is less certain than any deviation"

CUES = Protocol(
    name="guidance_cues",
    title="Cues on faults of known size",
    source="House page on live guidance, sections 5 and 9",
    what="Six repetitions a seed, half of them with one fault: size 0.55 to 0.72, trunk 12 to 20 degrees forward or 11 "
    "to 16 to the side, clavicle 11 to 16, pace 0.4 to 0.55 or 1.7 to 2.2, plane 30 to 45. A cue is right where its "
    "sentence is that of the fault of this repetition. Sensors and filters as in a session.",
    figures=(
        Figure(_RECALL, "1", 0.90, at_most=False, judged_by="mean"),
        Figure(_PRECISION, "1", 0.97, at_most=False, judged_by="mean"),
        Figure(_FALSE, "count", 1.0, judged_by="mean"),
        Figure(_FALSE_HARD, "count", 5.0, judged_by="mean"),
        Figure(_LATE, "s", 0.65, judged_by="mean"),
        Figure(_SILENT, "count", 0.0, judged_by="mean"),
    ),
    measure=_measure,
)
