"""Readings that cannot be right are told within the first seconds of a stream, once each, and never end it."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest

from app.live.first_seconds import FirstSeconds
from estimators import signals
from estimators.calibration import Finding
from estimators.recording import ImuChunk
from estimators.simulation import ArmScenario, Schedule, simulate_arm

ARM = ("upper_arm_right", "forearm_right")


@pytest.fixture(scope="module")
def sound() -> ImuChunk:
    made = simulate_arm(
        ArmScenario(
            exercise="drinking",
            placements=ARM,
            schedule=Schedule(n_pose_s=5.0, settle_s=0.2, pause_s=0.3, repetitions=2),
            seed=2,
        )
    )
    return signals.to_common_ticks(made.recording, 100.0)


async def watched(chunk: ImuChunk) -> tuple[FirstSeconds, list[tuple[float, Finding]]]:
    """Stream a chunk in tenths of a second; what was told, with when."""
    told: list[tuple[float, Finding]] = []
    watch = FirstSeconds(ARM, lambda found, time_s: told.extend((time_s, finding) for finding in found))
    for start in range(0, chunk.tick_count - 10, 10):
        watch.add(chunk.ticks(start, start + 10))
        if watch._checking is not None:
            await watch._checking
    return watch, told


def test_a_sound_stream_says_nothing(sound: ImuChunk) -> None:
    watch, told = asyncio.run(watched(sound))
    assert (told, watch.hint) == ([], "")


def test_a_unit_is_told_while_the_patient_still_stands(sound: ImuChunk) -> None:
    faulty = sound.accelerometer_mps2.copy()
    faulty[1] /= 9.80665
    watch, told = asyncio.run(watched(replace(sound, accelerometer_mps2=faulty)))
    assert [(f.sensor, f.code) for _, f in told] == [("forearm_right", "accelerometer_unit")]
    assert told[0][0] < 5.0
    assert "forearm_right" in watch.hint
    assert "multiply by 9.80665" in watch.hint


def test_axes_are_told_with_the_first_movement(sound: ImuChunk) -> None:
    faulty = sound.gyroscope_radps.copy()
    faulty[0] = faulty[0][:, [1, 0, 2]]
    _, told = asyncio.run(watched(replace(sound, gyroscope_radps=faulty)))
    assert [(f.sensor, f.code) for _, f in told] == [("upper_arm_right", "gyroscope_axes")]
    assert told[0][0] < 17.0


def test_a_check_that_fails_does_not_end_the_session(
    sound: ImuChunk, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(*_: object) -> None:
        raise ValueError("no")

    monkeypatch.setattr("app.live.first_seconds.check_plausibility", broken)
    watch, told = asyncio.run(watched(sound))
    assert (told, watch.hint) == ([], "")
    assert "could not be checked" in caplog.text


def test_a_silent_sensor_is_left_to_the_health_of_the_link(sound: ImuChunk) -> None:
    gone = {name: getattr(sound, name).copy() for name in ("gyroscope_radps", "accelerometer_mps2")}
    for values in gone.values():
        values[1] = np.nan
    assert asyncio.run(watched(replace(sound, **gone)))[1] == []
