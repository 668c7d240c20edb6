"""The parts of a live session, each for itself: states, ledger, bus, pose, health, estimation in order."""

import asyncio
from typing import Any, get_args

import numpy as np
import pytest

from app.errors import Conflict
from app.live.blocks import PublishedFrames, column_names
from app.live.bus import MemoryBus, topic
from app.live.calibration.pose import PoseCollector
from app.live.checks.health import LinkHealth
from app.live.session.estimation import INLINE_TICKS, EstimationLine
from app.live.session.ledger import GIVE_UP_AFTER_S, REPORT_AFTER_S, SequenceLedger
from app.live.session.states import OPEN, STREAMING, TRANSITIONS, StateMachine, streaming_state
from app.schemas import SessionState
from estimators.orientation import OrientationFlag
from estimators.pipelines import FrameLayout, Frames
from estimators.recording import ImuChunk, SampleQuality
from tests.said import refuses

STATES: tuple[SessionState, ...] = get_args(SessionState)
ALLOWED = {
    ("created", "calibrating"), ("created", "ready"), ("created", "closing"), ("created", "failed"),
    ("calibrating", "ready"), ("calibrating", "link_lost"), ("calibrating", "closing"),
    ("calibrating", "failed"),
    ("ready", "calibrating"), ("ready", "recording"), ("ready", "link_lost"), ("ready", "closing"),
    ("ready", "failed"),
    ("recording", "ready"), ("recording", "link_lost"), ("recording", "closing"), ("recording", "failed"),
    ("link_lost", "calibrating"), ("link_lost", "ready"), ("link_lost", "recording"),
    ("link_lost", "closing"), ("link_lost", "failed"),
    ("closing", "analysed"), ("closing", "failed"),
    ("analysed", "closing"),
    ("failed", "closing"),
}  # fmt: skip


@pytest.mark.parametrize("before", STATES)
@pytest.mark.parametrize("after", STATES)
def test_only_the_agreed_changes_of_state_are_possible(before: SessionState, after: SessionState) -> None:
    machine = StateMachine(before)
    if before == after:
        assert machine.to(after, "again") is False
    elif (before, after) in ALLOWED:
        assert machine.to(after, "because") is True
        assert (machine.state, machine.reason) == (after, "because")
    else:
        with refuses("live.state", error=Conflict, state=before, following=after):
            machine.to(after)
        assert machine.state == before


def test_every_state_is_in_the_table_and_has_its_kind() -> None:
    assert set(TRANSITIONS) == set(STATES)
    assert STREAMING < OPEN
    assert "closing" not in OPEN
    assert streaming_state(is_calibrated=False, is_recording=False) == "calibrating"
    assert streaming_state(is_calibrated=True, is_recording=False) == "ready"
    assert streaming_state(is_calibrated=True, is_recording=True) == "recording"


def test_the_ledger_asks_for_holes_and_gives_them_up() -> None:
    ledger = SequenceLedger()
    for sequence in (0, 1, 4, 5, 7):
        ledger.received.add(sequence)
    assert ledger.acknowledged == -1, "nothing is durable yet"
    ledger.durable = ledger.received.copy()
    assert (ledger.acknowledged, ledger.highest, ledger.missing_count) == (1, 7, 3)
    assert ledger.review(0.2) == [], "it may be mere reordering"
    assert ledger.review(REPORT_AFTER_S) == [(2, 4), (6, 7)]
    ledger.received.add(6)
    ledger.durable = ledger.received.copy()
    assert ledger.review(GIVE_UP_AFTER_S) == []
    assert ledger.acknowledged == 7
    assert list(ledger.given_up) == [(2, 4)]
    ledger.received.add(3)
    assert ledger.missing_count == 1, "what comes after all is counted"


def test_after_a_goodbye_the_end_is_asked_for_too() -> None:
    ledger = SequenceLedger()
    ledger.received.add_range(0, 10)
    ledger.durable = ledger.received.copy()
    assert not ledger.is_settled
    ledger.last_sequence = 11
    ledger.review(0.0)
    assert ledger.review(REPORT_AFTER_S) == [(10, 12)]
    assert not ledger.is_settled
    ledger.received.add_range(10, 12)
    ledger.durable = ledger.received.copy()
    ledger.review(0.1)
    assert ledger.is_settled


def test_a_slow_listener_loses_the_oldest_and_nobody_else_does() -> None:
    async def run() -> None:
        bus = MemoryBus()
        name = topic("s", "frames")
        assert not bus.has_listeners(name)
        with bus.subscribe(name, size=3) as slow, bus.subscribe(name, topic("s", "state"), size=10) as other:
            for number in range(5):
                bus.publish(name, number)
            bus.publish(topic("s", "state"), "ready")
            assert [item for _, item in await slow.wait()] == [2, 3, 4]
            assert slow.dropped == 2
            assert [item for _, item in other.take()] == [0, 1, 2, 3, 4, "ready"]
            reading = asyncio.create_task(anext(aiter(slow)))
            await asyncio.sleep(0)
            bus.publish(name, 9)
            assert await reading == 9
        assert not bus.has_listeners(name)
        assert (bus.metrics.published, bus.metrics.dropped) == (7, 2)
        assert await slow.wait() == [], "closed"

    asyncio.run(run())


def chunk(
    first: int, ticks: int = 5, *, sensors: int = 2, turning: float = 0.0, quality: int = 0, tilt: float = 0.0
) -> ImuChunk:
    still = np.zeros((sensors, ticks, 3))
    gravity = still + np.array([9.81 * np.sin(tilt), 0.0, 9.81 * np.cos(tilt)])
    return ImuChunk(
        first, 0.01, still + turning, gravity, None, np.full((sensors, ticks), quality, dtype=np.uint8)
    )


def test_the_pose_is_three_still_seconds_in_a_row_once_the_filters_have_settled() -> None:
    collector = PoseCollector(("sternum", "forearm_left"), 0.01)
    assert collector.add(chunk(0)) is None
    assert collector.progress is None
    collector.begin()
    for i in range(1, 60):
        assert collector.add(chunk(5 * i)) is None
    assert collector.progress == 0.0
    assert "settling" in collector.hint
    for i in range(60, 100):
        assert collector.add(chunk(5 * i)) is None
    assert collector.progress == pytest.approx(2.0 / 3.0)
    assert collector.add(chunk(500, turning=0.5)) is None
    assert collector.progress == 0.0
    assert "Hold still: the chest and left forearm moved." in collector.hint
    found = [collector.add(chunk(505 + 5 * i)) for i in range(60)]
    assert found[:-1] == [None] * 59
    pose = found[-1]
    assert pose is not None
    assert (pose.first_tick, pose.tick_count) == (505, 300)
    assert collector.progress is None


def test_a_gap_makes_the_filters_settle_again() -> None:
    collector = PoseCollector(("sternum", "forearm_left"), 0.01)
    collector.add(chunk(1000, quality=SampleQuality.MISSING))
    collector.begin()
    found = [collector.add(chunk(1005 + 5 * i)) for i in range(120)]
    assert found[:-1] == [None] * 119
    assert found[-1] is not None
    assert found[-1].first_tick == 1305


def test_the_pose_ends_with_a_slow_tilt_or_a_silent_sensor() -> None:
    collector = PoseCollector(("sternum", "forearm_left"), 0.01)
    collector.begin()
    for i in range(50):
        collector.add(chunk(300 + 5 * i, tilt=0.0025 * i))
    # 0.8 m/s^2 of 9.81 are 4.7 degrees, reached after 33 chunks.
    assert collector.progress is not None
    assert 0.0 < collector.progress < 0.5
    silent = chunk(550)
    silent.quality[1] = SampleQuality.MISSING
    collector.add(silent)
    assert "No data from: left forearm." in collector.hint
    for i in range(1200):
        collector.add(chunk(555 + 5 * i, turning=1.0))
    assert not collector.is_active
    assert "never still" in collector.hint


def test_a_sensor_is_told_lost_once_and_back_once() -> None:
    health = LinkHealth(("sternum", "forearm_left"), 0.01)
    told = []
    for i in range(60):
        part = chunk(5 * i)
        if 10 <= i < 30:
            part.quality[1] = SampleQuality.MISSING
        told += [(change.placement, change.is_lost, change.tick) for change in health.add_chunk(part)]
    assert told == [("forearm_left", True, 50), ("forearm_left", False, 150)]


def test_health_is_the_same_list_until_jitter_has_moved_by_more_than_its_step() -> None:
    health = LinkHealth(("sternum",), 0.01)
    health.add_packets([(0.0, 0.0), (0.05, 0.05 + 8e-3)])
    shown = health.sensors(link_is_up=True)
    assert shown[0].jitter_ms == 0.0, "8 ms / 16 is half a millisecond"
    health.add_packets([(0.1, 0.1 + 1e-3)])
    assert health.sensors(link_is_up=True) is shown
    health.add_packets([(0.15, 0.15 + 30e-3)])
    (sternum,) = health.sensors(link_is_up=True)
    assert sternum.jitter_ms == 2.5, "2.66 to half a millisecond"


@pytest.mark.parametrize(
    ("flags", "is_starting"),
    [
        (OrientationFlag.CONVERGING | OrientationFlag.HEADING_NOT_TRUSTED, True),
        (OrientationFlag.HEADING_NOT_TRUSTED, False),
    ],
)
def test_health_tells_a_start_from_a_heading_that_is_lost(flags: OrientationFlag, is_starting: bool) -> None:
    health = LinkHealth(("sternum",), 0.01)
    health.set_flags(("sternum",), np.array([[flags]], dtype=np.uint8))
    (sternum,) = health.sensors(link_is_up=True)
    assert (sternum.heading_trusted, sternum.is_starting) == (False, is_starting)


def test_health_counts_loss_jitter_and_saturation() -> None:
    health = LinkHealth(("sternum", "forearm_left"), 0.01)
    for i in range(20):
        part = chunk(5 * i)
        part.quality[1] = SampleQuality.BRIDGED if i % 2 else SampleQuality.SATURATED
        health.add_chunk(part)
        health.add_packets([(0.05 * i, 0.05 * i + (0.016 if i % 2 else 0.0))])
    health.set_flags(("sternum", "forearm_left"), np.array([[255, 255], [0, 16 | 32]], dtype=np.uint8))
    sternum, forearm = health.sensors(link_is_up=True)
    assert (sternum.status, sternum.loss_percent, sternum.saturated) == ("ok", 0.0, False)
    assert (forearm.status, forearm.loss_percent, forearm.saturated) == ("noisy", 50.0, True)
    assert (forearm.magnetic_disturbance, forearm.heading_trusted) == (True, False)
    # Transit alternates by 16 ms: the running mean of RFC 3550 tends to 16, by now 1 - (15/16)^19 = 71 %.
    assert sternum.jitter_ms == pytest.approx(16 * (1 - (15 / 16) ** 19), abs=0.25)
    assert {sensor.status for sensor in health.sensors(link_is_up=False)} == {"lost"}
    assert health.latency_ms() == (None, None)
    health.latencies_s.extend([0.01] * 99 + [0.2])
    assert health.latency_ms()[0] == 10.0


LAYOUT = FrameLayout(segments=("sternum",), points=("neck",), angles=("a", "b"), scalars=("lean_rad",))


def frames(first: int, ticks: int) -> Frames:
    return Frames(
        layout=LAYOUT,
        first_tick=first,
        time_step_s=0.01,
        q_room_segment=np.zeros((ticks, 1, 4)),
        point_room_m=np.full((ticks, 1, 3), 5.0),
        angle_rad=np.stack([np.arange(ticks) * 1.0, np.full(ticks, np.nan)], axis=1),
        angle_sigma_rad=np.full((ticks, 2), 3.0),
        scalar=np.full((ticks, 1), 4.0),
        segment_flags=np.full((ticks, 1), 255, dtype=np.uint8),
        angle_flags=np.full((ticks, 2), 128, dtype=np.uint8),
    )


def test_a_block_holds_the_columns_that_the_layout_names() -> None:
    columns = column_names(LAYOUT)
    assert columns == [
        "a", "b", "a.sigma", "b.sigma", "lean_rad", "neck.x", "neck.y", "neck.z", "sternum.flags", "a.flags",
        "b.flags",
    ]  # fmt: skip
    published = PublishedFrames(frames(2**32 + 7, 3), 1234.5)
    block = published.block
    assert published.block is block, "made once for all who watch"
    header = np.frombuffer(block[:40], dtype="<u4,<u4,<u4,<u4,<f8,<f8,<f8")[0].tolist()
    assert block[:4] == b"TMF1"
    assert header[1:] == (3, 11, 7, (2**32 + 7) * 0.01, 0.01, 1234.5)
    rows = np.frombuffer(block[40:], dtype="<f4").reshape(3, 11)
    assert rows[2].tolist()[:1] == [2.0]
    assert np.isnan(rows[:, 1]).all()
    assert rows[0].tolist()[2:] == [3.0, 3.0, 4.0, 5.0, 5.0, 5.0, 255.0, 128.0, 128.0]


class CountingPipeline:
    """Stands for a pipeline where only the order of calls matters."""

    def __init__(self, fail_at: int | None = None) -> None:
        self.next_tick = 0
        self.fail_at = fail_at

    def step(self, part: ImuChunk) -> Any:
        assert part.first_tick == self.next_tick
        self.next_tick += part.tick_count
        if self.fail_at is not None and part.first_tick >= self.fail_at:
            raise ZeroDivisionError
        return frames(part.first_tick, part.tick_count)


def test_long_work_keeps_the_order_of_what_comes_meanwhile() -> None:
    async def run() -> None:
        done: list[Any] = []
        pipeline: Any = CountingPipeline()
        line = EstimationLine(pipeline, lambda c, f, a: done.append((c.first_tick, a)), done.append)
        line.push(chunk(0), 1.0)
        assert done == [(0, 1.0)], "a few ticks are estimated at once"
        line.push(chunk(5, 450), 2.0)
        line.call(lambda: done.append("calibrated"))
        line.push(chunk(455), 3.0)
        assert len(done) == 1
        assert line.waiting_ticks == 455
        await line.drained()
        assert done[1:] == [(5, 2.0), (205, 2.0), (405, 2.0), "calibrated", (455, 3.0)]
        line.push(chunk(460, INLINE_TICKS), 4.0)
        assert done[-1] == (460, 4.0)

    asyncio.run(run())


@pytest.mark.parametrize("ticks", [5, 1000])
def test_a_pipeline_that_raises_stops_its_own_line_once(ticks: int) -> None:
    async def run() -> None:
        errors: list[Exception] = []
        pipeline: Any = CountingPipeline(fail_at=5)
        line = EstimationLine(pipeline, lambda c, f, a: None, errors.append)
        line.push(chunk(0), None)
        line.push(chunk(5, ticks), None)
        line.push(chunk(5 + ticks), None)
        await line.drained()
        line.push(chunk(10 + ticks), None)
        assert [type(error) for error in errors] == [ZeroDivisionError]
        assert not line.is_running

    asyncio.run(run())
