"""`telemotion simulate`: a simulated patient over the real socket, and the therapist who steers the session."""

import asyncio
import contextlib
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast, get_args

import typer

from app.commands.options.simulate import SimulateOptions
from app.errors import InvalidInput, TelemotionError
from app.gateway import DeviceStream, GatewayClient, GatewayReport, Milestone, ServiceClient, stream_of
from app.recordings.schemas import SessionIn
from estimators.conventions import Placement
from estimators.orientation import DEFAULT
from estimators.simulation import (
    SENSOR_PRESETS,
    ArmScenario,
    ExerciseName,
    PatientName,
    demonstration_scenario,
    simulate_arm,
)
from estimators.simulation.faults import LinkFaults

CALIBRATE_AT_S = 1.0
ANALYSIS_TIMEOUT_S = 300.0
RETRY_S = 5.0
READY_WITHIN_S = 3.0
LOSSY_POSE_S = 40.0
"""Over a bad link a gap starts the pose again, so the simulated patient holds it longer."""
CATCH_UP_SLACK_S = 0.3
CATCH_UP_POLL_S = 0.1
CATCH_UP_POLLS = 20


@dataclass(frozen=True, kw_only=True)
class Options(SimulateOptions):
    """Words of the command line, and what else the demonstration says of a session."""

    prescription_id: str | None = None
    progress: float = 0.0
    """Of the patient's recovery: 0 begins, 1 moves as the therapist."""


def scenario_of(options: Options) -> ArmScenario:
    """Return what the simulated person does.

    Raises
    ------
    InvalidInput
        A word that the simulator does not know, with the ones it knows.
    """
    _one_of("--movement", options.movement, get_args(ExerciseName))
    _one_of("--patient-kind", options.patient_kind, get_args(PatientName))
    _one_of("--arms", options.arms, ("left", "right", "both"))
    _one_of("--errors", options.errors, tuple(SENSOR_PRESETS))
    scenario = demonstration_scenario(
        cast(PatientName, options.patient_kind),
        cast(ExerciseName, options.movement),
        side="left" if options.arms == "left" else "right",
        progress=options.progress,
        repetitions=options.repetitions,
        seed=options.seed,
    )
    if options.loss_percent or options.breaks:
        scenario = replace(scenario, schedule=replace(scenario.schedule, n_pose_s=LOSSY_POSE_S))
    return replace(
        scenario,
        both_arms=options.arms == "both",
        errors=options.errors,
        orientation=options.orientation or DEFAULT,
    )


Alongside = Callable[[DeviceStream, ArmScenario, str], Coroutine[Any, Any, None]]
"""Runs beside a stream until its end, given the device, what is simulated and the session."""


def _session_of(options: Options, scenario: ArmScenario, placements: Sequence[Placement]) -> SessionIn:
    return SessionIn(
        patient_id=options.patient_id,
        exercise_id=options.exercise_id,
        prescription_id=options.prescription_id,
        purpose="template" if options.purpose == "template" else "exercise",
        placements=list(placements),
        rate_hz=scenario.rate_hz,
        orientation=options.orientation or DEFAULT,
        use_mounting=False,
    )


def _faults_of(options: Options, scenario: ArmScenario) -> LinkFaults:
    return LinkFaults(
        loss_fraction=options.loss_percent / 100.0,
        duplicate_fraction=options.duplicates_percent / 100.0,
        reorder_fraction=options.reordered_percent / 100.0,
        break_count=options.breaks,
        # A calibration pose that a break cuts short is held again: not what is to be shown.
        breaks_from_s=scenario.schedule.n_pose_s + READY_WITHIN_S,
    )


async def stream(
    service: ServiceClient,
    options: Options,
    say: Callable[[str], None],
    alongside: Alongside | None = None,
) -> tuple[str, GatewayReport]:
    """Create a session, stream it, steer it, and wait until it is analysed.

    Parameters
    ----------
    service : ServiceClient
        Signed in as somebody who may treat the patient.
    options : Options
        `speed` None sends as fast as the server takes it.
    say : callable(text)
        Called with what happens; no patient data.
    alongside : callable, optional
        May exchange what the device is about to send.

    Returns
    -------
    (str, GatewayReport)
        Identifier of the session and what happened on the way.
    """
    scenario = scenario_of(options)
    simulated = await asyncio.to_thread(simulate_arm, scenario)
    device = stream_of(simulated.recording)
    created = await service.create_session(_session_of(options, scenario, simulated.setup.placements))
    plan = device.plan(_faults_of(options, scenario), options.seed)

    async def calibrate() -> None:
        say("holding the N-pose")
        await service.steer(created.id, "calibrate")

    async def record() -> None:
        # Nothing new is sent while this waits, so it waits only for what was sent already.
        await _reached(service, created.id, scenario.schedule.n_pose_s - CATCH_UP_SLACK_S)
        await service.wait_for_state(created.id, "ready", timeout_s=READY_WITHIN_S)
        await service.steer(created.id, "record")
        say("moving")

    async def stop() -> None:
        # Faster than real time the server is behind what was sent; stopping counts from where it stands.
        await _reached(service, created.id, end_s - CATCH_UP_SLACK_S)
        await service.steer(created.id, "stop")

    end_s = float(device.packet_count * device.packet_s)
    beside = None
    if alongside is not None:
        beside = asyncio.create_task(alongside(device, scenario, created.id), name="alongside")
    try:
        report = await GatewayClient(
            options.mqtt or service.ingest_url,
            lambda: service.ticket(created.id),
            device.hello,
            pace=options.speed,
        ).run(
            device.deliveries(plan),
            breaks_s=[(float(start), float(end)) for start, end in plan.breaks_s],
            milestones=[
                Milestone(CALIBRATE_AT_S, calibrate),
                Milestone(scenario.schedule.n_pose_s, record),
                Milestone(end_s + 1.0, stop),
            ],
        )
    except TelemotionError:
        # Nobody is left who would end it.
        with contextlib.suppress(TelemotionError):
            await service.steer(created.id, "close")
        raise
    finally:
        if beside is not None:
            beside.cancel()
            await asyncio.gather(beside, return_exceptions=True)
    await service.wait_for_state(created.id, "analysed", timeout_s=ANALYSIS_TIMEOUT_S)
    return created.id, report


async def _reached(service: ServiceClient, session_id: str, time_s: float) -> None:
    """Wait until the live session stands at a session time, or stands still before it (lost at the end)."""
    last_s, unchanged = -1.0, 0
    while unchanged < CATCH_UP_POLLS:
        now_s = (await service.state(session_id)).session_time_s
        if now_s >= time_s:
            return
        unchanged = unchanged + 1 if now_s <= last_s else 0
        last_s = now_s
        await asyncio.sleep(CATCH_UP_POLL_S)


def simulate(options: Options) -> None:
    """Run the command.

    Raises
    ------
    InvalidInput
        Something that is needed was not given.
    """
    missing = [
        name
        for name, value in (
            ("--email", options.email),
            ("--password", options.password),
            ("--patient", options.patient_id),
        )
        if not value
    ]
    if missing:
        raise InvalidInput(f"{', '.join(missing)} must be given; see `telemotion simulate --help`")
    scenario_of(options)
    asyncio.run(_simulate(options))


async def _simulate(options: Options) -> None:
    async with ServiceClient(options.server) as service:
        await service.sign_in(options.email, options.password)
        round_, signed_out = 0, False
        while True:
            try:
                if signed_out:
                    await service.sign_in(options.email, options.password)
                    signed_out = False
                session_id, report = await stream(
                    service, replace(options, seed=options.seed + round_), typer.echo
                )
            except TelemotionError as error:
                if not options.forever:
                    raise
                # A sign-in ends after some hours; a stream that runs for days signs in again.
                signed_out = error.status == 401
                typer.echo(f"{error.message} Trying again.")
                round_ += 1
                await asyncio.sleep(RETRY_S)
                continue
            typer.echo(
                f"session {session_id}: {report.sent} packets sent, {report.resent} sent again, "
                f"{report.connections} connections, {report.unacknowledged} not acknowledged"
            )
            round_ += 1
            if not options.forever:
                return


def _one_of(option: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise InvalidInput(f"{option} is {value!r}; choose one of {', '.join(known)}")
