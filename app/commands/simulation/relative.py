"""`telemotion simulate --relative`: a simulated person with a magnetic source that does what the service asks.

With `--bursts` the source fires three coils one after the other by itself; its recording is for
`telemotion process --pipeline magnetic_bursts`.
"""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import typer

from app.commands.options.simulate import SimulateOptions
from app.errors import InvalidInput
from app.gateway import GatewayClient, GatewayReport, ServiceClient
from app.gateway.relative_patient import RelativeFaults, RelativePatient
from app.gateway.source import FixedBursts
from app.kinds.magnetic.schemas import MagneticSafetyIn
from app.network.messages import ActuationPlanMessage
from app.network.packet_log import log_entry, log_head
from app.recordings.schemas import SessionIn

FASTEST: float = 2.0
"""Faster than this, what is asked for would come too late."""
_ANALYSIS_TIMEOUT_S = 300.0


@dataclass(frozen=True, kw_only=True)
class RelativeOptions(SimulateOptions):
    """Words of the command line, when the link is cut (s from the start, s without), and what goes wrong."""

    relative: str = "flexion"
    breaks_s: tuple[tuple[float, float], ...] = ()
    faults: RelativeFaults = field(default_factory=RelativeFaults)


def simulated(options: RelativeOptions) -> RelativePatient:
    """Return the person that the options describe, before the first tick."""
    return RelativePatient(
        options.relative,
        options.duration_s,
        seed=options.seed,
        faults=options.faults,
        bursts=FixedBursts() if options.bursts else None,
    )


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

    Returns
    -------
    (str, GatewayReport, RelativePatient)
        The session, what happened on the way, and what was simulated.
    """
    if options.speed is None or not 0.0 < options.speed <= FASTEST:
        raise InvalidInput(f"a magnetic source needs --speed of at most {FASTEST:g}: it must answer in time")
    patient = await asyncio.to_thread(simulated, options)
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
        options.mqtt or service.ingest_url,
        lambda: service.ticket(created.id),
        patient.hello,
        pace=options.speed,
        heard=patient.control.hear,
    )
    report = await gateway.run(patient.deliveries(), breaks_s=options.breaks_s)
    account = patient.control.account
    say(
        f"{account.asked} pulses as asked, {account.by_itself} by itself,"
        f" {account.by_plan} by the plan for a lost link,"
        f" {account.too_late} too late, {account.while_on} asked for while one was on"
    )
    await service.wait_for_state(created.id, "analysed", timeout_s=_ANALYSIS_TIMEOUT_S)
    return created.id, report, patient


def write_log(options: RelativeOptions, log: Path) -> RelativePatient:
    """Write what the network would have sent as a packet log; nobody is asked, so that the source must fire by itself.

    Parameters
    ----------
    options : RelativeOptions
        With `bursts`.

    Returns
    -------
    RelativePatient
        With the truth in its scene.

    Raises
    ------
    InvalidInput
        For a source that waits to be asked.
    """
    if not options.bursts:
        raise InvalidInput("--to writes the recording of a source that fires by itself: give --bursts too")
    patient = simulated(options)
    limit_a = patient.source.current_limit_a
    patient.control.hear(
        ActuationPlanMessage(
            coils=[1, 2, 3],
            current_a=limit_a,
            on_ticks=1,
            off_ticks=1,
            cycle_ticks=1000,
            after_s=1e6,
            current_limit_a=limit_a,
        )
    )
    hello = patient.hello("").model_dump(mode="json", exclude={"type", "ticket", "protocol_version"})
    with log.open("wb") as file:
        file.write(log_head(hello))
        for delivery in patient.deliveries():
            file.write(log_entry(delivery.data))
    return patient


def simulate_relative(options: RelativeOptions) -> None:
    """Run the command."""
    if options.log is not None:
        patient = write_log(options, options.log)
        typer.echo(
            f"{patient.duration_s:g} s of {patient.placements[1]} against a source on {patient.placements[0]},"
            f" {patient.control.account.by_itself} pulses -> {options.log}"
        )
        return
    asyncio.run(_simulate(options))


async def _simulate(options: RelativeOptions) -> None:
    async with ServiceClient(options.server) as service:
        await service.sign_in(options.email, options.password)
        await stream(service, options, typer.echo)
