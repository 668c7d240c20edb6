"""A patient with a prescription whose template is known, and a stream in which every repetition is known."""

from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any, Final

import numpy as np
from sqlalchemy import Engine

from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Prescription, Template, TemplateVersion
from app.gateway import DeviceStream, stream_of
from estimators.comparison import Repetition, build_template, template_to_bytes, trajectory
from estimators.conventions import Placement
from estimators.pipelines import run
from estimators.simulation import (
    EXERCISES,
    ArmScenario,
    ExerciseName,
    PlannedRepetition,
    Schedule,
    demonstration_scenario,
    simulate_arm,
)
from estimators.simulation.arm.exercises import LEG_EXERCISES
from estimators.simulation.arm.scenario import leg_placements

PLACEMENTS: Final[tuple[Placement, ...]] = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
EXERCISE: Final[ExerciseName] = "flexion"
N_POSE_S: Final = 8.0
REACH_M: Final = 0.55
SOUND: Final = PlannedRepetition()
SHORT: Final = PlannedRepetition(size=0.62)
LEANING: Final = PlannedRepetition(lean_rad=float(np.radians(17.0)))


def worn(exercise: ExerciseName) -> tuple[Placement, ...]:
    """Where the sensors of an exercise of the right side sit."""
    return leg_placements("right") if exercise in LEG_EXERCISES else PLACEMENTS


@cache
def template_bytes(exercise: ExerciseName = EXERCISE) -> bytes:
    """What a therapist showed."""
    shown = demonstration_scenario("therapist_template", exercise, seed=4)
    made = simulate_arm(
        replace(shown, placements=worn(exercise), schedule=replace(shown.schedule, n_pose_s=N_POSE_S))
    )
    frames, _ = run(made.recording, made.setup, (1.5, 4.5))
    cut = [Repetition(n, float(a), float(b)) for n, (a, b) in enumerate(made.truth.repetitions_s, start=1)]
    primary = {**EXERCISES, **LEG_EXERCISES}[exercise].primary_channel.format(side="right")
    return template_to_bytes(build_template(trajectory(frames), cut, "right", REACH_M, primary))


@dataclass(frozen=True)
class Performed:
    """What a patient does: the stream of its sensors, and the truth of it.

    Attributes
    ----------
    stream : DeviceStream
    repetitions_s : ndarray, shape (R, 2)
        When each really begins and ends.
    lean_rad : ndarray, shape (ticks,)
        Of the trunk forward.
    """

    stream: DeviceStream
    repetitions_s: Any
    lean_rad: Any


@cache
def performed(
    plan: tuple[PlannedRepetition, ...], seed: int = 3, exercise: ExerciseName = EXERCISE
) -> Performed:
    """Let a patient without any impairment do what is planned."""
    made = simulate_arm(
        ArmScenario(
            exercise=exercise,
            schedule=Schedule(n_pose_s=N_POSE_S, transition_s=1.5, repetitions=None, plan=plan),
            placements=worn(exercise),
            seed=seed,
        )
    )
    return Performed(
        stream_of(made.recording),
        made.truth.repetitions_s,
        made.truth.angle_rad("trunk_lean_forward_rad"),
    )


def prescribe(
    engine: Engine,
    world: Any,
    *,
    repetitions: int = 10,
    sets: int = 1,
    stops: tuple[dict[str, Any], ...] = (),
    exercise: ExerciseName = EXERCISE,
    content: bytes | None = None,
) -> str:
    """Store the template and a prescription of it for Ada; returns the prescription."""
    therapist, content = world.accounts["therapist"], content or template_bytes(exercise)
    with unit_of_work(engine) as session:
        template = Template(
            clinic_id=world.clinic_id,
            exercise_id=world.exercise_id,
            patient_id=None,
            name="Raise",
            created_by=therapist,
        )
        session.add(template)
        session.flush()
        session.add(
            TemplateVersion(
                template_id=template.id,
                number=1,
                source_session_id="0" * 32,
                source_result_id="0" * 32,
                repetitions=[asdict(Repetition(1, 0.0, 1.0))],
                content=content,
                created_by=therapist,
            )
        )
        prescription = Prescription(
            patient_id=world.patient_id,
            exercise_id=world.exercise_id,
            template_id=template.id,
            repetitions=repetitions,
            sets=sets,
            stops=list(stops),
            prescribed_by=therapist,
            starts_at=utc_now(),
        )
        session.add(prescription)
        session.flush()
        return prescription.id
