"""Phase of simulated patients against the truth: error, delay, and through gaps."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from estimators.guidance import Guide
from estimators.recording import Float
from validation.guidance.sessions import STEP_S, VALID_SHARE, GuidedSession, matched, session
from validation.protocol import Data, Figure, Protocol, Values

_LIMITS: Final = {
    "pauses": (1.5, 13.0),
    "no rest": (0.5, 4.0),
    "mild": (1.5, 13.0),
    "moderate": (None, None),
}
_TITLES: Final = {
    "pauses": "pauses, tremor, stops half-way",
    "no rest": "no rest between repetitions",
    "mild": "mild impairment",
    "moderate": "moderate impairment",
}
_GAP, _EVERY = 30, 300
"""Ticks."""


def _follow(one: GuidedSession, values: Float) -> tuple[Float, list[str]]:
    guide = Guide(one.ready, STEP_S, valid_share=VALID_SHARE.get(one.kind, 0.8), rules=(), stops=())
    chunk = guide.feed(values, one.sigma)
    return chunk.phase, matched(one, chunk)


def _errors(one: GuidedSession, phase: Float) -> Float:
    """Differences of the phase in repetitions, percent; the end of one is the beginning of the next."""
    error = np.abs(phase - one.phase)[np.isfinite(one.phase)] * 100.0
    return np.minimum(error, 100.0 - error) if one.kind == "no rest" else error


def _delays_ms(one: GuidedSession, phase: Float) -> Float:
    """How long ago the patient was at the phase stated, ms, in repetitions without a stop half-way."""
    found = []
    for (start, end), planned in zip(one.bounds, one.plan, strict=True):
        ticks = np.flatnonzero(np.isfinite(one.phase[start:end]))
        truth = one.phase[start:end][ticks]
        if planned.stop_s > 0.0 or not len(truth):
            continue
        rising = np.maximum.accumulate(truth) + 1e-9 * ticks
        found.append((ticks - np.interp(phase[start:end][ticks], rising, ticks)) * STEP_S * 1e3)
    return np.abs(np.concatenate(found)) if found else np.zeros(0)


def _measure(seeds: Sequence[int], data: Data) -> Values:
    values: Values = {}
    delays = []
    for kind, title in _TITLES.items():
        errors = []
        for seed in seeds:
            one = session(kind, seed)
            phase, _ = _follow(one, one.values)
            errors.append(_errors(one, phase))
            if kind == "pauses":
                delays.append(_delays_ms(one, phase))
        every = np.concatenate(errors)
        values[f"{title}, median"] = np.array([np.median(every)])
        values[f"{title}, 95 %"] = np.array([np.percentile(every, 95)])
    late = np.concatenate(delays)
    values["delay, median"] = np.array([np.median(late)])
    values["delay, 95 %"] = np.array([np.percentile(late, 95)])
    errors, changed = [], 0
    for seed in seeds:
        one = session("no rest", seed)
        gaps = one.values.copy()
        gaps[np.arange(len(gaps)) % _EVERY >= _EVERY - _GAP] = np.nan
        phase, kinds = _follow(one, gaps)
        errors.append(_errors(one, phase))
        changed += kinds.count("valid") != _follow(one, one.values)[1].count("valid")
    values["gaps of 0.3 s every 3 s, 95 %"] = np.array([np.percentile(np.concatenate(errors), 95)])
    values["gaps of 0.3 s every 3 s, sets counted otherwise"] = np.array([100.0 * changed / len(seeds)])
    return values


PHASE = Protocol(
    name="guidance_phase",
    title="Phase of a patient along the template",
    source="House page on live guidance, sections 2 and 9",
    what="Six repetitions a seed of one of five arm exercises, through sensors and filters: paces of 0.55 to 1.4 with "
    "pauses, tremor and stops half-way; without rest; after a mild and a moderate stroke. The phase is held against "
    "the therapist's at the same posture, percent of the movement. Delay: how long ago the patient was there.",
    figures=(
        *(
            Figure(f"{title}, {what}", "%", limit, judged_by="mean")
            for kind, title in _TITLES.items()
            for what, limit in zip(("median", "95 %"), _LIMITS[kind], strict=True)
        ),
        Figure("delay, median", "ms", 20.0, judged_by="mean"),
        Figure("delay, 95 %", "ms", 120.0, judged_by="mean"),
        Figure("gaps of 0.3 s every 3 s, 95 %", "%", 6.0, judged_by="mean"),
        Figure("gaps of 0.3 s every 3 s, sets counted otherwise", "%", 0.0, judged_by="mean"),
    ),
    measure=_measure,
)
