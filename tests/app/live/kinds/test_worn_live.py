"""A live session whose elbow bends as none can: the direction is turned where that explains it, else it is flagged."""

import asyncio
from typing import Any, Final

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.database.unit_of_work import read_only
from app.gateway.rehearsal import Rehearsal, rehearse
from app.live.calibration.messages import CalibrationIn
from app.recordings.models import MotionSession, Result, SessionEvent
from app.recordings.signals.store import read_frames
from estimators import rotation
from estimators.conventions import Placement
from estimators.orientation import OrientationFlag
from estimators.recording import Recording
from estimators.simulation import ArmScenario, Mounting, Schedule, simulate_arm
from estimators.simulation._sensors import outward_mounting
from tests.said import codes

WORN: Final[tuple[Placement, ...]] = ("sternum", "upper_arm_right", "forearm_right")
FLEXION: Final = "humerus_forearm_right_zxy_flexion"


def drinking(turned: Placement, *, has_magnetometer: bool) -> Recording:
    """Somebody who stands, then drinks; one sensor is back to front: half a turn about its x axis, along the limb."""
    half = rotation.multiply(outward_mounting(turned), np.array([0.0, 1.0, 0.0, 0.0]))
    w, x, y, z = (float(v) for v in half)
    return simulate_arm(
        ArmScenario(
            exercise="drinking",
            placements=WORN,
            schedule=Schedule(n_pose_s=8.0, repetitions=4),
            mounting=Mounting(q_segment_sensor={turned: (w, x, y, z)}),
            has_magnetometer=has_magnetometer,
            rate_hz=50.0,
            seed=11,
        )
    ).recording


def streamed(signed_in: Any, patient_id: str, recording: Recording) -> str:
    async def run() -> str:
        async with await signed_in() as client:
            shown = Rehearsal(recording, CalibrationIn(kind="n_pose"))
            return (await rehearse(client, patient_id, shown, speed=10.0))[0]

    return asyncio.run(run())


def said(engine: Engine, session_id: str) -> list[str]:
    with read_only(engine) as session:
        kind = SessionEvent.kind == "calibration_checked"
        found = session.scalars(select(SessionEvent).where(SessionEvent.session_id == session_id, kind))
        return codes([event.text for event in found])


@pytest.mark.slow
def test_a_chest_sensor_back_to_front_is_turned(signed_in: Any, world: Any, engine: Engine) -> None:
    session_id = streamed(signed_in, world.patient_id, drinking("sternum", has_magnetometer=True))
    assert said(engine, session_id) == ["placement.back_to_front"]
    with read_only(engine) as session:
        assert session.get_one(MotionSession, session_id).setup["calibration"]["method"] == "n_pose, facing"


@pytest.mark.slow
def test_a_forearm_without_compass_is_flagged(signed_in: Any, world: Any, engine: Engine) -> None:
    session_id = streamed(signed_in, world.patient_id, drinking("forearm_right", has_magnetometer=False))
    assert said(engine, session_id) == ["placement.elbow_impossible"]
    with read_only(engine) as session:
        (result,) = session.scalars(select(Result).where(Result.session_id == session_id))
        # The analysis judges it once more, from the pose as it was found.
        assert not session.get_one(MotionSession, session_id).setup["calibration"]["contradicted"]
        frames = read_frames(session, result.id)
    flags = frames.angle_flags[:, frames.layout.angles.index(FLEXION)] & int(OrientationFlag.INVALID)
    assert flags[-1], "from when it was noticed"
    assert not flags[frames.tick_count // 4], "while the patient stood"
