"""A past session of the demonstration with a magnetic source: rehearsed with a pipeline at hand, then streamed."""

import asyncio
from typing import Final

from sqlalchemy import Engine

from app.demo.dating import date_back
from app.gateway import Delivery, GatewayClient, ServiceClient
from app.gateway.relative_patient import RelativePatient
from app.kinds.magnetic.schemas import MagneticSafetyIn
from app.live.session.actuation import Actuation
from app.network.alignment import Aligner
from app.network.clock import PacketClock
from app.network.declaration import check_hello
from app.network.messages import ActuateMessage
from app.network.packet import decode_packet
from app.recordings.schemas import SessionIn
from estimators.pipelines import Frames, RelativePosePipeline, SessionSetup

DAYS_AGO: Final = 6.2
DURATION_S: Final = 45.0
MOVEMENT: Final = "shoulder"
"""Angle and distance both change where one can see it: 80 degrees and 20 cm."""
_TIMEOUT_S: Final = 120.0


def rehearse(patient: RelativePatient) -> list[Delivery]:
    """Return what the network sends when its source is asked by a pipeline of our own, without waiting for a clock.

    A source must be asked while the session runs, but the demonstration is not to be waited for. The pulses are those
    that the pipeline wanted, a packet later; the service finds them in what is sent, as in any recording.

    Parameters
    ----------
    patient : RelativePatient
        Fresh; its control is used up.
    """
    declaration = check_hello(patient.hello("rehearsal"))
    pipeline = RelativePosePipeline(setup_of(patient))
    patient.control.hear(Actuation(pipeline, lambda *_: None).plan())
    clock, aligner = PacketClock(declaration), Aligner(declaration, reorder_window_s=-1.0)
    sent = []
    for delivery in patient.deliveries():
        sent.append(delivery)
        packet = decode_packet(delivery.data, declaration)
        place = clock.admit(packet)
        chunk = aligner.push(packet, place.sequence, place.time_us)
        if chunk is not None and chunk.tick_count:
            patient.control.hear(_order(pipeline.step(chunk), len(sent)))
    return sent


def setup_of(patient: RelativePatient) -> SessionSetup:
    """Return the setup of a session in which the patient is measured."""
    return SessionSetup(
        "relative_pose", patient.placements, patient.rate_hz, orientation_parameters=patient.parameters
    )


def _order(frames: Frames, number: int) -> object:
    """Return what the frames ask for; anything else is heard as well, as a sign of life."""
    names = frames.layout.scalars
    coil, current, ticks = (
        frames.scalar[:, names.index(f"source_ask_{name}")] for name in ("coil", "current_a", "ticks")
    )
    if not (coil > 0).any():
        return None
    asked = int((coil > 0).nonzero()[0][-1])
    return ActuateMessage(
        number=number,
        coil=int(coil[asked]),
        current_a=float(current[asked]),
        on_ticks=int(ticks[asked]),
        not_before_us=0,
        not_after_us=2**62,
    )


async def make_source_session(service: ServiceClient, engine: Engine, patient_id: str) -> str:
    """Stream and date back a session in which somebody raises an arm beside a source on the pelvis; return it.

    Parameters
    ----------
    service : ServiceClient
        Signed in as the therapist, who confirms that nobody has an implant.
    """
    patient = await asyncio.to_thread(RelativePatient, MOVEMENT, DURATION_S, seed=3)
    sent = await asyncio.to_thread(rehearse, patient)
    created = await service.create_session(
        SessionIn(
            patient_id=patient_id,
            pipeline="relative_pose",
            placements=list(patient.placements),
            rate_hz=patient.rate_hz,
            orientation_parameters=patient.parameters,
            use_mounting=False,
        )
    )
    await service.confirm_no_implants(
        created.id, MagneticSafetyIn(patient_has_no_implant=True, people_nearby_have_none=True)
    )
    gateway = GatewayClient(service.ingest_url, lambda: service.ticket(created.id), patient.hello, pace=None)
    await gateway.run(iter(sent))
    await service.wait_for_state(created.id, "analysed", timeout_s=_TIMEOUT_S)
    await asyncio.to_thread(date_back, engine, created.id, DAYS_AGO)
    return created.id
