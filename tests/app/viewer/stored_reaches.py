"""A session of five reaches with its template and comparison, made by the real library from known angles."""

from dataclasses import dataclass, replace

import numpy as np
from sqlalchemy.orm import Session

from app.assessment.models import Comparison
from app.database.base import new_id
from app.exercises.models import Template, TemplateVersion
from app.recordings.models import MotionSession, Result, SignalChunk
from app.recordings.signals.chunks import encode_frames, frames_stream
from estimators import comparison
from estimators.arm import ArmModel, segments_from_angles
from estimators.body import BodyDimensions
from estimators.pipelines import FrameLayout, Frames, SessionSetup

PLACEMENTS = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
RATE_HZ = 50.0
REACH_M = BodyDimensions().upper_arm_m + BodyDimensions().forearm_m


def reaching_frames(
    repetitions: int = 5, duration_s: float = 2.0, height_rad: float = 1.3, lag: float = 0.0
) -> Frames:
    """Reaches out and back with a rest between; `lag` above 0 makes the way out slower than the way back."""
    rest = int(1.0 * RATE_HZ)
    share = np.arange(int(duration_s * RATE_HZ)) / (duration_s * RATE_HZ)
    turn = 0.5 + lag
    out = np.clip(share / turn, 0, 1)
    back = np.clip((share - turn) / (1 - turn), 0, 1)

    def smooth(s: np.ndarray) -> np.ndarray:
        return 10 * s**3 - 15 * s**4 + 6 * s**5

    once = smooth(out) - smooth(back)
    course = np.concatenate(
        [np.zeros(rest), *(np.concatenate([once, np.zeros(rest)]) for _ in range(repetitions))]
    )
    segments = segments_from_angles(
        {
            "trunk_lean_forward_rad": 0.12 * course,
            "thorax_humerus_right_yxy_plane_of_elevation": np.full_like(course, 1.4),
            "thorax_humerus_right_yxy_elevation": 0.1 + height_rad * course,
            "thorax_humerus_right_yxy_axial_rotation": np.full_like(course, -1.4),
            "humerus_forearm_right_zxy_flexion": 0.5 - 0.2 * course,
            "humerus_forearm_right_zxy_pronation": np.full_like(course, 1.5),
        },
        ("right",),
    )
    q = np.stack([segments[name] for name in PLACEMENTS], axis=1)
    model = ArmModel(BodyDimensions(), PLACEMENTS, 1.0 / RATE_HZ)
    found = model.evaluate(q, sigma_room_rad=np.full((len(q), 4, 3), 0.02))
    return Frames(
        layout=FrameLayout(PLACEMENTS, model.points, model.angles, model.scalars),
        first_tick=0,
        time_step_s=1.0 / RATE_HZ,
        q_room_segment=q,
        point_room_m=found.point_room_m,
        angle_rad=found.angle_rad,
        angle_sigma_rad=found.angle_sigma_rad,
        scalar=found.scalar,
        segment_flags=np.zeros((len(q), 4), np.uint8),
        angle_flags=found.angle_flags,
    )


@dataclass(frozen=True)
class Recorded:
    """Identifiers of what was stored, and what it was made of."""

    session_id: str
    live_session_id: str
    result_id: str
    template_version_id: str
    frames: Frames
    template: comparison.Template
    compared: comparison.ComparisonResult


Reaches = tuple[Frames, comparison.Template, comparison.ComparisonResult]


def compared_reaches() -> Reaches:
    """The patient reaches lower and slower outward than the therapist."""
    therapist = comparison.trajectory(reaching_frames(height_rad=1.5))
    found = comparison.find_repetitions(therapist, "right")
    template = comparison.build_template(
        therapist, found, "right", REACH_M, "thorax_humerus_right_yxy_elevation"
    )
    patient = reaching_frames(duration_s=3.0, height_rad=1.1, lag=0.2)
    return patient, template, comparison.compare(comparison.trajectory(patient), template, "right", REACH_M)


def store(
    session: Session, clinic_id: str, patient_id: str, exercise_id: str, account_id: str, reaches: Reaches
) -> Recorded:
    """An analysed session with a template made for the patient, and a session that is still running."""
    frames, template, compared = reaches
    setup = SessionSetup(pipeline="arm", placements=PLACEMENTS, rate_hz=RATE_HZ)
    common = {
        "clinic_id": clinic_id,
        "patient_id": patient_id,
        "exercise_id": exercise_id,
        "setup": setup.to_dict(),
        "created_by": account_id,
    }
    done = MotionSession(id=new_id(), state="analysed", **common)
    live = MotionSession(id=new_id(), state="recording", **common)
    session.add_all([done, live])
    session.flush()
    result = Result(
        id=new_id(),
        session_id=done.id,
        kind="offline",
        pipeline="arm",
        pipeline_version="1",
        orientation="vqf",
        orientation_version="1",
        setup=setup.to_dict(),
        layout={
            "segments": list(frames.layout.segments),
            "points": list(frames.layout.points),
            "angles": list(frames.layout.angles),
            "scalars": list(frames.layout.scalars),
        },
        status="complete",
    )
    session.add(result)
    session.flush()
    done.main_result_id = result.id
    per_chunk = int(RATE_HZ)
    for first in range(0, frames.tick_count, per_chunk):
        part = slice(first, first + per_chunk)
        arrays = (
            "q_room_segment",
            "point_room_m",
            "angle_rad",
            "angle_sigma_rad",
            "scalar",
            "segment_flags",
            "angle_flags",
        )
        chunk = encode_frames(
            replace(frames, first_tick=first, **{name: getattr(frames, name)[part] for name in arrays})
        )
        session.add(
            SignalChunk(
                session_id=done.id,
                stream=frames_stream(result.id),
                sequence=first,
                start_ns=chunk.start_ns,
                ticks=chunk.ticks,
                codec=chunk.codec,
                scale=chunk.scale,
                crc=chunk.crc,
                data=chunk.data,
            )
        )
    made = Template(
        id=new_id(),
        clinic_id=clinic_id,
        exercise_id=exercise_id,
        patient_id=patient_id,
        name="Reach",
        created_by=account_id,
    )
    session.add(made)
    session.flush()
    version = TemplateVersion(
        id=new_id(),
        template_id=made.id,
        number=1,
        source_session_id=done.id,
        source_result_id=result.id,
        repetitions=[],
        content=comparison.template_to_bytes(template),
        created_by=account_id,
    )
    session.add(version)
    session.flush()
    session.add(
        Comparison(
            id=new_id(),
            session_id=done.id,
            result_id=result.id,
            template_version_id=version.id,
            version="1",
            repetition_count=len(compared.repetitions),
            summary={"measures": []},
            content=comparison.comparison_to_bytes(compared),
        )
    )
    return Recorded(done.id, live.id, result.id, version.id, frames, template, compared)
