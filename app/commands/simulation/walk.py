"""`telemotion simulate --walk`: a simulated person on instrumented shoes over the real socket."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, get_args

import typer

from app.commands.options.simulate import SimulateOptions
from app.errors import InvalidInput
from app.gateway import GatewayClient, GatewayReport, Milestone, ServiceClient, stream_of
from app.recordings.schemas import SessionIn
from estimators.conventions import SHOE_PLACEMENTS, SIDES, Placement
from estimators.recording import Recording
from estimators.simulation import GAIT_PRESETS, Bout, Leg, SimulatedWalk, gait_preset, simulate_gait
from estimators.simulation.faults import LinkFaults

RATE_HZ: Final = 100.0
_RECORD_AT_S: Final = 0.5
_READY_S: Final = 10.0
_ANALYSIS_TIMEOUT_S: Final = 300.0
_STAND_S: Final = 3.0


@dataclass(frozen=True, kw_only=True)
class WalkOptions(SimulateOptions):
    """Words of the command line, and whether the therapist has measured how far the feet stand apart."""

    walk: str = "centre_of_mass"
    is_apart_known: bool = True


def walk_of(options: WalkOptions) -> tuple[SimulatedWalk, Recording, float]:
    """Return the simulated walk, what its sensors send, and how far the feet stand apart.

    Raises
    ------
    InvalidInput
        For a walk that the simulator does not know.
    """
    if options.walk not in GAIT_PRESETS:
        raise InvalidInput(f"--walk is {options.walk!r}; choose one of {', '.join(GAIT_PRESETS)}")
    preset = gait_preset(options.walk, options.seed)
    course = preset.course
    if options.walk not in ("turns", "stairs"):
        course = (Bout((Leg(options.steps),), _STAND_S),)
    walked = simulate_gait(replace(preset, rate_hz=RATE_HZ, course=course))
    sensors = walked.recording.sensors
    if options.forces:
        worn: dict[str, str] = {name: name for name in SHOE_PLACEMENTS}
    else:
        worn = {f"foot_{side}": f"heel_{side}" for side in SIDES}
    worn_only = {name: sensors[of] for name, of in worn.items()}
    if not options.forces:
        worn_only = {
            name: replace(sensor, force_n=None, moment_nm=None) for name, sensor in worn_only.items()
        }
    return walked, replace(walked.recording, sensors=worn_only), preset.walk.step_width_m


async def stream(
    service: ServiceClient,
    options: WalkOptions,
    say: Callable[[str], None],
    recording: Recording | None = None,
) -> tuple[str, GatewayReport]:
    """Create a session, stream a walk, and wait until it is analysed.

    Parameters
    ----------
    service : ServiceClient
        Signed in as somebody who may treat the patient.
    recording : Recording, optional
        Sent instead of what the sensors of the simulated walk give.
    """
    _, measured, apart_m = await asyncio.to_thread(walk_of, options)
    device = stream_of(measured if recording is None else recording)
    placements = [name for placed in device.placements for name in get_args(Placement) if name == placed]
    created = await service.create_session(
        SessionIn(
            patient_id=options.patient_id,
            exercise_id=options.exercise_id,
            pipeline="gait",
            placements=placements,
            rate_hz=device.rate_hz,
            use_mounting=False,
            feet_apart_m=apart_m if options.is_apart_known else None,
        )
    )
    say(f"session {created.id}: walking, {', '.join(placements)}")

    async def record() -> None:
        # No calibration needed: connected means ready.
        await service.wait_for_state(created.id, "ready", timeout_s=_READY_S)
        await service.steer(created.id, "record")

    faults = LinkFaults(loss_fraction=options.loss_percent / 100.0, break_count=options.breaks)
    plan = device.plan(faults, options.seed)
    gateway = GatewayClient(
        options.mqtt or service.ingest_url,
        lambda: service.ticket(created.id),
        device.hello,
        pace=options.speed,
    )
    report = await gateway.run(
        device.deliveries(plan),
        breaks_s=[(float(start), float(end)) for start, end in plan.breaks_s],
        milestones=[Milestone(_RECORD_AT_S, record)],
    )
    await service.wait_for_state(created.id, "analysed", timeout_s=_ANALYSIS_TIMEOUT_S)
    return created.id, report


def simulate_walk(options: WalkOptions) -> None:
    """Run the command."""
    asyncio.run(_simulate(options))


async def _simulate(options: WalkOptions) -> None:
    async with ServiceClient(options.server) as service:
        await service.sign_in(options.email, options.password)
        session_id, report = await stream(service, options, typer.echo)
        typer.echo(
            f"session {session_id}: {report.sent} packets sent, {report.resent} sent again,"
            f" {report.unacknowledged} not acknowledged"
        )
