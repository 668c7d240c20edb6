"""Headings set anew during a session hold from then on, whatever the stored session is estimated with."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.database.unit_of_work import read_only, unit_of_work
from app.recordings.analysis.heading_line import (
    HeadingLine,
    HeadingReset,
    calibration_in_force,
    with_first_headings,
)
from app.recordings.models import SessionEvent
from estimators import pipelines, rotation, signals
from estimators.pipelines import Calibration, SessionSetup
from estimators.recording import ImuChunk
from estimators.simulation import ArmScenario, Schedule, simulate_arm

ARM: tuple[Any, ...] = ("upper_arm_right", "forearm_right")
DRIFT_RAD = 0.35


@pytest.fixture(scope="module")
def standing() -> tuple[ImuChunk, Calibration]:
    """Somebody who stands still, and the calibration of it."""
    person = ArmScenario(
        placements=ARM, schedule=Schedule(n_pose_s=9.0, repetitions=1, pause_s=0.2), seed=3, errors="ideal"
    )
    chunk = signals.to_common_ticks(simulate_arm(person).recording, 100.0).ticks(0, 1000)
    pipeline = pipelines.create(SessionSetup("arm", ARM, 100.0))
    pipeline.step(chunk.ticks(0, 400))
    return chunk, pipeline.calibrate(chunk.ticks(100, 400))


def reset_at(start_s: float, before: Calibration) -> HeadingReset:
    details = HeadingReset.details(ARM, before)
    return HeadingReset(start_s, start_s + 2.0, ARM, details["before"])


def turned(frames: list[Any]) -> Any:
    """Heading of the forearm against that late in the pose, degrees, at every tick."""
    q = np.concatenate([part.q_room_segment[:, 1] for part in frames])
    return np.degrees(np.abs(rotation.log(rotation.multiply(q, rotation.conjugate(q[850])))[:, 2]))


@pytest.mark.parametrize("length", [1000, 137])
def test_a_reset_holds_from_its_tick_on(standing: tuple[ImuChunk, Calibration], length: int) -> None:
    chunk, found = standing
    drifted = replace(found, heading_offset_rad={"forearm_right": DRIFT_RAD})
    line = HeadingLine(
        pipelines.create(SessionSetup("arm", ARM, 100.0, calibration=drifted)), [reset_at(5.0, drifted)]
    )
    frames = [
        part
        for start in range(0, 1000, length)
        for part in line.step(chunk.ticks(start, min(1000, start + length)))
    ]
    assert line.refused == []
    assert [part.first_tick for part in frames[1:]] == list(np.cumsum([p.tick_count for p in frames])[:-1])
    off = turned(frames)
    assert off[400:700].min() > np.degrees(DRIFT_RAD) - 5.0
    assert off[700:860].max() < 5.0


def test_a_remembered_mounting_takes_its_headings_from_the_first_reset(
    standing: tuple[ImuChunk, Calibration],
) -> None:
    chunk, found = standing
    remembered = replace(found, facing_rad=0.0, heading_offset_rad={}, unknown_headings=ARM)
    setup = SessionSetup("arm", ARM, 100.0, calibration=remembered)
    later = reset_at(7.0, found)
    told, left = with_first_headings(
        setup, [reset_at(4.0, remembered), later], [chunk.ticks(0, 650), chunk.ticks(650, 1000)]
    )
    assert told.calibration is not None
    assert told.calibration.unknown_headings == ()
    assert np.remainder(
        told.calibration.facing_rad - found.facing_rad + np.pi, 2 * np.pi
    ) - np.pi == pytest.approx(0.0, abs=0.1)
    assert left == (later,)


def test_resets_before_the_mounting_in_force_are_over(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    session_id = new_session()
    found = Calibration(dict.fromkeys(ARM, (1.0, 0.0, 0.0, 0.0)), {}, facing_rad=0.6)
    reset = {"kind": "heading_reset", **HeadingReset.details(ARM[1:], found)}
    events = [
        (10.0, reset),
        (20.0, {"kind": "n_pose"}),
        (30.0, reset),
        (40.0, {"kind": "static_bias"}),
        (50.0, reset),
    ]
    with unit_of_work(engine) as session:
        for time_s, details in events:
            session.add(
                SessionEvent(
                    session_id=session_id, kind="calibration", time_s=time_s, duration_s=3.0, details=details
                )
            )
    with read_only(engine) as session:
        _, resets = calibration_in_force(session, session_id)
    assert [(one.start_s, one.stop_s, one.placements) for one in resets] == [
        (30.0, 33.0, ARM[1:]),
        (50.0, 53.0, ARM[1:]),
    ]
    later = replace(found, heading_offset_rad={"forearm_right": 0.2})
    assert resets[0].undone(later) == found
