"""Live sessions without sockets: what a gateway's packets do to the service between its socket and a watcher's."""

from dataclasses import asdict

import numpy as np
from sqlalchemy import Engine

from app.accounts.subject import Subject
from app.database.unit_of_work import unit_of_work
from app.gateway import FULL_SCALES, DeviceStream
from app.live import repository
from app.live.manager import LiveManager
from app.live.session.intake import Intake
from app.network.declaration import check_hello
from app.patients.models import Mounting
from app.recordings import service
from app.recordings.schemas import SessionIn
from estimators.conventions import PLACEMENTS
from estimators.pipelines import Calibration


def swaying(seconds: float) -> tuple[dict[str, object], DeviceStream]:
    """Return a calibration as it is stored, and the stream of seventeen nine-axis sensors that sway a little.

    What is estimated costs the same whatever moves; a simulated exercise would take longer than all that is measured.
    """
    samples, sensors, scales = round(100.0 * seconds), len(PLACEMENTS), FULL_SCALES
    generator = np.random.default_rng(7)
    time_s = 0.01 * np.arange(samples)[:, None]
    tilt = 0.3 * np.sin(time_s + np.arange(sensors))
    rate, force, field = generator.normal(size=(3, samples, sensors, 3)) * [
        [[[4e-3]]],
        [[[2e-2]]],
        [[[2e-7]]],
    ]
    rate[..., 0] += 0.3 * np.cos(time_s + np.arange(sensors))
    force += 9.81 * np.stack((np.zeros_like(tilt), np.sin(tilt), np.cos(tilt)), axis=-1)
    field += np.stack(
        (
            np.zeros_like(tilt),
            2e-5 * np.cos(tilt) - 4e-5 * np.sin(tilt),
            -2e-5 * np.sin(tilt) - 4e-5 * np.cos(tilt),
        ),
        axis=-1,
    )
    parts = (rate / scales["gyroscope"], force / scales["accelerometer"], field / scales["magnetometer"])
    counts = np.rint(np.concatenate(parts, axis=-1) * 32767.0).astype(np.int16)
    calibration = Calibration(
        dict.fromkeys(PLACEMENTS, (1.0, 0.0, 0.0, 0.0)),
        dict.fromkeys(PLACEMENTS, (0.0, 0.0, 0.0)),
        method="n_pose",
        accelerometer_bias_mps2=dict.fromkeys(PLACEMENTS, (0.0, 0.0, 0.02)),
        mounting_sigma_rad=dict.fromkeys(PLACEMENTS, (0.02, 0.02, 0.05)),
    )
    return asdict(calibration), DeviceStream(PLACEMENTS, 100.0, counts, scales)


def remember(engine: Engine, patient_id: str, calibration: dict[str, object]) -> None:
    """Let the patient's next sessions begin calibrated."""
    with unit_of_work(engine) as session:
        session.add(Mounting(patient_id=patient_id, calibration=calibration, session_id="0" * 32))


async def connected(manager: LiveManager, subject: Subject, patient_id: str, stream: DeviceStream) -> Intake:
    """Create a session and say hello to it."""
    wanted = SessionIn(patient_id=patient_id, placements=list(stream.placements))
    with unit_of_work(manager.engine) as session:
        made = service.create(session, subject, wanted)
    assert made.calibration is not None, "little is estimated of a session that is not calibrated"
    ticket, _ = repository.give_ticket(manager.engine, subject, made.id, "ingest")
    hello = stream.hello(ticket)
    return await manager.open(hello, check_hello(hello))
