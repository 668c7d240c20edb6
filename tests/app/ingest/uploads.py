"""What tests of uploads share."""

from typing import Any

from sqlalchemy import Engine

from app.database.unit_of_work import read_only
from app.recordings.models import Job, MotionSession
from app.recordings.schemas import UploadIn

ARM = ("sternum", "upper_arm_right", "forearm_right", "hand_right")


def declare(world: Any, **changes: Any) -> UploadIn:
    return UploadIn(**{"patient_id": world.patient_id, "format": "packet_log", **changes})


def session_of(engine: Engine, job_id: str) -> MotionSession:
    with read_only(engine) as session:
        return session.get_one(MotionSession, session.get_one(Job, job_id).session_id)
