"""`telemotion simulate` over a bad link that breaks: the session is analysed, not left without a link."""

import asyncio

import pytest

from app.commands.simulation import arm


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_loss_and_breaks_end_well(signed_in, server, world, seed):
    options = arm.Options(
        server=server.address,
        patient_id=world.patient_id,
        repetitions=2,
        loss_percent=8.0,
        breaks=2,
        seed=seed,
        speed=4.0,
    )

    async def run() -> tuple[str, int]:
        async with await signed_in() as service:
            session_id, report = await arm.stream(service, options, lambda text: None)
            found = await service.session(session_id)
            return found.state, report.connections

    assert asyncio.run(run()) == ("analysed", 3)
