"""Templates and patients in closed form: a planar arm whose phase, size and bounds are known exactly."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from estimators.comparison import build_template
from estimators.guidance import GuidanceChunk, GuidanceTemplate, Guide, prepare_template, signals
from tests.estimators.comparison.conftest import Planar, make_planar

OUT_S, HOLD_S, REST_S = 1.2, 0.3, 1.0
RATE_HZ = 100.0


@cache
def template():
    made = make_planar(noise_rad=0.002)
    return build_template(made.trajectory, made.truth, "right", made.reach_m, made.primary)


@cache
def ready() -> GuidanceTemplate:
    return prepare_template(template(), "right", template().reach_m)


@dataclass(frozen=True)
class Followed:
    """A patient, what the guide said, and the true phase in the repetitions."""

    made: Planar
    chunk: GuidanceChunk
    guide: Guide

    def phase_error(self, out_s: float, hold_s: float = HOLD_S) -> np.ndarray:
        """Differences of the phase from the truth, at every tick of a repetition."""
        errors = []
        own, whole = np.array([0.0, out_s, out_s + hold_s, 2 * out_s + hold_s]), 2 * OUT_S + HOLD_S
        theirs = np.array([0.0, OUT_S, OUT_S + HOLD_S, whole]) / whole
        for one in self.made.truth:
            ticks = np.arange(round(one.start_s * RATE_HZ), round(one.end_s * RATE_HZ))
            errors.append(self.chunk.phase[ticks] - np.interp(ticks / RATE_HZ - one.start_s, own, theirs))
        return np.concatenate(errors)

    @property
    def kinds(self) -> list[str]:
        """Kinds of the attempts that were not ignored."""
        return [one.kind for one in self.chunk.repetitions if one.kind != "ignored"]


def follow(made: Planar, values=None, **options) -> Followed:
    guide = Guide(ready(), 1.0 / RATE_HZ, **options)
    own, sigma = signals(made.trajectory, ready())
    return Followed(made, guide.feed(own if values is None else values(own, made), sigma), guide)


@pytest.fixture
def mild():
    """Another pace and size, with sensor noise."""
    return follow(make_planar(repetitions=5, out_s=1.6, sizes=0.8, noise_rad=0.005, seed=4), valid_share=0.6)
