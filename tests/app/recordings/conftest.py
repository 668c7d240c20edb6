"""Sessions with packets, straight in the database."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.database.base import new_id
from app.database.unit_of_work import unit_of_work
from app.network.raw_packet import RawPacket
from app.recordings.models import MotionSession
from estimators.pipelines import SessionSetup

PLACEMENTS = ("sternum", "upper_arm_right", "forearm_right")


def make_packet(sequence: int, *, ticks: int = 5, sensors: int = 3, counts: bool = True) -> RawPacket:
    """A packet whose content follows from its sequence, so that any mix-up shows."""
    rng = np.random.default_rng(sequence)
    table = rng.normal(0, 900, (ticks, sensors, 9))
    payload = table.astype("<i2" if counts else "<f4").tobytes()
    return RawPacket(
        sequence=sequence,
        device_time_us=7_000_000 + sequence * ticks * 10_000,
        tick_interval_us=10_000,
        sensor_count=sensors,
        tick_count=ticks,
        channel_mask=7,
        encoding=1 if counts else 0,
        flags=sequence % 4,
        payload=payload,
        arrival_ns=1_700_000_000_000_000_000 + sequence * 50_000_000,
    )


@pytest.fixture
def packet() -> Callable[..., RawPacket]:
    return make_packet


@pytest.fixture
def new_session(engine: Engine, world: Any) -> Callable[..., str]:
    """Make a session of the patient of `world`; returns its id."""

    def make(**fields: Any) -> str:
        setup = SessionSetup("arm", PLACEMENTS, 100.0)
        with unit_of_work(engine) as session:
            found = MotionSession(
                id=new_id(),
                clinic_id=world.clinic_id,
                patient_id=world.patient_id,
                setup=fields.pop("setup", setup).to_dict(),
                created_by=world.accounts["therapist"],
                **fields,
            )
            session.add(found)
        return found.id

    return make
