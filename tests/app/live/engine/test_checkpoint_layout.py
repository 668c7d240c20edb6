"""Whoever changes what a checkpoint holds raises its layout: a row that was stored before is then left, not guessed at.

Arrays of a pipeline's own steps are bound to `Pipeline.version`, which is part of a checkpoint's key.
"""

import asyncio
from hashlib import blake2b
from typing import Any

import numpy as np
from sqlalchemy import Engine

from app.live.manager import LiveManager
from app.live.session.checkpoint import LAYOUT, capture
from estimators.orientation import available, create
from tests.app.live.engine.both_ways import Sender, packets_of, worn
from tests.app.live.engine.test_both_ways import ARM, manager, no_checks
from tests.app.live.engine.test_late_turns import PLAIN
from tests.app.live.live_load import connected, remember, swaying

__all__ = ["manager", "no_checks"]

KNOWN = (4, "544ded10412068ea")
"""Layout, and what was in a checkpoint then."""


def described(name: str, arrays: Any) -> list[str]:
    # A calibration is text: its length is that of its numbers.
    shapes = {key: one.ndim if key.endswith("calibration") else one.shape for key, one in arrays.items()}
    return sorted(f"{name} {key} {one.dtype.descr} {shapes[key]}" for key, one in arrays.items())


async def of_a_session(manager: LiveManager, world: Any, engine: Engine) -> list[str]:
    calibration, whole = swaying(2.0)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)
    intake = await connected(manager, world.subjects["therapist"], world.patient_id, stream)
    sender = Sender(intake)
    for number, data in enumerate(packets_of(stream, PLAIN, np.random.default_rng(0))[:3]):
        sender.take_rare(data, 100.0 + 0.05 * number, int(1e9 * (100.0 + 0.05 * number)))
    session = manager.live(intake.session_id)
    await session.line.drained()
    state = capture(session)
    assert state is not None
    epochs, clips = state.met
    (epoch,) = epochs
    assert not clips
    return [
        f"clock {[type(one).__name__ for one in state.clock]}",
        f"epoch {sorted(vars(epoch))}",
        *described("arm", state.arrays),
    ]


def test_what_a_checkpoint_holds_is_that_of_its_layout(
    manager: LiveManager, world: Any, engine: Engine
) -> None:
    lines = asyncio.run(of_a_session(manager, world, engine))
    for name in available():
        lines += described(name, create(name, 2, 0.01).state())
    digest = blake2b("\n".join(lines).encode(), digest_size=8).hexdigest()
    assert (LAYOUT, digest) == KNOWN, "raise LAYOUT, and write both here; it holds now:\n" + "\n".join(lines)
