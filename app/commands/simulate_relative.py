"""`telemotion simulate --relative`: a simulated person with a magnetic source that does what the service asks."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

import typer

from app.errors import InvalidInput
from app.gateway import GatewayClient, GatewayReport, ServiceClient
from app.gateway.relative_patient import RelativeFaults, RelativePatient
from app.recordings.magnetic_schemas import MagneticSafetyIn
from app.recordings.schemas import SessionIn

FASTEST: float = 2.0
"""Faster than this, what is asked for would come too late."""
_ANALYSIS_TIMEOUT_S = 300.0


@dataclass(frozen=True)
class RelativeOptions:
    """Words of the command line."""

    server: str
    email: str
    password: str
    patient_id: str
    movement: str = "flexion"
    duration_s: float = 60.0
    speed: float = 1.0
    seed: int = 1
    no_implants: bool = False
    breaks_s: tuple[tuple[float, float], ...] = ()
    faults: RelativeFaults = field(default_factory=RelativeFaults)


async def stream(
    service: ServiceClient, options: RelativeOptions, say: Callable[[str], None]
) -> tuple[str, GatewayReport, RelativePatient]:
    """Create a session, confirm that it is safe, stream it, and wait until it is analysed.

    Parameters
    ----------
    service : ServiceClient
        Signed in as somebody who may treat the patient.
    options : RelativeOptions
        Without `no_implants` nobody has confirmed anything, and the service refuses the gateway.
    say : callable(text)

    Returns
    -------
    (str, GatewayReport, RelativePatient)
        The session, what happened on the way, and what was simulated.
    """
    if not 0.0 < options.speed <= FASTEST:
        raise InvalidInput(f"a magnetic source needs --speed of at most {FASTEST:g}: it must answer in time")
    patient = await asyncio.to_thread(
        RelativePatient, options.movement, options.duration_s, seed=options.seed, faults=options.faults
    )
    created = await service.create_session(
        SessionIn(
            patient_id=options.patient_id,
            pipeline="relative_pose",
            placements=list(patient.placements),
            rate_hz=patient.rate_hz,
            orientation_parameters=patient.parameters,
            use_mounting=False,
        )
    )
    if options.no_implants:
        await service.confirm_no_implants(
            created.id, MagneticSafetyIn(patient_has_no_implant=True, people_nearby_have_none=True)
        )
    say(f"session {created.id}: {patient.placements[1]} against a source on {patient.placements[0]}")
    gateway = GatewayClient(
        service.ingest_url,
        lambda: service.ticket(created.id),
        patient.hello,
        pace=options.speed,
        heard=patient.control.hear,
    )
    report = await gateway.run(patient.deliveries(), breaks_s=options.breaks_s)
    account = patient.control.account
    say(
        f"{account.asked} pulses as asked, {account.by_plan} by the plan for a lost link,"
        f" {account.too_late} too late, {account.while_on} asked for while one was on"
    )
    await service.wait_for_state(created.id, "analysed", timeout_s=_ANALYSIS_TIMEOUT_S)
    return created.id, report, patient


def simulate_relative(options: RelativeOptions) -> None:
    """Run the command."""
    asyncio.run(_simulate(options))


async def _simulate(options: RelativeOptions) -> None:
    async with ServiceClient(options.server) as service:
        await service.sign_in(options.email, options.password)
        await stream(service, options, typer.echo)


__all__ = ["RelativeOptions", "simulate_relative", "stream"]
