"""A simulated balance test over the real socket, with the therapist's marks."""

from collections.abc import Sequence
from functools import partial

from app.gateway import GatewayClient, Milestone, ServiceClient, stream_of
from app.recordings.schemas import SessionIn
from estimators.simulation.standing import Lean, Stance, StandingPerson, simulate_standing
from tests.patience import PATIENCE_S

TRIALS: Sequence[tuple[str, Stance | Lean]] = (
    ("eyes_open_firm", Stance(30.0)),
    ("eyes_closed_firm", Stance(30.0, 0.012, 0.009)),
    ("reach", Lean(0.25)),
)


async def new_balance_test(client: ServiceClient, patient_id: str) -> str:
    made = await client.create_session(
        SessionIn(patient_id=patient_id, pipeline="balance", placements=["pelvis", "sternum"])
    )
    return made.id


async def stream_balance_test(client: ServiceClient, session_id: str, *, pace: float = 5.0) -> StandingPerson:
    """Stand in the pose, do the trials of `TRIALS`, and end the session."""
    person = simulate_standing([trial for _, trial in TRIALS], 4)
    device = stream_of(person.recording)
    gateway = GatewayClient(client.ingest_url, partial(client.ticket, session_id), device.hello, pace=pace)

    async def calibrate() -> None:
        await client.steer(session_id, "calibrate")

    async def record() -> None:
        await client.wait_for_state(session_id, "ready", timeout_s=PATIENCE_S)
        await client.steer(session_id, "record")

    async def mark(label: str) -> None:
        await client.steer(session_id, "mark", {"label": label})

    milestones = [Milestone(0.5, calibrate), Milestone(9.0, record)]
    for (label, _), (start_s, end_s) in zip(TRIALS, person.trials_s, strict=True):
        milestones += [Milestone(start_s, partial(mark, label)), Milestone(end_s, partial(mark, "rest"))]
    await gateway.run(device.deliveries(device.plan()), milestones=milestones)
    await client.wait_for_state(session_id, "analysed", timeout_s=PATIENCE_S)
    return person
