"""Readings that cannot be right are told within the first seconds of a stream, once each, and never end it."""

import asyncio
from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pytest

from app.errors import Unavailable
from app.live.checks.first_seconds import CheckTurns, FirstSeconds
from app.live.checks.live_words import _WORDS
from app.live.checks.plausibility import Checked, check
from estimators import signals
from estimators.calibration import Finding, Hemisphere, TwoLooks
from estimators.recording import Float, ImuChunk
from estimators.sentences import say
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from messages import messages_in
from tests.said import codes

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
    watch = FirstSeconds(ARM, 0.01, lambda found, time_s: told.extend((time_s, finding) for finding in found))
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
    assert codes(watch.hint) == ["readings.live_accelerometer_unit"], (
        "nobody who wears it has a table to correct"
    )
    assert told[0][1].message.parameters["where"] == ["forearm_right"]


def test_axes_are_told_with_the_first_movement(sound: ImuChunk) -> None:
    faulty = sound.gyroscope_radps.copy()
    faulty[0] = faulty[0][:, [1, 0, 2]]
    _, told = asyncio.run(watched(replace(sound, gyroscope_radps=faulty)))
    assert [(f.sensor, f.code) for _, f in told] == [("upper_arm_right", "gyroscope_axes")]
    assert told[0][1].message.code == "readings.live_sensor_axes"
    assert told[0][1].message.parameters["mapping"] == ["x → y", "y → x"]
    assert told[0][0] < 17.0


def test_a_doubt_is_told_by_the_second_look_that_has_it(sound: ImuChunk) -> None:
    """A fifth more than gravity at rest is a doubt, told with the second look if that has it too."""
    off = sound.accelerometer_mps2.copy()
    off[1] *= 1.2
    _, told = asyncio.run(watched(replace(sound, accelerometer_mps2=off)))
    assert [(f.sensor, f.code, f.severity) for _, f in told] == [
        ("forearm_right", "accelerometer_unit", "warning")
    ]
    assert 15.0 < told[0][0] < 17.0
    remedy = told[0][1].message.parameters["remedy"]
    assert remedy.code == "readings.force_off", "who wears it can calibrate it"
    looks, doubt = TwoLooks(), [told[0][1]]
    assert [looks.reported(one) for one in (doubt, [], doubt, doubt)] == [[], [], [], doubt]
    looks.forget("forearm_right")
    assert looks.reported(doubt) == []


def test_a_check_that_fails_does_not_end_the_session(
    sound: ImuChunk, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(*_: object) -> None:
        raise ValueError("no")

    monkeypatch.setattr("estimators.calibration.RecordingCheck.add", broken)
    watch, told = asyncio.run(watched(sound))
    assert (told, watch.hint) == ([], "")
    assert "could not be checked" in caplog.text


def test_a_check_that_the_end_of_the_service_cuts_off_is_no_error(
    sound: ImuChunk, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def stopping(*_: object) -> None:
        raise Unavailable(say("live.stopping"), reason="stopping")

    monkeypatch.setattr("estimators.calibration.RecordingCheck.add", stopping)
    watch, told = asyncio.run(watched(sound))
    assert (told, watch.hint) == ([], "")
    assert not caplog.records


def test_a_silent_sensor_is_left_to_the_health_of_the_link(sound: ImuChunk) -> None:
    gone = {name: getattr(sound, name).copy() for name in ("gyroscope_radps", "accelerometer_mps2")}
    for values in gone.values():
        values[1] = np.nan
    assert asyncio.run(watched(replace(sound, **gone)))[1] == []


def resting_first(chunk: ImuChunk, seconds: float) -> ImuChunk:
    """Put a rest before, as its first second reads on average, with noise."""
    ticks = round(seconds / chunk.time_step_s)
    generator = np.random.default_rng(1)

    def longer(values: Float, noise: float) -> Float:
        rest = values[:, :100].mean(axis=1, keepdims=True) + noise * generator.normal(
            size=(len(values), ticks, 3)
        )
        return np.concatenate((rest, values), axis=1)

    assert chunk.magnetometer_t is not None
    return ImuChunk(
        0,
        chunk.time_step_s,
        longer(chunk.gyroscope_radps, 4e-3),
        longer(chunk.accelerometer_mps2, 2e-2),
        longer(chunk.magnetometer_t, 2e-7),
        np.zeros((chunk.sensor_count, ticks + chunk.tick_count), np.uint8),
    )


def test_axes_are_told_however_late_the_first_movement_is(sound: ImuChunk) -> None:
    late = resting_first(sound, 70.0)
    faulty = late.gyroscope_radps.copy()
    faulty[0] = faulty[0][:, [1, 0, 2]]
    watch, told = asyncio.run(watched(replace(late, gyroscope_radps=faulty)))
    assert [(f.sensor, f.code) for _, f in told] == [("upper_arm_right", "gyroscope_axes")]
    assert watch.refused == {"upper_arm_right"}


def test_the_movement_refuses_what_the_rest_only_doubted(sound: ImuChunk) -> None:
    late = resting_first(sound, 22.0)
    # Declared in rad/s, given in deg/s, of gyroscopes that have been calibrated at rest.
    rate = late.gyroscope_radps - late.gyroscope_radps[:, :500].mean(axis=1, keepdims=True)
    watch, told = asyncio.run(watched(replace(late, gyroscope_radps=np.degrees(rate))))
    of_one = [(f.code, f.severity) for _, f in told if f.sensor == "forearm_right"]
    assert of_one == [("gyroscope_unit", "warning"), ("gyroscope_unit", "refuse")]
    assert watch.refused == set(ARM)


def test_a_sensor_that_came_back_is_watched_anew(sound: ImuChunk) -> None:
    async def run() -> list[str]:
        watch, told = await watched(sound)
        watch.restart("forearm_right")
        again = []
        watch._tell = lambda found, _: again.extend(finding.code for finding in found)
        faulty = sound.gyroscope_radps.copy()
        faulty[1] = faulty[1][:, [1, 0, 2]]
        turned = replace(sound, gyroscope_radps=faulty, first_tick=sound.tick_count)
        for start in range(0, turned.tick_count - 10, 10):
            watch.add(turned.ticks(start, start + 10))
            if watch._checking is not None:
                await watch._checking
        assert told == []
        return again

    assert asyncio.run(run()) == ["gyroscope_axes"]


@pytest.mark.parametrize(("hemisphere", "codes"), [("south", {"gravity_reversed"}), ("unknown", set())])
def test_a_compass_is_judged_by_the_hemisphere_of_the_clinic(
    sound: ImuChunk, hemisphere: Hemisphere, codes: set[str]
) -> None:
    """A field that points down is wrong in the south only."""

    async def run() -> set[str]:
        told: list[Finding] = []
        watch = FirstSeconds(ARM, 0.01, lambda found, _: told.extend(found), hemisphere)
        for first, stop in ((0, 500), (500, 1700)):
            watch.add(sound.ticks(first, stop))
            assert watch._checking is not None
            await watch._checking
        return {finding.code for finding in told}

    assert asyncio.run(run()) == codes


def test_checks_of_all_sessions_together_leave_time_for_frames(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("app.live.checks.first_seconds.time.monotonic", lambda: now[0])
    turns = CheckTurns(share=0.1)
    assert turns.begin()
    assert not turns.begin(), "one at a time"
    now[0] += 0.5
    turns.end(0.5)
    now[0] += 4.4
    assert not turns.begin(), "half a second of checking asks for four and a half without"
    now[0] += 0.2
    assert turns.begin()


@pytest.mark.parametrize("fails", [False, True])
def test_a_sensor_that_was_away_is_begun_anew_with_also_after_a_check_that_failed(
    sound: ImuChunk, fails: bool
) -> None:
    begun: list[set[str]] = []

    def work(known: bytes, chunk: ImuChunk, gone: Collection[str]) -> Checked:
        begun.append(set(gone))
        if fails and len(begun) == 1:
            raise ValueError
        return check(known, chunk, gone)

    async def run() -> None:
        watch = FirstSeconds(ARM, sound.time_step_s, lambda *_: None, work=work)
        watch.restart(ARM[0])
        for first in (0, 400):
            watch._next_s = 0.0
            watch.add(sound.ticks(first, first + 400))
            assert watch._checking is not None
            await watch._checking

    asyncio.run(run())
    assert begun == [{ARM[0]}, {ARM[0]} if fails else set()]


def test_a_report_that_fails_does_not_end_the_checks_of_others(sound: ImuChunk) -> None:
    def fail(*_: object) -> None:
        raise ValueError

    async def run() -> None:
        turns = CheckTurns(share=1.0)
        watch = FirstSeconds(ARM, sound.time_step_s, fail, turns=turns)
        # A unit that cannot be right is reported.
        watch.add(replace(sound, accelerometer_mps2=sound.accelerometer_mps2 / 9.80665).ticks(0, 500))
        assert watch._checking is not None
        with pytest.raises(ValueError):
            await watch._checking
        await asyncio.sleep(0)
        assert turns.begin()

    asyncio.run(run())


@pytest.mark.parametrize("language", ["en", "de"])
def test_no_word_to_a_person_with_a_live_sensor_speaks_of_columns(language: str) -> None:
    """Every message that advises to declare, map or scale something has another one live."""
    of_tables = ("declare", "column", "multiply", "angegebenen", "Spalten", "malnehmen", "Geben Sie")
    dead = {"readings.magnetometer_zero", "readings.magnetometer_constant"}
    advises = {
        code
        for code, words in messages_in(language).items()
        if code.startswith("readings.")
        and "{where, code, place}" in words
        and any(word in words for word in of_tables)
    }
    assert {code for code in advises if not code.startswith("readings.live_")} <= {*_WORDS, *dead}
