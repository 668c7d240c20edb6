"""Joints of stored results in other rotation sequences, with the distance to the sequence's singularity."""

from typing import get_args

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import InvalidInput
from app.recordings import service
from app.recordings.schemas import SequenceOut
from estimators.arm import Joint, Sequence, frames_in_sequence, sequence_names
from estimators.conventions import Side
from estimators.errors import EstimationError
from estimators.recording import Float
from estimators.sentences import say


def in_sequence(
    session: Session,
    subject: Subject,
    session_id: str,
    joint: Joint,
    side: Side,
    sequence: Sequence,
    result_id: str | None,
    start_s: float | None,
    end_s: float | None,
    max_points: int,
) -> SequenceOut:
    """Return one joint's angles in a sequence over a stretch of a session.

    Raises
    ------
    InvalidInput
        The sequence does not fit the joint, or the sensors it needs were not worn.
    """
    if sequence not in get_args(Sequence):
        raise InvalidInput(say("result.no_sequence", sequence=sequence), field="sequence")
    frames = service.frames(session, subject, session_id, result_id, start_s, end_s, max_points)
    try:
        found = frames_in_sequence(frames.q_room_segment, frames.layout.segments, joint, side, sequence)
    except EstimationError as error:
        raise InvalidInput(error.message, field="joint") from error
    return SequenceOut(
        names=list(sequence_names(joint, side, sequence)),
        time_s=[round(float(t), 4) for t in frames.time_s],
        angles_deg=[_plain(found.angle_rad[:, column]) for column in range(3)],
        singular_distance_deg=_plain(found.singular_distance_rad),
    )


def _plain(values: Float) -> list[float | None]:
    return [round(float(v), 3) if np.isfinite(v) else None for v in np.degrees(values)]
