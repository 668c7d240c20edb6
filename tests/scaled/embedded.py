"""What a service in one process shows of the packets that were sent through one on many machines."""

import asyncio
from pathlib import Path

from app.gateway import DeviceStream, GatewayClient, ServiceClient
from tests.benchmarks.crash import Session
from tests.benchmarks.service import EMAIL, PASSWORD, ROOMY, make_patient, open_sessions, start_server
from tests.patience import PATIENCE_S
from tests.ports import free_port
from tests.scaled.streaming import Roving

PACE = 8.0


async def _shown(port: int, patient_id: str, stream: DeviceStream, sent: Session) -> dict[int, bytes]:
    async with ServiceClient(f"http://127.0.0.1:{port}") as client:
        await client.sign_in(EMAIL, PASSWORD)
        [made] = await open_sessions(port, patient_id, stream, 1)
        one = Roving(sent.number, made["id"], [client], stream, holds=True)
        gateway = GatewayClient(client.ingest_url, lambda: client.ticket(one.id), stream.hello, pace=PACE)
        deliveries = one.deliveries()
        watching = asyncio.create_task(one.look_on())
        await gateway.run((next(deliveries) for _ in range(sent.sent)), goodbye=False)
        await asyncio.sleep(1.0)
        watching.cancel()
        await asyncio.gather(watching, return_exceptions=True)
    return one.shown


def embedded_shown(
    folder: Path, calibration: dict[str, object], stream: DeviceStream, sent: Session
) -> dict[int, bytes]:
    """Return the frames by tick.

    Parameters
    ----------
    folder : Path
        Empty.
    calibration : dict
    stream : DeviceStream
    sent : Session
        Whose packets are sent again.
    """
    url, patient_id = make_patient(folder, calibration)
    port = free_port()
    process = start_server(url, folder, port, settings=ROOMY | {"TELEMOTION_STREAM_SPEED_LIMIT": "20"})
    try:
        return asyncio.run(_shown(port, patient_id, stream, sent))
    finally:
        process.terminate()
        process.wait(PATIENCE_S)
