"""Guidance of a live session: what is counted, said and stopped is what a patient of known truth did."""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.accounts.models import Clinic
from app.assessment.design.prescribed import prescribed_guidance
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, Unavailable
from app.limits import Limits
from app.live import repository, warmup
from app.live.bus import MemoryBus, topic
from app.live.calibration.messages import CalibrationIn
from app.live.engine.shared import Shared
from app.live.guidance.controller import GuidanceController
from app.live.guidance.messages import GuidanceMessage
from app.live.manager import LiveManager
from app.live.session.runner import LiveSession
from app.live.warmup import GUIDANCE, Kind, Readiness, load_or_compile
from app.network.declaration import check_hello
from app.network.packet import decode_packet
from app.recordings import service
from app.recordings.models import MotionSession, SessionEvent
from app.recordings.schemas import SessionIn
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Settings
from estimators.simulation import ExerciseName
from tests.app.live.guided import EXERCISE, LEANING, N_POSE_S, SHORT, SOUND, Performed, performed, prescribe
from tests.patience import PATIENCE_S

GOOD_AND_SHORT = (SOUND, SOUND, SHORT, SOUND)
RECORD_AT_S = N_POSE_S + 1.6


class Room:
    """A live session in this process, fed packet by packet."""

    def __init__(self, manager: LiveManager, live: LiveSession, done: Performed) -> None:
        self.manager, self.live, self.done = manager, live, done
        self.messages: list[GuidanceMessage] = []
        self._next = 0
        self._listener = manager.bus.subscribe(topic(live.id, "guidance"), size=100_000)

    @property
    def desk(self) -> GuidanceController:
        return self.manager.guidance(self.live.id)

    @property
    def sent_s(self) -> float:
        """The session time of the next packet."""
        return self._next * self.done.stream.packet_s

    async def until(self, time_s: float) -> None:
        """Send what comes before a session time."""
        stream = self.done.stream
        while self._next < stream.packet_count and self.sent_s < time_s:
            packet = decode_packet(stream.packet(self._next))
            self.live.receive(packet, time.monotonic(), time.time_ns())
            self._next += 1
            if self._next % 20 == 0:
                await asyncio.sleep(0)
        await self.live.line.drained()
        self.messages += [message for _, message in self._listener.take()]

    async def to_the_start(self) -> None:
        """Hold the pose, be calibrated, and let the repetitions count from the rest before the first one on."""
        await self.until(1.0)
        self.live.start_calibration(CalibrationIn(kind="n_pose"))
        await self.until(RECORD_AT_S)
        async with asyncio.timeout(PATIENCE_S):
            # The pose is evaluated in a thread, which has nothing to wait for.
            while self.live.state != "ready":  # noqa: ASYNC110
                await asyncio.sleep(0.01)
        self.live.record()

    async def to_the_end(self) -> None:
        await self.until(np.inf)

    @property
    def cues(self) -> list[str]:
        """Every cue once, in order."""
        said = {one.cue_number: one.cue for one in self.messages if one.cue}
        return [said[number] for number in sorted(said)]


Enter = Callable[..., Any]


@pytest.fixture
def enter(engine: Engine, settings: Settings, world: Any) -> Iterator[Enter]:
    """Return a function that runs work in a live session of Ada's."""
    writer = GroupCommitWriter(engine)
    writer.start()

    async def opened(manager: LiveManager, done: Performed, prescription_id: str | None) -> Room:
        subject = world.subjects["therapist"]
        wanted = SessionIn(
            patient_id=world.patient_id,
            exercise_id=world.exercise_id,
            prescription_id=prescription_id,
            placements=list(done.stream.placements),  # type: ignore[arg-type]
        )
        with unit_of_work(engine) as session:
            made = service.create(session, subject, wanted)
        return await taken_up(manager, done, made.id)

    async def taken_up(manager: LiveManager, done: Performed, session_id: str) -> Room:
        ticket, _ = repository.give_ticket(engine, world.subjects["therapist"], session_id, "ingest")
        hello = done.stream.hello(ticket)
        intake = await manager.open(hello, check_hello(hello))
        return Room(manager, manager.live(intake.session_id), done)

    def run(
        plan: Any,
        work: Callable[..., Any],
        prescription_id: str | None = None,
        session_id: str | None = None,
        exercise: ExerciseName = EXERCISE,
        prepare: Callable[[Kind], None] = load_or_compile,
    ) -> Any:
        async def inside() -> Any:
            limits = Limits({"streams": settings.limit_streams})
            shared = Shared(readiness=Readiness(prepare))
            manager = LiveManager(engine, writer, MemoryBus(), lambda _: None, limits=limits, shared=shared)
            done = performed(plan, exercise=exercise)
            opening = (
                taken_up(manager, done, session_id) if session_id else opened(manager, done, prescription_id)
            )
            room = await opening
            await work(room)
            await room.live.saved()
            await asyncio.wrap_future(writer.flush(room.live.id))
            return room

        return asyncio.run(inside())

    yield run
    writer.close()


def stored(engine: Engine, session_id: str, *kinds: str) -> list[SessionEvent]:
    with read_only(engine) as session:
        query = select(SessionEvent).where(
            SessionEvent.session_id == session_id, SessionEvent.kind.in_(kinds)
        )
        return list(session.scalars(query.order_by(SessionEvent.time_s)))


async def whole(room: Room) -> None:
    await room.to_the_start()
    await room.to_the_end()


def test_only_a_session_that_is_guided_waits_for_guidance_to_be_compiled(
    enter: Enter, engine: Engine, world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warmup, "PATIENCE_S", 0.2)
    may_end, send_away = threading.Event(), LiveManager._send_away

    def prepare(kind: Kind) -> None:
        if kind == GUIDANCE:
            may_end.wait(PATIENCE_S)

    def release(manager: LiveManager, *why: Any) -> None:
        # The loop ends with its threads: none may wait for long.
        may_end.set()
        send_away(manager, *why)

    monkeypatch.setattr(LiveManager, "_send_away", release)

    async def is_open(room: Room) -> None:
        assert room.live.id

    enter((SOUND, SOUND), is_open, prepare=prepare)
    with pytest.raises(Unavailable, match="prepared"):
        enter((SOUND, SOUND), is_open, prescribe(engine, world), prepare=prepare)
    assert enter((SOUND, SOUND), is_open, prescribe(engine, world), prepare=prepare).desk.message


def test_three_good_ones_and_a_short_one(enter: Enter, engine: Engine, world: Any) -> None:
    room = enter(GOOD_AND_SHORT, whole, prescribe(engine, world))
    assert room.desk.message.counts.model_dump() == {"valid": 3, "partial": 1, "wrong": 0}
    # The third sound one in silence is praised.
    assert room.cues == ["A little further.", "Well done."]
    events = stored(engine, room.live.id, "repetition")
    assert [one.details["kind"] for one in events] == ["valid", "valid", "partial", "valid"]
    for one, (start_s, end_s) in zip(events, room.done.repetitions_s, strict=True):
        # The page of the method: the count falls up to 0.3 s after the end.
        assert one.time_s == pytest.approx(end_s, abs=0.6)
        assert one.details["start_s"] == pytest.approx(start_s, abs=0.8)
    cue = stored(engine, room.live.id, "cue")[0]
    short_s = room.done.repetitions_s[2]
    assert short_s[0] < cue.time_s < short_s[1] + 0.3
    assert cue.details["sentence"] == "guidance.further"
    told = next(one for one in room.messages if one.cue_number == 1)
    # It goes out with the packet that holds its tick.
    assert told.time_s - cue.time_s <= room.done.stream.packet_s + 1e-6


def test_a_link_that_is_lost_within_a_repetition_takes_it_from_nobody(
    enter: Enter, engine: Engine, world: Any
) -> None:
    async def loses_the_link(room: Room) -> None:
        await room.to_the_start()
        start_s, end_s = room.done.repetitions_s[1]
        await room.until(0.5 * (start_s + end_s))
        # What was measured before the loss is still to be estimated when the loss is noticed, as on a busy machine.
        may_go_on = threading.Event()
        room.live.line.call(lambda: bool(may_go_on.wait(PATIENCE_S)))
        measured = asyncio.ensure_future(room.until(end_s - 0.3))
        # The line wakes nobody: it has nothing but the packets themselves.
        while room.sent_s < end_s - 0.3:  # noqa: ASYNC110
            await asyncio.sleep(0)
        room.live.link_lost("nothing came for two seconds")
        may_go_on.set()
        await measured
        await room.to_the_end()

    room = enter((SOUND, SOUND), loses_the_link, prescribe(engine, world))
    assert room.desk.message.counts.model_dump() == {"valid": 2, "partial": 0, "wrong": 0}


def test_the_example_goes_with_the_patient_and_waits(enter: Enter, engine: Engine, world: Any) -> None:
    room = enter((SOUND, SOUND), whole, prescribe(engine, world))
    for start_s, end_s in room.done.repetitions_s:
        during = [one for one in room.messages if start_s + 0.7 < one.time_s < end_s - 0.3]
        assert {one.status for one in during} == {"moving"}
        shown = np.array([one.ghost_phase for one in during], float)
        assert (np.diff(shown) > -0.05).all()
        assert shown[0] < 0.35
        assert shown[-1] > 0.75
    between = [one for one in room.messages if one.status == "ready"]
    assert between
    assert {one.ghost_phase for one in between} == {0.0}


def test_a_lean_is_said_once_and_sound_ones_are_left_in_peace(
    enter: Enter, engine: Engine, world: Any
) -> None:
    room = enter((SOUND, LEANING, SOUND), whole, prescribe(engine, world))
    assert room.cues[0] == "Stand tall."
    assert set(room.cues) == {"Stand tall."}
    start_s, end_s = room.done.repetitions_s[1]
    assert all(start_s < one.time_s < end_s + 0.3 for one in stored(engine, room.live.id, "cue"))


def test_a_knee_is_guided_as_an_arm(enter: Enter, engine: Engine, world: Any) -> None:
    prescription = prescribe(engine, world, exercise="knee_extension")
    room = enter((SOUND, SHORT, LEANING, SOUND), whole, prescription, exercise="knee_extension")
    events = stored(engine, room.live.id, "repetition")
    assert [one.details["kind"] for one in events] == ["valid", "partial", "valid", "valid"]
    assert room.cues == ["A little further.", "Stand tall."]
    for cue, (start_s, end_s) in zip(
        stored(engine, room.live.id, "cue"), room.done.repetitions_s[1:3], strict=True
    ):
        assert start_s < cue.time_s < end_s + 0.3


def test_pain_stops_at_once_and_until_somebody_goes_on(enter: Enter, engine: Engine, world: Any) -> None:
    async def work(room: Room) -> None:
        await room.to_the_start()
        start_s, end_s = room.done.repetitions_s[1]
        await room.until(0.5 * (start_s + end_s))
        said = room.desk.obey("pain")
        assert (said.status, said.cause) == ("stopped", "pain")
        room.desk.obey("pain")
        await room.until(room.done.repetitions_s[2][1] + 0.5)
        assert room.desk.message.counts.valid == 1
        assert room.desk.message.status == "stopped"
        assert room.desk.obey("resume").status == "waiting"
        await room.to_the_end()

    room = enter((SOUND, SOUND, SOUND, SOUND), work, prescribe(engine, world))
    assert room.desk.message.counts.valid == 2
    assert len(stored(engine, room.live.id, "pain")) == 1
    assert len(stored(engine, room.live.id, "guidance_resume")) == 1


def test_a_pause_counts_nothing_and_an_end_stays_an_end(enter: Enter, engine: Engine, world: Any) -> None:
    async def work(room: Room) -> None:
        await room.to_the_start()
        await room.until(room.done.repetitions_s[0][1] + 0.5)
        assert room.desk.obey("pause").status == "paused"
        await room.to_the_end()
        assert room.desk.message.counts.valid == 1
        assert room.desk.obey("stop").status == "stopped"
        with pytest.raises(Conflict):
            room.desk.obey("resume")

    enter((SOUND, SOUND), work, prescribe(engine, world))


def test_the_prescribed_number_ends_it(enter: Enter, engine: Engine, world: Any) -> None:
    room = enter((SOUND, SOUND, SOUND), whole, prescribe(engine, world, repetitions=2))
    assert room.desk.message.counts.valid == 2
    assert (room.desk.message.status, room.desk.message.cause) == ("stopped", "valid_count")
    assert room.desk.message.goal == 2


def test_a_set_is_a_rest_and_only_the_prescribed_number_the_end(
    enter: Enter, engine: Engine, world: Any
) -> None:
    async def first_set(room: Room) -> None:
        await room.to_the_start()
        await room.until(room.done.repetitions_s[1][1] + 0.6)
        assert (room.desk.message.status, room.desk.message.cause) == ("paused", "set")
        assert room.desk.obey("resume").cause == ""

    prescription_id = prescribe(engine, world, repetitions=4, stops=({"kind": "valid_count", "limit": 2},))
    first = enter((SOUND,) * 5, first_set, prescription_id)
    assert (first.desk.message.counts.valid, first.desk.message.goal) == (2, 4)

    async def second_set(room: Room) -> None:
        await room.to_the_end()
        assert (room.desk.message.status, room.desk.message.cause) == ("stopped", "valid_count")

    # A restart of the service begins no set anew.
    second = enter((SOUND,) * 5, second_set, session_id=first.live.id)
    assert second.desk.message.counts.valid == 4
    causes = [
        one.details["cause"] for one in stored(engine, first.live.id, "guidance_pause", "guidance_stop")
    ]
    assert causes == ["set", "valid_count"]


def test_a_limit_stops_within_a_packet(enter: Enter, engine: Engine, world: Any) -> None:
    channel = "thorax_humerus_right_yxy_elevation"
    limit = {"kind": "limit", "limit": 1.0, "channel": channel, "side": "above", "hold_s": 0.05}
    room = enter((SOUND, SOUND), whole, prescribe(engine, world, stops=(limit,)))
    assert room.desk.message.cause == "limit"
    assert room.desk.message.counts.valid == 0
    (stop,) = stored(engine, room.live.id, "guidance_stop")
    assert stop.details["limit"] == pytest.approx(1.0)
    assert stop.details["value"] > 0.9


def test_a_restart_loses_no_repetition(enter: Enter, engine: Engine, world: Any) -> None:
    async def half(room: Room) -> None:
        await room.to_the_start()
        await room.until(room.done.repetitions_s[1][1] + 0.6)

    prescription_id = prescribe(engine, world, repetitions=3)
    first = enter((SOUND, SOUND, SOUND, SOUND), half, prescription_id)
    assert first.desk.message.counts.valid == 2

    async def rest(room: Room) -> None:
        assert room.desk.message.counts.valid == 2
        await room.to_the_end()

    second = enter((SOUND, SOUND, SOUND, SOUND), rest, session_id=first.live.id)
    assert second.desk.message.counts.valid == 3
    assert second.desk.message.cause == "valid_count"
    assert len(stored(engine, first.live.id, "repetition")) == 3


def test_pain_outlives_a_restart(enter: Enter, engine: Engine, world: Any) -> None:
    async def half(room: Room) -> None:
        await room.to_the_start()
        await room.until(room.done.repetitions_s[0][1] + 0.6)
        room.desk.obey("pain")

    first = enter((SOUND, SOUND, SOUND), half, prescribe(engine, world))
    assert first.desk.message.counts.valid == 1

    async def rest(room: Room) -> None:
        await room.to_the_end()
        assert (room.desk.message.status, room.desk.message.cause) == ("stopped", "pain")

    second = enter((SOUND, SOUND, SOUND), rest, session_id=first.live.id)
    assert second.desk.message.counts.valid == 1


def test_a_pause_while_the_sensors_are_lost_is_a_pause(enter: Enter, engine: Engine, world: Any) -> None:
    async def work(room: Room) -> None:
        whole = room.done
        await room.to_the_start()
        first_s = whole.repetitions_s[0][1]
        await room.until(first_s + 0.5)
        # Every sensor goes silent, its link does not: a sensor that gives nothing is sent as zeros.
        silent = replace(whole.stream, counts=np.zeros_like(whole.stream.counts))
        room.done = replace(whole, stream=silent)
        await room.until(first_s + 3.5)
        assert (room.desk.message.status, room.desk.message.cause) == ("paused", "lost")
        assert room.desk.obey("pause").cause == "person"
        room.done = whole
        await room.to_the_end()
        assert (room.desk.message.status, room.desk.message.cause) == ("paused", "person")
        assert room.desk.message.counts.valid == 1

    enter((SOUND, SOUND, SOUND, SOUND), work, prescribe(engine, world))


def test_without_a_template_the_buttons_work(enter: Enter, engine: Engine, world: Any) -> None:
    async def work(room: Room) -> None:
        await room.to_the_start()
        assert room.desk.message.status == "off"
        assert room.desk.obey("pain").cause == "pain"
        assert room.desk.obey("resume").status == "off"
        await room.to_the_end()

    room = enter((SOUND,), work)
    assert len(stored(engine, room.live.id, "pain")) == 1


def test_a_guidance_that_fails_leaves_the_session_alone(
    enter: Enter, engine: Engine, world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: Any) -> Any:
        raise FloatingPointError("made to fail")

    async def work(room: Room) -> None:
        await room.to_the_start()
        monkeypatch.setattr("estimators.guidance.live.ChannelSelector.pick", broken)
        await room.to_the_end()
        assert room.live.state == "recording"
        assert room.desk.message.status == "failed"
        assert room.desk.obey("pain").cause == "pain"

    room = enter((SOUND,), work, prescribe(engine, world))
    assert len(stored(engine, room.live.id, "guidance_failed")) == 1


def test_a_second_session_of_the_day_goes_on_where_the_first_one_ended(
    enter: Enter, engine: Engine, world: Any
) -> None:
    """Six are prescribed in sets of two: three in the morning, two in the next session, and it is not yet over.

    What was done on another day by the clinic's clocks does not count.
    """
    prescription = prescribe(engine, world, repetitions=2, sets=3)
    morning = enter(GOOD_AND_SHORT, go_on_after_each_set, prescription)
    assert morning.desk.message.before == 0
    assert morning.desk.message.counts.valid == 3
    later = enter((SOUND, SOUND), go_on_after_each_set, prescription)
    assert (later.desk.message.goal, later.desk.message.before) == (6, 3)
    assert later.desk.message.counts.valid == 2
    # The set that the morning had begun ends with the first one.
    ends = stored(engine, later.live.id, "guidance_pause", "guidance_stop")
    assert [one.details["cause"] for one in ends] == ["set"]
    assert ends[0].time_s == pytest.approx(later.done.repetitions_s[0][1], abs=0.6)
    last = enter((SOUND, SOUND), go_on_after_each_set, prescription)
    assert last.desk.message.before == 5
    ends = stored(engine, last.live.id, "guidance_pause", "guidance_stop")
    assert [one.details["cause"] for one in ends] == ["valid_count"]

    # Berlin is on the next day already: what was done there before midnight was yesterday's.
    with unit_of_work(engine) as session:
        session.get_one(Clinic, world.clinic_id).time_zone = "Europe/Berlin"
        for number, made in enumerate((morning, later, last)):
            found = session.get_one(MotionSession, made.live.id)
            found.created_at = datetime(2026, 3, 4, 22 + number // 2, 50 + number, tzinfo=UTC)
            found.started_at = found.created_at
    with read_only(engine) as session:
        counted = prescribed_guidance(session, last.live.id, "UTC")
        assert counted is not None
        assert counted.dose.before == 0
        assert session.get_one(MotionSession, last.live.id).created_at.hour == 23
    with unit_of_work(engine) as session:
        session.get_one(Clinic, world.clinic_id).time_zone = None
    with read_only(engine) as session:
        counted = prescribed_guidance(session, last.live.id, "UTC")
        assert counted is not None
        assert counted.dose.before == 5


async def go_on_after_each_set(room: Room) -> None:
    await room.to_the_start()
    for _, end_s in room.done.repetitions_s:
        await room.until(end_s + 0.7)
        if room.desk.message.cause:
            room.desk.obey("resume")
    await room.to_the_end()
