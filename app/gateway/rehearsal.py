"""A simulated person who performs each kind of calibration, step by step, over the real socket."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

from app.errors import Conflict
from app.gateway.client import GatewayClient, Milestone
from app.gateway.encoding import stream_of
from app.gateway.service import ServiceClient
from app.live.calibration.messages import CalibrationIn, CalibrationKind, CalibrationMessage
from app.recordings.schemas import SessionIn
from estimators.conventions import Placement
from estimators.orientation import DEFAULT
from estimators.recording import Recording
from estimators.simulation import (
    CALIBRATION_STYLE,
    ArmScenario,
    Schedule,
    calibration_exercise,
    calibration_ranges_s,
    simulate_arm,
    simulate_handling,
    t_pose_exercise,
)

POSE_S: Final = 9.0
"""The filters settle for three seconds, and three still seconds are needed."""
_IN_HAND: Final[tuple[Placement, ...]] = ("upper_arm_right", "forearm_right")
_IN_HAND_KINDS: Final[tuple[CalibrationKind, ...]] = ("six_position", "magnetometer")
_LEFT_S: Final = 0.1
"""Of the performance is sent after it was judged."""
_LINGER_S: Final = 20.0
_LATEST_S: Final = 60.0
_POLL_S: Final = 0.05


@dataclass(frozen=True)
class Rehearsal:
    """What the simulated person does, and when each step is begun or ended.

    Attributes
    ----------
    next_s : tuple of float
        Session times at which a step is ended by hand.
    first_pose : bool
        Hold the standing pose first: headings can be set again only after a calibration.
    """

    recording: Recording
    wanted: CalibrationIn
    next_s: tuple[float, ...] = ()
    start_s: float = 0.5
    first_pose: bool = False


def rehearsal_of(kind: CalibrationKind, scenario: ArmScenario | None = None, seed: int = 1) -> Rehearsal:
    """Return a performance of one kind of calibration.

    Parameters
    ----------
    scenario : ArmScenario, optional
        Person, sensors and mounting; what is done is put in its place.
    seed : int
        Without a scenario.
    """
    base = scenario or ArmScenario(both_arms=True, seed=seed)
    base = replace(base, style=CALIBRATION_STYLE, both_arms=True)
    schedule = Schedule(n_pose_s=POSE_S, repetitions=1)
    wanted = CalibrationIn(kind=kind)
    if kind in ("functional", "passive"):
        passive = kind == "passive"
        schedule = replace(schedule, settle_s=6.0) if passive else schedule
        ranges = calibration_ranges_s(schedule, passive=passive)
        made = simulate_arm(replace(base, exercise=calibration_exercise(passive=passive), schedule=schedule))
        ends = tuple(stop for name, (_, stop) in ranges.items() if name != "rest")
        # Seated, the rest begins after the person has sat down.
        start_s = ranges["rest"][0] if passive else 0.5
        return Rehearsal(made.recording, wanted, ends, start_s)
    if kind in ("static_bias", "six_position", "magnetometer"):
        done = {"static_bias": "lie_still", "six_position": "six_position", "magnetometer": "turn_all_ways"}
        placements = base.placements if kind == "static_bias" else _IN_HAND
        recording = simulate_handling(done[kind], placements, rate_hz=base.rate_hz, seed=base.seed)  # type: ignore[arg-type]
        return Rehearsal(recording, wanted)
    if kind == "t_pose":
        made = simulate_arm(replace(base, exercise=t_pose_exercise(), schedule=schedule))
        level_s = schedule.n_pose_s + schedule.transition_s + schedule.settle_s + schedule.pause_s + 2.0
        return Rehearsal(made.recording, wanted, start_s=level_s)
    is_reset = kind == "heading_reset"
    schedule = replace(schedule, n_pose_s=2.0 * POSE_S if is_reset else POSE_S)
    made = simulate_arm(replace(base, schedule=schedule))
    return Rehearsal(made.recording, wanted, start_s=POSE_S - 1.0 if is_reset else 0.5, first_pose=is_reset)


async def _settled(
    service: ServiceClient, session_id: str, kind: CalibrationKind, within_s: float
) -> CalibrationMessage | None:
    for _ in range(round(within_s / _POLL_S)):
        found = await service.calibration_state(session_id)
        if found is not None and found.kind == kind and found.phase in ("done", "redo"):
            return found
        await asyncio.sleep(_POLL_S)
    return None


async def rehearse(
    service: ServiceClient,
    patient_id: str,
    shown: Rehearsal,
    *,
    speed: float | None = None,
    orientation: str = DEFAULT,
    say: Callable[[str], None] = lambda text: None,
) -> tuple[str, CalibrationMessage]:
    """Create a session, stream the performance, and steer its calibration to the end.

    Returns
    -------
    (str, CalibrationMessage)
        The session, still open, and the last message: `done` or `redo`.

    Raises
    ------
    Conflict
        The calibration came to no end.
    """
    device = stream_of(shown.recording)
    created = await service.create_session(
        SessionIn(
            patient_id=patient_id,
            placements=list(device.placements),
            rate_hz=device.rate_hz,
            orientation=orientation,
            use_mounting=False,
        )
    )
    ended: list[CalibrationMessage] = []

    async def reached(time_s: float) -> None:
        for _ in range(round(_LATEST_S / _POLL_S)):
            state = await service.state(created.id)
            if state.session_time_s >= time_s - 0.3:
                return
            await asyncio.sleep(_POLL_S)

    async def pose() -> None:
        await service.calibration(created.id, "start", {"kind": "n_pose"})

    async def start() -> None:
        await reached(shown.start_s)
        message = await service.calibration(created.id, "start", shown.wanted.model_dump())
        say(message.hint)

    async def end_step(at_s: float) -> None:
        await reached(at_s)
        if not ended:
            message = await service.calibration(created.id, "next")
            say(message.hint or "evaluating")

    async def linger() -> None:
        """Stay connected: what is looked at once a second would be cancelled with the connection."""
        await _settled(service, created.id, shown.wanted.kind, _LINGER_S)

    sender = GatewayClient(service.ingest_url, partial(service.ticket, created.id), device.hello, pace=speed)
    milestones = [Milestone(0.4, pose)] if shown.first_pose else []
    milestones.append(Milestone(shown.start_s, start))
    milestones += [Milestone(at_s, partial(end_step, at_s)) for at_s in shown.next_s]
    if shown.wanted.kind in _IN_HAND_KINDS:
        end_s = max(float(sensor.time_s[-1]) for sensor in shown.recording.sensors.values())
        milestones.append(Milestone(end_s - _LEFT_S, linger))
    await sender.run(device.deliveries(device.plan()), milestones=milestones, goodbye=False)
    found = await _settled(service, created.id, shown.wanted.kind, _LATEST_S)
    if found is None:
        raise Conflict("The calibration came to no end.", session_id=created.id)
    say(f"{found.phase}, score {found.score}" + "".join(f"; {reason}" for reason in found.reasons))
    return created.id, found
