"""What the demonstration's patient is about to send is exchanged for what somebody asks in the browser."""

import asyncio
from typing import Any

import numpy as np

from app.demo.on_demand import AHEAD_S, OnDemand, script_of
from app.gateway import stream_of
from app.live.calibration.guides import GUIDES
from app.live.calibration.messages import CalibrationMessage
from estimators.simulation import ArmScenario, Schedule, simulate_arm

SCENARIO = ArmScenario(schedule=Schedule(n_pose_s=3.0, repetitions=3), seed=3)


def asked(kind: Any, step: int, phase: Any = "collecting") -> CalibrationMessage:
    steps = GUIDES[kind].steps
    return CalibrationMessage(kind=kind, phase=phase, steps=steps, step=step, step_progress=0.0, hint="")


def test_the_movement_of_the_step_is_sent_until_the_next_is_asked_for() -> None:
    device = stream_of(simulate_arm(SCENARIO).recording)
    before = device.counts.copy()
    script = script_of("functional", SCENARIO)
    assert script.counts.shape[1:] == before.shape[1:]
    patient = OnDemand(device, SCENARIO)

    async def play() -> None:
        await patient.follow(None, 1.0)
        assert (device.counts == before).all()
        for n in range(6):
            await patient.follow(asked("functional", 0), 2.0 + 0.3 * n)
        await patient.follow(asked("functional", 1), 4.0)
        await patient.follow(asked("functional", 1, "done"), 4.3)

    asyncio.run(play())
    first, last = 250, round((4.0 + AHEAD_S) * 100)
    changed = (device.counts != before).any(axis=(1, 2))
    assert not changed[:first].any(), "what was sent already stays"
    assert not changed[last:].any(), "afterwards the exercise goes on"
    rest = script.loops[0]
    np.testing.assert_array_equal(device.counts[first : first + 100], script.counts[rest[0] : rest[0] + 100])
    forearm = SCENARIO.placements.index("forearm_right")
    turning = np.abs(device.counts[first:last, forearm, :3].astype(float)).mean(axis=1)
    assert turning[:200].mean() < 60, "it rests"


def test_every_kind_has_a_script() -> None:
    for kind in ("static_bias", "six_position", "magnetometer", "n_pose", "t_pose", "heading_reset"):
        script = script_of(kind, SCENARIO)  # type: ignore[arg-type]
        assert script.counts.shape[1] == len(SCENARIO.placements)
        assert all(0 <= start < stop <= len(script.counts) for start, stop in script.loops)
