"""What each kind of calibration makes of a simulated performance, chunk by chunk, without a server."""

import asyncio
import contextlib
import threading
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.errors import Conflict
from app.gateway.rehearsal import Rehearsal, rehearsal_of
from app.live.calibration.calibrating import (
    COLLECTORS,
    LINK_PATIENCE_S,
    NOT_EVALUATED,
    CalibrationController,
    redo_steps,
)
from app.live.calibration.collectors import Collector, Outcome
from app.live.calibration.device_collectors import Compass
from app.live.calibration.messages import CalibrationIn
from app.live.session.estimation import EstimationLine
from estimators import pipelines, signals
from estimators.calibration import MagnetometerCollector, MisplacedError, find_positions
from estimators.errors import CalibrationError
from estimators.pipelines import Pipeline, SessionSetup
from estimators.recording import ImuChunk
from estimators.simulation import ArmScenario, EarthField, Mounting
from tests.said import codes, refuses

RATE_HZ = 100.0
STEP = 50


def performed(shown: Rehearsal) -> tuple[Collector, Pipeline]:
    """Feed the recording as a live session does."""
    chunk = signals.to_common_ticks(shown.recording, RATE_HZ)
    worn: Any = tuple(shown.recording.sensors)
    pipeline = pipelines.create(SessionSetup("arm", worn, RATE_HZ))
    begin = 0
    if shown.first_pose:
        begin = 700
        pipeline.step(chunk.ticks(0, begin))
        pipeline.calibrate(chunk.ticks(350, 650))
    found = COLLECTORS[shown.wanted.kind](shown.wanted, worn, 1.0 / RATE_HZ)
    ends = list(shown.next_s)
    for tick in range(begin, chunk.tick_count - STEP, STEP):
        piece = chunk.ticks(tick, tick + STEP)
        pipeline.step(piece)
        if tick / RATE_HZ >= shown.start_s:
            found.add(piece)
        if ends and (tick + STEP) / RATE_HZ >= ends[0]:
            ends.pop(0)
            found.next()
        if found.is_reviewed and tick % 500 == 0:
            found.review()
        if found.is_complete or found.trouble:
            break
    return found, pipeline


def test_four_copies_of_one_sensor_are_refused_by_name() -> None:
    found, pipeline = performed(rehearsal_of("n_pose"))
    held = found._held[0]
    copied = [0, 0, 0, *range(3, held.sensor_count)]
    found._held = [
        replace(
            held,
            gyroscope_radps=held.gyroscope_radps[copied],
            accelerometer_mps2=held.accelerometer_mps2[copied],
        )
    ]
    with pytest.raises(CalibrationError, match="same signal, down to the noise") as refused:
        found.evaluate(pipeline)
    assert refused.value.args[0].parameters["where"] == list(found.placements[:3])


def test_a_pose_alone_never_has_full_marks() -> None:
    outcome, pipeline = evaluated(rehearsal_of("n_pose"))
    assert outcome.score <= 0.9
    assert pipeline.setup.calibration is not None
    assert pipeline.setup.calibration.score == outcome.score
    assert any("Not checked by a movement yet" in reason for reason in outcome.reasons)


def evaluated(shown: Rehearsal) -> tuple[Outcome, Pipeline]:
    found, pipeline = performed(shown)
    assert found.is_complete, (found.hint, found.trouble)
    return found.evaluate(pipeline), pipeline


@pytest.mark.parametrize(
    ("kind", "least_score"),
    [
        ("static_bias", 0.9),
        ("n_pose", 0.9),
        ("t_pose", 0.9),
        ("functional", 0.8),
        ("passive", 0.4),
        ("heading_reset", 0.9),
        ("six_position", 0.9),
        ("magnetometer", 0.9),
    ],
)
def test_every_kind_works_on_the_simulators_movements(kind: Any, least_score: float) -> None:
    outcome, pipeline = evaluated(rehearsal_of(kind))
    assert outcome.score >= least_score, outcome.reasons
    assert outcome.findings == ()
    if outcome.devices:
        assert pipeline.setup.devices == outcome.devices
        assert pipeline.setup.calibration is None, "worn anew, the body must be calibrated again"
    else:
        assert pipeline.setup.calibration == outcome.calibration
    assert outcome.details["kind"] == kind


def test_devices_are_found_as_they_are() -> None:
    shown = rehearsal_of("six_position")
    device = evaluated(shown)[0].devices["forearm_right"]
    assert device.gyroscope is not None
    assert np.diag(device.gyroscope.gain) == pytest.approx(1.0 / 1.01, abs=0.012)
    outcome = evaluated(rehearsal_of("magnetometer"))[0]
    compass = outcome.devices["forearm_right"].magnetometer
    assert compass is not None
    assert compass.bias == pytest.approx((15e-6, 0.0, 0.0), abs=5e-6)
    told = {field.placement: field for field in outcome.fields}
    earth = EarthField()
    assert told.keys() == outcome.devices.keys()
    assert told["forearm_right"].norm_ut == pytest.approx(1e6 * earth.norm_t, rel=0.05)
    assert told["forearm_right"].dip_deg == pytest.approx(np.degrees(earth.dip_rad), abs=2.0)
    assert told["forearm_right"].is_plausible
    assert outcome.devices["forearm_right"].field is not None


def test_a_field_that_cannot_be_the_earths_is_told() -> None:
    found, pipeline = performed(rehearsal_of("magnetometer"))
    found.hemisphere = "south"
    outcome = found.evaluate(pipeline)
    assert not any(field.is_plausible for field in outcome.fields)
    assert "southern half of the earth" in " ".join(outcome.reasons)
    again = found.evaluate(pipeline)
    assert again.fields[0].norm_before_ut == outcome.fields[0].norm_ut


def renamed(shown: Rehearsal, names: dict[str, str]) -> Rehearsal:
    """Put sensors on other segments than they are named after."""
    sensors = {names.get(name, name): found for name, found in shown.recording.sensors.items()}
    order = {name: sensors[name] for name in shown.recording.sensors}
    return replace(shown, recording=replace(shown.recording, sensors=order))


PARTS = ("upper_arm", "forearm", "hand")
SIDES = {f"{p}_{a}": f"{p}_{b}" for p in PARTS for a, b in (("left", "right"), ("right", "left"))}


def test_swapped_sides_are_named() -> None:
    found, pipeline = performed(renamed(rehearsal_of("functional"), SIDES))
    with refuses("placement.arms_swapped", error=MisplacedError) as caught:
        found.evaluate(pipeline)
    assert [finding.code for finding in caught.value.findings] == ["swapped_sides"]


def test_swapped_sides_are_seen_in_the_standing_pose() -> None:
    outcome, _ = evaluated(renamed(rehearsal_of("n_pose"), SIDES))
    assert {finding.code for finding in outcome.findings} == {"swapped_sides"}
    assert {p for finding in outcome.findings for p in finding.placements} == set(SIDES)


def test_swapped_segments_are_named() -> None:
    names = {"upper_arm_right": "forearm_right", "forearm_right": "upper_arm_right"}
    found, pipeline = performed(renamed(rehearsal_of("functional"), names))
    with pytest.raises(MisplacedError, match="swapped") as caught:
        found.evaluate(pipeline)
    (finding,) = caught.value.findings
    assert (finding.code, finding.placements) == ("swapped_segments", ("upper_arm_right", "forearm_right"))


@pytest.mark.parametrize("kind", ["n_pose", "functional"])
def test_a_sensor_turned_by_half_a_turn_is_named_and_allowed_for(kind: Any) -> None:
    from estimators import rotation
    from estimators.simulation import outward_mounting

    flipped = rotation.multiply(outward_mounting("forearm_right"), rotation.exp(np.array([np.pi, 0, 0])))
    w, x, y, z = (float(v) for v in flipped)
    person = ArmScenario(seed=4, mounting=Mounting(q_segment_sensor={"forearm_right": (w, x, y, z)}))
    outcome, _ = evaluated(rehearsal_of(kind, person))
    assert [(f.code, f.placements) for f in outcome.findings] == [("turned", ["forearm_right"])]
    assert outcome.score > 0.5


def test_a_movement_that_was_left_out_is_named_to_be_repeated() -> None:
    shown = rehearsal_of("functional")
    early = (*shown.next_s[:2], shown.next_s[1] + 1.0, shown.next_s[1] + 2.0)
    with pytest.raises(Conflict, match="three times"):
        performed(replace(shown, next_s=early))
    # While the arm is raised forward both steps are ended: nothing was raised sideways.
    early = (*shown.next_s[:2], shown.next_s[1] + 6.0, shown.next_s[2] - 1.0)
    found, pipeline = performed(replace(shown, next_s=early))
    with pytest.raises(CalibrationError, match="repeat"):
        found.evaluate(pipeline)


def test_headings_set_anew_take_drift_away() -> None:
    shown = rehearsal_of("heading_reset")
    found, pipeline = performed(shown)
    known = pipeline.setup.calibration
    assert known is not None
    from estimators.pipelines import ArmPipeline

    assert isinstance(pipeline, ArmPipeline)
    # A heading that has drifted by 20 degrees since the calibration.
    pipeline._network.adopt(replace(known, heading_offset_rad={"forearm_right": 0.35}), None)
    outcome = found.evaluate(pipeline)
    assert outcome.calibration is not None
    assert outcome.calibration.heading_offset_rad["forearm_right"] == pytest.approx(0.0, abs=0.05)


def test_steps_that_end_by_themselves_cannot_be_ended() -> None:
    worn: Any = ("upper_arm_right", "forearm_right")
    for kind in ("n_pose", "functional", "six_position"):
        found = COLLECTORS[kind](CalibrationIn(kind=kind), worn, 0.01)  # type: ignore[index, arg-type]
        with pytest.raises(Conflict, match=r"by itself|keep still"):
            found.next()
    with pytest.raises(Conflict, match="upper arm and forearm"):
        COLLECTORS["functional"](CalibrationIn(kind="functional"), ("sternum",), 0.01)


def test_the_compass_is_reviewed_and_evaluated_at_the_same_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody ends the turning while its progress is worked out in another thread: no reading is lost."""
    busy, most = 0, 0

    class Slow(MagnetometerCollector):
        def add(self, *readings: Any) -> None:
            nonlocal busy, most
            busy += 1
            most = max(most, busy)
            time.sleep(0.002)
            super().add(*readings)
            busy -= 1

    monkeypatch.setattr("app.live.calibration.device_collectors.MagnetometerCollector", Slow)
    chunk = signals.to_common_ticks(rehearsal_of("magnetometer").recording, RATE_HZ).ticks(0, 1000)
    worn: Any = ("forearm_right",)
    found = Compass(CalibrationIn(kind="magnetometer", placements=list(worn)), worn, 0.01)
    one = replace(
        chunk,
        gyroscope_radps=chunk.gyroscope_radps[:1],
        accelerometer_mps2=chunk.accelerometer_mps2[:1],
        magnetometer_t=chunk.magnetometer_t[:1] if chunk.magnetometer_t is not None else None,
        quality=chunk.quality[:1],
    )
    for tick in range(0, 1000, STEP):
        found.add(one.ticks(tick, tick + STEP))
    pipeline = pipelines.create(SessionSetup("arm", ("upper_arm_right",), RATE_HZ))

    def evaluate() -> None:
        with contextlib.suppress(CalibrationError):
            found.evaluate(pipeline)

    threads = [threading.Thread(target=work) for work in (found.review, evaluate)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == 1
    assert found._fits[0].sample_count == 1000 * 20 / RATE_HZ


def test_a_calibration_that_breaks_down_is_to_be_repeated(caplog: pytest.LogCaptureFixture) -> None:
    """What no one foresaw in the evaluation must not reach the estimation of the session."""

    async def run() -> tuple[list[str], list[str]]:
        phases: list[str] = []
        failed: list[str] = []
        ended: list[Exception] = []
        pipeline = pipelines.create(SessionSetup("arm", ("upper_arm_right",), RATE_HZ))
        line = EstimationLine(pipeline, lambda *_: None, ended.append)
        desk = CalibrationController(
            ("upper_arm_right",),
            0.01,
            line,
            tell=lambda message: phases.append(message.phase),
            changed=lambda: None,
            done=lambda *_: None,
            failed=failed.append,
        )
        desk.start(CalibrationIn(kind="magnetometer"))
        assert desk._collector is not None
        desk._collector.evaluate = lambda _: [][0]  # type: ignore[method-assign]
        desk.next()
        await line.drained()
        await asyncio.sleep(0)
        assert (ended, line.is_running, desk.is_active) == ([], True, False)
        return phases, failed

    phases, failed = asyncio.run(run())
    assert phases[-1] == "redo"
    assert failed == [NOT_EVALUATED]
    assert "could not be evaluated" in caplog.text


@pytest.mark.parametrize(
    ("kind", "away_s", "goes_on"),
    [("n_pose", 3.0, True), ("n_pose", LINK_PATIENCE_S + 1.0, False), ("six_position", 3.0, False)],
)
def test_a_lost_link_ends_only_what_a_gap_spoils(
    monkeypatch: pytest.MonkeyPatch, kind: Any, away_s: float, goes_on: bool
) -> None:
    async def run() -> tuple[list[str], bool]:
        phases: list[str] = []
        pipeline = pipelines.create(SessionSetup("arm", ("upper_arm_right",), RATE_HZ))
        desk = CalibrationController(
            ("upper_arm_right",),
            0.01,
            EstimationLine(pipeline, lambda *_: None, lambda _: None),
            tell=lambda message: phases.append(message.phase),
            changed=lambda: None,
            done=lambda *_: None,
            failed=lambda _: None,
        )
        assert not desk.link_back()
        desk.start(CalibrationIn(kind=kind))
        desk.link_lost()
        back_s = time.monotonic() + away_s
        monkeypatch.setattr(time, "monotonic", lambda: back_s)
        return phases, desk.link_back()

    assert asyncio.run(run()) == (["collecting"] + ["cancelled"] * (not goes_on), goes_on)


def test_a_gap_in_a_turn_leaves_the_step_open() -> None:
    """The two ends of a gap must not be put together: the angle between them would be missing."""
    shown = rehearsal_of("six_position")
    worn: Any = ("forearm_right",)
    chunk = signals.to_common_ticks(shown.recording, RATE_HZ)
    row = list(shown.recording.sensors).index("forearm_right")
    rate, force = chunk.gyroscope_radps[[row]], chunk.accelerometer_mps2[[row]]
    turn = next(t for t in find_positions(rate[0], force[0], RATE_HZ)[1] if t.axis == "x")
    middle = (turn.start + turn.stop) // 2
    found = COLLECTORS["six_position"](CalibrationIn(kind="six_position", placements=worn), worn, 0.01)
    lost = rate.copy()
    lost[:, middle : middle + 25] = np.nan
    found.add(ImuChunk(0, 0.01, lost, force, None, np.zeros(rate.shape[:2], np.uint8)))
    found.review()
    assert [step.key for step in found.steps if step.key not in found.sensors[0].found] == ["turn_x"]
    with refuses("six_position.turn_missing", axes=["x"]) as caught:
        found.evaluate(pipelines.create(SessionSetup("arm", ("upper_arm_right",), RATE_HZ)))
    assert redo_steps(found, caught.value.redo) == ["turn_x"]


def test_a_turn_that_was_not_whole_is_told_while_it_can_be_repeated() -> None:
    shown = rehearsal_of("six_position")
    worn: Any = ("forearm_right",)
    chunk = signals.to_common_ticks(shown.recording, RATE_HZ)
    row = list(shown.recording.sensors).index("forearm_right")
    rate, force = chunk.gyroscope_radps[[row]].copy(), chunk.accelerometer_mps2[[row]]
    turn = next(t for t in find_positions(rate[0], force[0], RATE_HZ)[1] if t.axis == "x")
    rate[:, turn.start : turn.stop, 0] *= 315 / 360
    found = COLLECTORS["six_position"](CalibrationIn(kind="six_position", placements=worn), worn, 0.01)
    found.add(ImuChunk(0, 0.01, rate, force, None, np.zeros(rate.shape[:2], np.uint8)))
    found.review()
    assert "turn_x" not in found.sensors[0].found
    assert codes(found.hint) == ["live.turned_too_little"]
